"""``python -m lie_rigid_body.ros.listen``: print poses, or reset the motion, where there is no ros2 command."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.interruption import Interruption

if TYPE_CHECKING:
    from geometry_msgs.msg import PoseStamped
    from rclpy.node import Node

PROGRAM: Final = "python -m lie_rigid_body.ros.listen"
SHOWN_EVERY: Final = 0.2
"""Shortest time between two printed poses, s."""
LONGEST_WAIT: Final = 5.0
"""Longest wait, s: for the first pose, whose absence is then reported; for the reset service, and for its answer."""
SIGNAL_INTERVAL: Final = 0.1
"""Longest time between two looks whether a signal has come, s."""


def main(argv: Sequence[str] | None = None) -> int:
    """Print poses until Ctrl-C, or reset the motion.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0, 2 when the input is unusable or there is no answer, 130 when interrupted before an answer.
    """
    return console.status_of(PROGRAM, lambda: _main(argv))


def _main(argv: Sequence[str] | None) -> int:
    parser = console.Parser("listen", "Print the poses that the node publishes, or reset its motion.")
    parser.prog = PROGRAM
    parser.add_argument("--pose", metavar="TOPIC", default="/pose")
    parser.add_argument("--reset", metavar="SERVICE", nargs="?", const="/lie_rigid_body/reset", help="reset, and end")
    given = parser.parse_args(argv)

    from lie_rigid_body.ros.sim import require_ros

    require_ros()
    with Interruption() as interruption:
        return _connected(given.pose, given.reset, interruption)


def _connected(pose: str, service: str | None, interruption: Interruption) -> int:
    import rclpy

    from lie_rigid_body.ros.session import initialised, translated_errors

    with initialised([]):
        with translated_errors("a node"):
            node = rclpy.create_node("lie_rigid_body_listener")
        return listen(node, pose, interruption) if service is None else reset(node, service, interruption)


def listen(node: Node, topic: str, interruption: Interruption) -> int:
    """Print poses of a topic, one in `SHOWN_EVERY` seconds, until interrupted."""
    from geometry_msgs.msg import PoseStamped
    from rclpy.qos import QoSProfile

    from lie_rigid_body.ros.session import translated_errors

    shown, heard = 0.0, True

    def show(pose: PoseStamped) -> None:
        nonlocal shown, heard
        silence.cancel()
        if time.monotonic() - shown < SHOWN_EVERY:
            return
        shown = time.monotonic()
        heard = console.say(line(pose))

    def report_silence() -> None:
        silence.cancel()
        print(f"nothing yet on {topic} in domain {node.context.get_domain_id()}: is the node running?", file=sys.stderr)

    with translated_errors(f"--pose {topic!r}"):
        node.create_subscription(PoseStamped, topic, show, QoSProfile(depth=10))
    silence = node.create_timer(LONGEST_WAIT, report_silence)
    _spin_while(node, lambda: heard and not interruption.requested)
    return console.SUCCESS


def _spin_while(node: Node, wanted: Callable[[], bool]) -> None:
    """Spin while a condition holds.

    rclpy handles no signals here: it would shut down in another thread, at any moment.
    """
    from rclpy.executors import SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while wanted():
        executor.spin_once(timeout_sec=SIGNAL_INTERVAL)


def line(pose: PoseStamped) -> str:
    """A pose in one line."""
    stamp, q = pose.header.stamp, pose.pose.orientation
    return f"{stamp.sec}.{stamp.nanosec:09d} s  x {q.x:+.6f}  y {q.y:+.6f}  z {q.z:+.6f}  w {q.w:+.6f}"


def reset(node: Node, service: str, interruption: Interruption) -> int:
    """Call a reset service, and print its answer."""
    from std_srvs.srv import Trigger

    from lie_rigid_body.ros.session import translated_errors

    def waiting() -> bool:
        return not interruption.requested and time.monotonic() < end

    with translated_errors(f"--reset {service!r}"):
        client = node.create_client(Trigger, service)
    end = time.monotonic() + LONGEST_WAIT
    _spin_while(node, lambda: waiting() and not client.service_is_ready())
    if not client.service_is_ready():
        domain = node.context.get_domain_id()
        raise _unanswered(f"no service {service} in domain {domain}: is the node running?", interruption)
    answer = client.call_async(Trigger.Request())
    end = time.monotonic() + LONGEST_WAIT
    _spin_while(node, lambda: waiting() and not answer.done())
    response = answer.result()
    if response is None:
        raise _unanswered(f"{service} does not answer: is the node well?", interruption)
    if not response.success:
        raise LieRigidBodyError(f"{service} refuses: {response.message}")
    console.say(response.message)
    return console.SUCCESS


def _unanswered(complaint: str, interruption: Interruption) -> BaseException:
    return KeyboardInterrupt() if interruption.requested else LieRigidBodyError(complaint)


if __name__ == "__main__":
    sys.exit(main())
