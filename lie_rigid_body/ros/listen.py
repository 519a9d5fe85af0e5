"""``python -m lie_rigid_body.ros.listen``: poses, scenario, control and parameters, where there is no ros2 command."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from lie_rigid_body import console
from lie_rigid_body.errors import InputError, LieRigidBodyError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.wording import LONGEST_VALUE, shortened, shown

if TYPE_CHECKING:
    from geometry_msgs.msg import PoseStamped
    from rclpy.node import Node
    from rclpy.parameter_client import AsyncParameterClient

PROGRAM: Final = "python -m lie_rigid_body.ros.listen"
SHOWN_EVERY: Final = 0.2
"""Shortest time between two printed poses, s."""
LONGEST_WAIT: Final = 5.0
"""Longest wait, s: for the first pose, whose absence is then reported; for a service, and for its answer."""
SIGNAL_INTERVAL: Final = 0.1
"""Longest time between two looks whether a signal has come, s."""
NODE: Final = "/lie_rigid_body"
CALLS: Final = {
    "reset": "reset the motion, and end",
    "pause": "let time stand still, and end",
    "resume": "let time go on, and end",
    "step": "while paused send one sample, and end",
}
"""The services that an option calls, and what the help says of each."""


def main(argv: Sequence[str] | None = None) -> int:
    """Print poses until Ctrl-C, or ask the node for one thing.

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
    given = _parser().parse_args(argv)

    from lie_rigid_body.ros.sim import require_ros

    require_ros()
    with Interruption() as interruption:
        return _connected(given, interruption)


def _parser() -> console.Parser:
    parser = console.Parser("listen", "Print the poses that the node publishes, or ask the node for one thing.")
    parser.prog = PROGRAM
    parser.add_argument("--pose", metavar="TOPIC", default="/pose", help="the topic to listen to; /pose if not given")
    one = parser.add_mutually_exclusive_group()
    for name, what in CALLS.items():
        one.add_argument(f"--{name}", metavar="SERVICE", nargs="?", const=f"{NODE}/{name}", help=what)
    one.add_argument(
        "--scenario", metavar="TOPIC", nargs="?", const=f"{NODE}/scenario", help="print the latched scenario, and end"
    )
    one.add_argument("--get", metavar="NAME", help="print a parameter, and end")
    one.add_argument("--set", metavar="NAME:=VALUE", help="set a parameter, and end")
    parser.add_argument("--node", metavar="NAME", default=NODE, help=f"whose parameters; {NODE} if not given")
    return parser


def _connected(given: argparse.Namespace, interruption: Interruption) -> int:
    import rclpy

    from lie_rigid_body.ros.session import destroying, initialised, translated_errors

    with initialised([]):
        with translated_errors("a node"):
            node = rclpy.create_node("lie_rigid_body_listener")
        with destroying(node):
            return _served(given, node, interruption)


def _served(given: argparse.Namespace, node: Node, interruption: Interruption) -> int:
    for name in CALLS:
        if service := getattr(given, name):
            return trigger(node, f"--{name}", service, interruption)
    if given.scenario:
        return scenario(node, given.scenario, interruption)
    if given.get:
        return get_parameter(node, given.node, given.get, interruption)
    if given.set:
        return set_parameter(node, given.node, given.set, interruption)
    return listen(node, given.pose, interruption)


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


def scenario(node: Node, topic: str, interruption: Interruption) -> int:
    """Print the latched scenario."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    from lie_rigid_body.ros.session import translated_errors

    heard: list[Any] = []
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    with translated_errors(f"--scenario {topic!r}"):
        node.create_subscription(String, topic, heard.append, latched)
    _wait(node, lambda: bool(heard), f"nothing on {topic}", interruption)
    console.say(heard[0].data)
    return console.SUCCESS


def trigger(node: Node, option: str, service: str, interruption: Interruption) -> int:
    """Call a service of the type std_srvs/Trigger, and print its answer."""
    from std_srvs.srv import Trigger

    from lie_rigid_body.ros.session import translated_errors

    with translated_errors(f"{option} {service!r}"):
        client = node.create_client(Trigger, service)
    _wait(node, client.service_is_ready, f"no service {service}", interruption)
    answer = client.call_async(Trigger.Request())
    _wait(node, answer.done, f"no answer from {service}", interruption)
    response = answer.result()
    if not response.success:
        raise LieRigidBodyError(f"{service} refuses: {response.message}")
    console.say(response.message)
    return console.SUCCESS


def get_parameter(node: Node, remote: str, name: str, interruption: Interruption) -> int:
    """Print the value of a parameter of another node."""
    from rclpy.parameter import parameter_value_to_python

    answer = _parameters(node, remote, interruption).get_parameters([name])
    _wait(node, answer.done, f"no answer from {remote}", interruption)
    values = answer.result().values
    if not values:
        raise InputError(f"--get {name}: {remote} has no such parameter; the README lists them")
    console.say(str(parameter_value_to_python(values[0])))
    return console.SUCCESS


def set_parameter(node: Node, remote: str, assignment: str, interruption: Interruption) -> int:
    """Set a parameter of another node."""
    from rclpy.parameter import Parameter

    from lie_rigid_body.ros.session import translated_errors
    from lie_rigid_body.scenario.parameter_file import parse_assignment

    name, value = parse_assignment(assignment, "--set")
    with translated_errors(f"--set {shown(assignment)}"):
        change = Parameter(name, value=value)
    answer = _parameters(node, remote, interruption).set_parameters([change])
    _wait(node, answer.done, f"no answer from {remote}", interruption)
    result = answer.result().results[0]
    if not result.successful:
        raise InputError(f"{remote} refuses --set {shortened(name, LONGEST_VALUE)}: {result.reason}")
    console.say(f"{remote} has {name} {value}")
    return console.SUCCESS


def _parameters(node: Node, remote: str, interruption: Interruption) -> AsyncParameterClient:
    from rclpy.parameter_client import AsyncParameterClient

    from lie_rigid_body.ros.session import translated_errors

    with translated_errors(f"--node {remote!r}"):
        client = AsyncParameterClient(node, remote)
    _wait(node, client.services_are_ready, f"no node {remote}", interruption)
    return client


def _wait(node: Node, done: Callable[[], bool], complaint: str, interruption: Interruption) -> None:
    """Wait until something is done, at most `LONGEST_WAIT`."""
    end = time.monotonic() + LONGEST_WAIT
    _spin_while(node, lambda: not (done() or interruption.requested or time.monotonic() > end))
    if not done():
        if interruption.requested:
            raise KeyboardInterrupt
        raise LieRigidBodyError(f"{complaint} in domain {node.context.get_domain_id()}: is the node running?")


if __name__ == "__main__":
    sys.exit(main())
