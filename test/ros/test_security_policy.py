"""The security policy allows what the node does, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest
from test_ros_page import full_name, names, rows

if find_spec("rclpy"):
    from peer import Peer

pytestmark = pytest.mark.ros

POLICY = ElementTree.parse(Path(__file__).parents[2] / "config" / "sros2" / "policy.xml").getroot()
NODE = "lie_rigid_body"
STANDARD = {full_name(names(service)[0]) for service, *_ in rows("### The standard simulator services")}
"""Services, and one action, of another package: the page has those of the code."""
ACTIONS = {f"/{NODE}/simulate_steps"}
# What an action is made of; ros2 security allows it with the action.
OF_AN_ACTION = {"publish": ("feedback", "status"), "reply": ("send_goal", "cancel_goal", "get_result")}


def allowed(kind: str, deed: str) -> set[str]:
    lists = [found for found in POLICY.findall(f".//profile/{kind}s") if found.get(deed) == "ALLOW"]
    return {full_name(str(name.text)) for found in lists for name in found.findall(kind)}


def offered(kind: str, deed: str) -> set[str]:
    """What the policy allows, with the parts of actions, less what is there only with packages that are missing."""
    parts = {f"{action}/_action/{name}" for action in allowed("action", "execute") for name in OF_AN_ACTION[deed]}
    missing = set() if find_spec("tf2_msgs") else {"/tf"}
    missing |= set() if find_spec("simulation_interfaces") else STANDARD | parts
    return (allowed(kind, deed) | parts) - missing


def test_policy_is_for_this_node_and_names_each_thing_once() -> None:
    assert (POLICY.tag, POLICY.get("version")) == ("policy", "0.2.0")
    [enclave] = POLICY.findall("enclaves/enclave")
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


def test_standard_services_of_the_policy_are_those_of_the_page() -> None:
    assert allowed("service", "reply") >= STANDARD - ACTIONS
    assert allowed("action", "execute") == ACTIONS < STANDARD


def seen(look: Callable[[str, str], list[tuple[str, list[str]]]]) -> set[str]:
    return {name for name, _ in look(NODE, "/")}


def test_node_does_what_it_may_listens_to_nothing_and_asks_nobody(observer: Peer) -> None:
    node = observer.node
    for look, expected in (
        (node.get_publisher_names_and_types_by_node, offered("topic", "publish")),
        (node.get_service_names_and_types_by_node, offered("service", "reply")),
    ):
        observer.spin_until(lambda look=look, expected=expected: seen(look) >= expected, "all of them")  # type: ignore[misc]
        assert seen(look) == expected
    assert seen(node.get_subscriber_names_and_types_by_node) == allowed("topic", "subscribe") == set()
    assert seen(node.get_client_names_and_types_by_node) == allowed("service", "request") == set()
