"""A small client of the node, which prints what it hears: the poses, the latched scenario, answers and parameters."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final

from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.wording import shortened, shown, suggestion
from lie_rigid_body.ros.session import own_node, translated_errors
from lie_rigid_body.scenario.parameter_file import parse_assignment
from lie_rigid_body.scenario.parameter_table import PARAMETERS
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

SHOWN_EVERY: Final = 0.2
"""Shortest time between two printed poses, s."""
MAX_SILENCE: Final = 5.0
"""Longest wait, s, for the first pose, whose absence is then reported, for a service, and for a service's answer."""
SIGNAL_INTERVAL: Final = 0.1
"""Longest time between two looks whether a signal has come, s."""


def ask(given: argparse.Namespace, calls: Iterable[str], interruption: Interruption) -> None:
    """Carry out a command line of `listen`, whose options for ``calls`` name services.

    Raises
    ------
    LieRigidBodyError
        If there is no answer, or the node refuses.
    KeyboardInterrupt
        If interrupted before an answer.
    """
    with own_node("lie_rigid_body_listener") as node:
        client = Client(node, interruption)
        requests: dict[str, Callable[[str], None]] = {
            **{name: partial(client.trigger, f"--{name}") for name in calls},
            "scenario": client.scenario,
            "get": partial(client.get_parameter, given.node),
            "set": partial(client.set_parameter, given.node),
        }
        for option, request in requests.items():
            if value := getattr(given, option):
                return request(value)
        return client.listen(given.pose)


class Client:
    """Requests to the node, whose answers are printed.

    Parameters
    ----------
    node : Node
        The client's own node.
    interruption : Interruption
        Ends a wait.
    """

    def __init__(self, node: Node, interruption: Interruption) -> None:
        self._node = node
        self._interruption = interruption
        self._domain = node.context.get_domain_id()

    def listen(self, topic: str) -> None:
        """Print poses of a topic, one in `SHOWN_EVERY` seconds, until interrupted."""
        shown = 0.0
        heard = True

        def show(pose: PoseStamped) -> None:
            nonlocal shown, heard
            silence.cancel()
            if time.monotonic() - shown >= SHOWN_EVERY:
                shown = time.monotonic()
                heard = console.say(line(pose))

        def report_silence() -> None:
            silence.cancel()
            print(f"nothing yet on {topic} in domain {self._domain}: is the node running?", file=sys.stderr)

        with translated_errors(f"--pose {topic!r}"):
            self._node.create_subscription(PoseStamped, topic, show, QoSProfile(depth=10))
        silence = self._node.create_timer(MAX_SILENCE, report_silence)
        self._spin_while(lambda: heard and not self._interruption.requested)

    def scenario(self, topic: str) -> None:
        """Print the latched scenario."""
        heard: list[Any] = []
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        with translated_errors(f"--scenario {topic!r}"):
            self._node.create_subscription(String, topic, heard.append, latched)
        self._wait(lambda: bool(heard), f"nothing on {topic}")
        console.say(heard[0].data)

    def trigger(self, option: str, service: str) -> None:
        """Call a service of the type std_srvs/Trigger, and print its answer."""
        response = self._answer(Trigger, Trigger.Request(), service, f"{option} {service!r}", f"service {service}")
        if not response.success:
            raise LieRigidBodyError(f"{service} refuses: {response.message}")
        console.say(response.message)

    def get_parameter(self, remote: str, name: str) -> None:
        """Print the value of a parameter of another node."""
        values = self._of_node(GetParameters, GetParameters.Request(names=[name]), remote, "get_parameters").values
        if not values:
            hint = suggestion(name, [parameter.name for parameter in PARAMETERS], "parameters")
            raise InputError(f"--get {name}: {remote} has no such parameter: {hint}")
        console.say(str(parameter_value_to_python(values[0])))

    def set_parameter(self, remote: str, assignment: str) -> None:
        """Set a parameter of another node."""
        name, value = parse_assignment(assignment, "--set")
        with translated_errors(f"--set {shown(assignment)}"):
            request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        [result] = self._of_node(SetParameters, request, remote, "set_parameters").results
        if not result.successful:
            raise InputError(f"{remote} refuses --set {shortened(name)}: {result.reason}")
        console.say(f"{remote} has {name} {value}")

    def _of_node(self, kind: type, request: Any, remote: str, service: str) -> Any:
        return self._answer(kind, request, f"{remote}/{service}", f"--node {remote!r}", f"node {remote}")

    def _answer(self, kind: type, request: Any, service: str, given: str, asked: str) -> Any:
        """The answer of a service, by its full name, what the user has given for it, and what is said of it."""
        with translated_errors(given):
            client = self._node.create_client(kind, service)
        self._wait(client.service_is_ready, f"no {asked}")
        future = client.call_async(request)
        self._wait(future.done, f"no answer from {asked}")
        return future.result()

    def _wait(self, done: Callable[[], bool], complaint: str) -> None:
        """Wait until something is done, at most `MAX_SILENCE`."""
        end = time.monotonic() + MAX_SILENCE
        self._spin_while(lambda: not (done() or self._interruption.requested or time.monotonic() > end))
        if not done():
            if self._interruption.requested:
                raise KeyboardInterrupt
            raise LieRigidBodyError(f"{complaint} in domain {self._domain}: is the node running?")

    def _spin_while(self, wanted: Callable[[], bool]) -> None:
        """Spin while a condition holds.

        rclpy handles no signals here: it would shut down in another thread, at any moment.
        """
        executor = SingleThreadedExecutor()
        executor.add_node(self._node)
        while wanted():
            executor.spin_once(timeout_sec=SIGNAL_INTERVAL)


def line(pose: PoseStamped) -> str:
    """A pose in one line."""
    stamp = pose.header.stamp
    q = pose.pose.orientation
    return f"{stamp.sec}.{stamp.nanosec:09d} s  x {q.x:+.6f}  y {q.y:+.6f}  z {q.z:+.6f}  w {q.w:+.6f}"
