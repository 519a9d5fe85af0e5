"""The security policy allows what the node does, and nothing else."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest

if find_spec("rclpy"):
    from peer import Peer

    from lie_rigid_body.ros.control import services as of_the_node
    from lie_rigid_body.ros.control.services import StandardServices

pytestmark = pytest.mark.ros

POLICY = Path(__file__).parents[2] / "config" / "sros2" / "policy.xml"
NODE = "lie_rigid_body"

# What the node offers only where another package is installed.
TOPICS_WITH_TF2_MSGS = {"/tf"}
STANDARD_SERVICES = {
    f"/{NODE}/{name}"
    for name in (
        *("get_simulator_features", "reset_simulation", "get_simulation_state", "set_simulation_state"),
        *("step_simulation", "get_entities", "get_entities_states", "get_entity_info", "get_entity_state"),
        "set_entity_state",
    )
}
STANDARD_ACTIONS = {f"/{NODE}/simulate_steps"}
# What an action is made of; ros2 security allows it with the action.
TOPICS_OF_AN_ACTION = ("feedback", "status")
SERVICES_OF_AN_ACTION = ("send_goal", "cancel_goal", "get_result")


def full_name(name: str) -> str:
    """A name in the policy, as ros2 security reads it for a node in the root namespace."""
    if name.startswith("~"):
        return f"/{NODE}{name[1:]}"
    return name if name.startswith("/") else f"/{name}"


def allowed(kind: str, deed: str) -> set[str]:
    profile = ElementTree.parse(POLICY).getroot().find(".//profile")
    assert profile is not None
    lists = [found for found in profile.findall(f"{kind}s") if found.get(deed) == "ALLOW"]
    return {full_name(str(name.text)) for found in lists for name in found.findall(kind)}


def parts(actions: set[str], names: tuple[str, ...]) -> set[str]:
    return {f"{action}/_action/{name}" for action in actions for name in names}


def missing(package: str, names: set[str]) -> set[str]:
    return set() if find_spec(package) else names


def test_policy_is_for_this_node_and_names_each_thing_once() -> None:
    policy = ElementTree.parse(POLICY).getroot()
    assert (policy.tag, policy.get("version")) == ("policy", "0.2.0")
    [enclave] = policy.findall("enclaves/enclave")
    [profile] = enclave.findall("profiles/profile")
    assert (enclave.get("path"), profile.get("ns"), profile.get("node")) == (f"/{NODE}", "/", NODE)
    assert {(child.tag, *child.attrib.items()) for child in profile} == {
        ("topics", ("publish", "ALLOW")),
        ("services", ("reply", "ALLOW")),
        ("actions", ("execute", "ALLOW")),
    }
    names = [str(name.text) for child in profile for name in child]
    assert len(names) == len(set(names))
    assert not any(set("*?[") & set(name) for name in names)


def test_standard_services_of_the_policy_are_those_of_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where simulation_interfaces is not installed: a stand-in takes the names."""
    package = ModuleType("simulation_interfaces")
    package.__dict__.update(srv=AnyName(), action=AnyName(), msg=AnyName())
    monkeypatch.setitem(sys.modules, "simulation_interfaces", package)
    services: list[str] = []
    actions: list[str] = []
    monkeypatch.setattr(
        of_the_node, "ActionServer", lambda node, kind, name, *rest, **settings: actions.append(full_name(name))
    )
    node: Any = SimpleNamespace(create_service=lambda kind, name, *rest, **settings: services.append(full_name(name)))
    unused: Any = None
    StandardServices(unused, unused, NODE).offer(node)
    assert sorted(services) == sorted(STANDARD_SERVICES)
    assert allowed("service", "reply") >= STANDARD_SERVICES
    assert set(actions) == STANDARD_ACTIONS == allowed("action", "execute")


class AnyName:
    """A module in which every type is found."""

    def __getattr__(self, name: str) -> object:
        return object()


def seen(look: Callable[[str, str], list[tuple[str, list[str]]]]) -> set[str]:
    return {name for name, _ in look(NODE, "/")}


def test_node_publishes_what_it_may(observer: Peer) -> None:
    expected = allowed("topic", "publish") | parts(allowed("action", "execute"), TOPICS_OF_AN_ACTION)
    expected -= missing("tf2_msgs", TOPICS_WITH_TF2_MSGS)
    expected -= missing("simulation_interfaces", parts(STANDARD_ACTIONS, TOPICS_OF_AN_ACTION))
    look = observer.node.get_publisher_names_and_types_by_node
    observer.spin_until(lambda: seen(look) >= expected, "all publishers")
    assert seen(look) == expected


def test_node_offers_what_it_may(observer: Peer) -> None:
    expected = allowed("service", "reply") | parts(allowed("action", "execute"), SERVICES_OF_AN_ACTION)
    expected -= missing("simulation_interfaces", STANDARD_SERVICES | parts(STANDARD_ACTIONS, SERVICES_OF_AN_ACTION))
    look = observer.node.get_service_names_and_types_by_node
    observer.spin_until(lambda: seen(look) >= expected, "all services")
    assert seen(look) == expected


def test_node_listens_to_nothing_and_asks_nobody(observer: Peer) -> None:
    assert seen(observer.node.get_subscriber_names_and_types_by_node) == allowed("topic", "subscribe") == set()
    assert seen(observer.node.get_client_names_and_types_by_node) == allowed("service", "request") == set()
