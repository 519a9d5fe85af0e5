"""The node by the public interface of rclpy alone, and parameters that are set in its own process."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import lie_rigid_body

if find_spec("rclpy"):
    import rclpy
    from peer import Peer
    from rcl_interfaces.msg import ParameterEvent
    from rclpy.parameter import Parameter
    from rclpy.serialization import deserialize_message

    from lie_rigid_body.ros import session
    from lie_rigid_body.ros.control.parameters import FIXED
    from lie_rigid_body.ros.node import SimulatorNode

pytestmark = pytest.mark.ros

ROOM = Path(lie_rigid_body.__file__).parent / "ros"
EXAMPLES = Path(__file__).parents[2] / "examples"
DOORS = {"handle", "impl", "implementation_singleton", "parameter_service"}
"""Names of rclpy without an underscore that lead behind its public interface."""


def behind(tree: ast.AST) -> Iterator[str]:
    """Names behind the public interface of others: with an underscore, and of anything but ``self``, or a door."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            of_self = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            is_private = node.attr.startswith("_") and not node.attr.startswith("__")
            if node.attr in DOORS or (is_private and not of_self):
                yield node.attr
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rclpy"):
            parts = [*str(node.module).split("."), *(each.name for each in node.names)]
            yield from (part for part in parts if part in DOORS or part.startswith("_"))


def test_nothing_private_of_rclpy_is_used() -> None:
    """The package's own private names of other objects are listed."""
    paths = [*ROOM.rglob("*.py"), *EXAMPLES.rglob("*.py")]
    found = {(path.name, name) for path in paths for name in behind(ast.parse(path.read_text()))}
    assert found == set()
    seen = ["executor._executor", "node.handle", "from rclpy.impl import x", "from rclpy.node import _Node"]
    assert [len([*behind(ast.parse(line))]) for line in seen] == [1, 1, 1, 1]


@pytest.fixture
def node(isolated_ros: None) -> Iterator[SimulatorNode]:
    arguments = ["--ros-args", "-p", "rate:=50.0", "-p", "qos_overrides./pose.publisher.depth:=7"]
    with session.initialised(arguments):
        made = SimulatorNode(lambda name, namespace: {})
        with session.destroying(made):
            yield made


def set_one(node: Any, name: str, value: object) -> tuple[bool, bool]:
    """Whether it was set, and whether the reason names it."""
    [result] = node.set_parameters([Parameter(name, value=value)])
    return result.successful, name in result.reason


def test_what_is_set_in_the_process_of_the_node_is_judged_as_what_a_service_sets(node: SimulatorNode) -> None:
    assert node.get_parameter("rate").value == 50.0
    assert node.get_parameter("qos_overrides./pose.publisher.depth").value == 7
    before = node.parameters.values()
    wrong: dict[str, object] = {
        "inertia": [1.0, 2.0, 30.0],
        "rate": -1.0,
        "kicks": [1.0, 2.0],
        "method": "euler",
        "use_sim_time": True,
    }
    assert {name: set_one(node, name, value) for name, value in wrong.items()} == dict.fromkeys(wrong, (False, True))
    assert [set_one(node, name, before[name])[0] for name in FIXED] == [False] * len(FIXED)
    together = node.set_parameters_atomically([Parameter("rate", value=20), Parameter("inertia", value=[1, 1, 3])])
    assert not together.successful
    assert node.parameters.values() == before
    assert not node.get_parameter("use_sim_time").value
    whole: dict[str, tuple[object, object]] = {"rate": (20, 20.0), "inertia": ([2, 3, 4], [2.0, 3.0, 4.0])}
    for name, (given, _) in whole.items():
        assert set_one(node, name, given) == (True, False)
    assert {name: list(v) if name == "inertia" else v for name in whole for v in [node.get_parameter(name).value]} == {
        name: kept for name, (_, kept) in whole.items()
    }
    assert set_one(node, "kicks", []) == (True, False)
    assert node.get_parameter("kicks").type_ == Parameter.Type.DOUBLE_ARRAY


def test_use_sim_time_may_be_set_to_what_it_is(isolated_ros: None) -> None:
    with session.initialised(["--ros-args", "-p", "use_sim_time:=true"]):
        made = SimulatorNode(lambda name, namespace: {})
        with session.destroying(made):
            assert [set_one(made, "use_sim_time", value)[0] for value in (True, False, True)] == [True, True, False]


def test_services_of_parameters_answer_as_those_of_rclpy(node: SimulatorNode) -> None:
    """Values, types, descriptors, lists and events, of what is there and of what is not, beside a plain node."""
    with session.spinning(node), Peer("asking") as peer:
        plain = rclpy.create_node("plain", context=peer.node.context)
        peer._executor.add_node(plain)
        names = ["rate", "inertia", "method"]
        descriptors = [node.describe_parameter(name) for name in names]
        plain.declare_parameters(
            "", [(n, node.get_parameter(n).value, d) for n, d in zip(names, descriptors, strict=True)]
        )
        events = peer.listen(ParameterEvent, "/parameter_events")
        answers = [asked(peer, name, names) for name in ("lie_rigid_body", "plain")]
        assert answers[0] == answers[1]
        peer.spin_until(lambda: len(events) >= 4, "the events")
        changed = {
            each.node: [(one.name, one.value.double_value) for one in each.changed_parameters]
            for each in events
            if each.changed_parameters
        }
        assert changed == {"/lie_rigid_body": [("rate", 25.0)], "/plain": [("rate", 25.0)]}
        plain.destroy_node()


def asked(peer: Any, node: str, names: list[str]) -> list[object]:
    from rcl_interfaces import srv

    def answer(kind: Any, service: str, **request: object) -> Any:
        return peer.answer(kind, f"/{node}/{service}", kind.Request(**request))

    absent = [*names, "absent"]
    change = Parameter("rate", value=25.0).to_parameter_msg()
    return [
        *(answer(srv.GetParameters, "get_parameters", names=which).values for which in (names, absent)),
        *(answer(srv.GetParameterTypes, "get_parameter_types", names=which).types for which in (names, absent)),
        *(answer(srv.DescribeParameters, "describe_parameters", names=which).descriptors for which in (names, absent)),
        {*answer(srv.ListParameters, "list_parameters", depth=1).result.names} >= {*names, "use_sim_time"},
        answer(srv.ListParameters, "list_parameters", prefixes=["qos_overrides"]).result.names[:0],
        [result.successful for result in answer(srv.SetParameters, "set_parameters", parameters=[change]).results],
        answer(srv.SetParametersAtomically, "set_parameters_atomically", parameters=[change]).result.successful,
        answer(srv.SetParametersAtomically, "set_parameters_atomically", parameters=[]).result.successful,
    ]


@pytest.mark.parametrize("is_there", [True, False])
def test_messages_are_taken_in_bulk_also_where_there_is_no_executor_of_events(
    is_there: bool, isolated_ros: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    from std_msgs.msg import String

    if not is_there:  # as in rclpy before 7.1.4
        monkeypatch.setitem(sys.modules, "rclpy.experimental", None)
    with session.own_node("hearing") as node, session.listening(node) as spin, Peer("telling") as peer:
        heard: list[bytes] = []
        subscription = node.create_subscription(String, "told", heard.append, 100, raw=True)
        publisher = peer.node.create_publisher(String, "/told", 100)
        while not subscription.get_publisher_count() or not publisher.get_subscription_count():
            spin(0.1)
        for number in range(50):
            publisher.publish(String(data=f"{number}"))
        while len(heard) < 50:
            spin(0.1)
        assert [deserialize_message(payload, String).data for payload in heard] == [f"{number}" for number in range(50)]
