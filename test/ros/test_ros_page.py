"""The node has what docs/ros.md says of names, parameters and qualities of service, and what its policy allows."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

from lie_rigid_body.foundation.wording import snake_case
from lie_rigid_body.scenario.parameter_file import CONFIG
from lie_rigid_body.scenario.parameter_table import PARAMETERS

if find_spec("rclpy"):
    from peer import Peer
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    from lie_rigid_body.ros.control.parameters import FIXED, IMMEDIATE
    from lie_rigid_body.ros.control.services import StandardServices
    from lie_rigid_body.ros.session import OF_EVERY_NODE

pytestmark = pytest.mark.ros

PAGE = (Path(__file__).parents[2] / "docs" / "ros.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Cells of the first table under a heading, without its head."""
    section = PAGE.split(f"\n{heading}\n")[1]
    [table] = re.findall(r"(?:^\|.*\n)+", section, flags=re.MULTILINE)[:1]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def full_name(name: str) -> str:
    return f"/lie_rigid_body{name[1:]}" if name.startswith("~") else f"/{name.lstrip('/')}"


OF_TF = {"/tf", "/tf_static"}


def there(name: str) -> bool:
    return name not in OF_TF or find_spec("tf2_msgs") is not None


def test_topics_have_their_types(observer: Peer) -> None:
    told = {full_name(names(topic)[0]): kind.replace("/", "/msg/") for topic, kind, *_ in rows("## Topics")}
    told = {name: kind for name, kind in told.items() if there(name)}

    def seen() -> dict[str, list[str]]:
        found = dict(observer.node.get_publisher_names_and_types_by_node("lie_rigid_body", "/"))
        of_actions = {name for name in found if "/_action/" in name}  # where simulation_interfaces is installed
        return {name: kinds for name, kinds in found.items() if name not in {*OF_EVERY_NODE, *of_actions}}

    observer.spin_until(lambda: len(seen()) >= len(told), "all topics")
    assert seen() == {name: [kind] for name, kind in told.items()}


def test_control_services_are_triggers(observer: Peer) -> None:
    def seen() -> set[str]:
        found = observer.node.get_service_names_and_types_by_node("lie_rigid_body", "/")
        return {name for name, kinds in found if kinds == ["std_srvs/srv/Trigger"]}

    told = {full_name(names(service)[0]) for service, _ in rows("## Control")}
    observer.spin_until(lambda: len(seen()) >= len(told), "all services")
    assert seen() == told


def test_qualities_of_service(observer: Peer) -> None:
    def infos(topic: str) -> list[Any]:
        return list(observer.node.get_publishers_info_by_topic(full_name(topic)))

    table = rows("## Quality of service")
    published = [topic for topics, *_ in table for topic in filter(there, names(topics))]
    observer.spin_until(lambda: all(map(infos, published)), "all publishers")
    for topics, reliability, durability, _, _ in table:
        assert reliability == "reliable"
        wanted = DurabilityPolicy.TRANSIENT_LOCAL if durability == "transient local" else DurabilityPolicy.VOLATILE
        for topic in filter(there, names(topics)):
            [info] = infos(topic)
            assert (info.qos_profile.reliability, info.qos_profile.durability) == (ReliabilityPolicy.RELIABLE, wanted)


def test_qualities_that_can_be_overridden_have_parameters(observer: Peer) -> None:
    held = observer.wait_for(observer.parameters().list_parameters(["qos_overrides"], 0)).result.names
    found = {name.removeprefix("qos_overrides.").split(".")[0] for name in held}
    told = {full_name(t) for topics, *_, yes in rows("## Quality of service") if yes == "yes" for t in names(topics)}
    assert found - {"/parameter_events"} == {name for name in told if there(name)}


def rosbag2_profiles() -> dict[str, QoSProfile]:
    """The overrides as rosbag2 reads them: a profile by the full name of its topic, of these keys with short names."""
    read: dict[str, Callable[[Any], Any]] = {
        "history": HistoryPolicy.get_from_short_key,
        "reliability": ReliabilityPolicy.get_from_short_key,
        "durability": DurabilityPolicy.get_from_short_key,
        "depth": int,
    }
    found = yaml.safe_load((CONFIG / "rosbag2" / "qos.yaml").read_text(encoding="utf-8"))
    return {
        topic: QoSProfile(**{key: read[key](value) for key, value in profile.items()})
        for topic, profile in found.items()
    }


def test_rosbag2_keeps_all_of_what_the_node_offers(observer: Peer) -> None:
    told, heard = rosbag2_profiles(), {}
    kept = [full_name(t) for topics, *_, n, _ in rows("## Quality of service") for t in names(topics) if n != "last 10"]
    assert set(told) == set(kept)
    for topic, profile in told.items():
        if topic in OF_TF:  # of which there are publishers only where tf2_msgs is installed
            continue
        assert profile.history == HistoryPolicy.KEEP_ALL
        [offered] = observer.publishers(topic)
        assert (profile.reliability, profile.durability) == (
            offered.qos_profile.reliability,
            offered.qos_profile.durability,
        )
        package, _, name = offered.topic_type.split("/")
        heard[topic] = observer.listen(getattr(import_module(f"{package}.msg"), name), topic, profile)
    observer.spin_until(lambda: all(heard.values()), "a message on each topic")
    assert f"{CONFIG.name}/rosbag2/qos.yaml\n" in PAGE.split("--qos-profile-overrides-path ")[1]


def test_when_a_change_acts() -> None:
    acts = {when.split(":")[0]: set(names(parameters)) for when, parameters in rows("## Parameters while it runs")}
    assert acts["at once"] == IMMEDIATE
    assert acts["never"] == set(FIXED)
    assert {parameter.name for parameter in PARAMETERS} > IMMEDIATE | set(FIXED)


def test_standard_services_are_those_of_the_code() -> None:
    told = {names(service)[0] for service, _ in rows("### The standard simulator services")}
    handlers = {name for name in vars(StandardServices) if f"`~/{name}`" in PAGE}
    assert told == {f"~/{name}" for name in handlers}
    assert snake_case("SimulateSteps") in handlers
    public = {name for name in vars(StandardServices) if not name.startswith("_") and name != "offer"}
    assert handlers == public


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
    missing = set() if find_spec("tf2_msgs") else OF_TF
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
