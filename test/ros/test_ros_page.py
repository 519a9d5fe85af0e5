"""What docs/ros.md says of names, parameters and qualities of service is what the node has."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from simulator_process import DEADLINE, SimulatorProcess

from lie_rigid_body.scenario.parameter_table import PARAMETERS

if find_spec("rclpy"):
    import rclpy
    from peer import Peer
    from rclpy.parameter_client import AsyncParameterClient
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
    from std_srvs.srv import Trigger

    from lie_rigid_body.ros.control.parameters import AT_ONCE, READ_ONLY
    from lie_rigid_body.ros.control.standard_services import StandardServices, snake_case

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


@pytest.fixture(scope="module")
def peer(isolated_ros: None) -> Iterator[Peer]:
    """A node beside a simulator with all sensors on."""
    rclpy.init(args=[])
    on = ("imu_rate:=20.0", "magnetometer_rate:=10.0", "publish_clock:=true")
    with SimulatorProcess(*(word for assignment in on for word in ("-p", assignment))):
        peer = Peer("reader")
        assert peer.node.create_client(Trigger, "/lie_rigid_body/step").wait_for_service(DEADLINE)
        yield peer
        peer.node.destroy_node()
    rclpy.shutdown()


def there(name: str) -> bool:
    return name != "/tf" or find_spec("tf2_msgs") is not None


def test_topics_have_their_types(peer: Peer) -> None:
    told = {full_name(names(topic)[0]): kind.replace("/", "/msg/") for topic, kind, *_ in rows("## Topics")}
    told = {name: kind for name, kind in told.items() if there(name)}

    def seen() -> dict[str, list[str]]:
        found = dict(peer.node.get_publisher_names_and_types_by_node("lie_rigid_body", "/"))
        return {name: kinds for name, kinds in found.items() if name not in ("/rosout", "/parameter_events")}

    peer.spin_until(lambda: len(seen()) >= len(told), "all topics")
    assert seen() == {name: [kind] for name, kind in told.items()}


def test_control_services_are_triggers(peer: Peer) -> None:
    def seen() -> set[str]:
        found = peer.node.get_service_names_and_types_by_node("lie_rigid_body", "/")
        return {name for name, kinds in found if kinds == ["std_srvs/srv/Trigger"]}

    told = {full_name(names(service)[0]) for service, _ in rows("## Control")}
    peer.spin_until(lambda: len(seen()) >= len(told), "all services")
    assert seen() == told


def test_qualities_of_service(peer: Peer) -> None:
    for topics, reliability, durability, _, _ in rows("## Quality of service"):
        assert reliability == "reliable"
        wanted = DurabilityPolicy.TRANSIENT_LOCAL if durability == "transient local" else DurabilityPolicy.VOLATILE
        for topic in filter(there, names(topics)):
            [info] = peer.node.get_publishers_info_by_topic(full_name(topic))
            assert (info.qos_profile.reliability, info.qos_profile.durability) == (ReliabilityPolicy.RELIABLE, wanted)


def test_qualities_that_can_be_overridden_have_parameters(peer: Peer) -> None:
    client = AsyncParameterClient(peer.node, "/lie_rigid_body")
    assert client.wait_for_services(DEADLINE)
    held = peer.wait_for(client.list_parameters(["qos_overrides"], 0)).result.names
    found = {name.removeprefix("qos_overrides.").split(".")[0] for name in held}
    told = {full_name(t) for topics, *_, yes in rows("## Quality of service") if yes == "yes" for t in names(topics)}
    assert found - {"/parameter_events"} == {name for name in told if there(name)}


def test_when_a_change_acts() -> None:
    acts = {when.split(":")[0]: set(names(parameters)) for when, parameters in rows("## Parameters while it runs")}
    assert acts["at once"] == AT_ONCE
    assert acts["never"] == READ_ONLY
    assert {parameter.name for parameter in PARAMETERS} > AT_ONCE | READ_ONLY


def test_standard_services_are_those_of_the_code() -> None:
    told = {names(service)[0] for service, _ in rows("### The standard simulator services")}
    handlers = {name for name in vars(StandardServices) if f"`~/{name}`" in PAGE}
    assert told == {f"~/{name}" for name in handlers}
    assert snake_case("SimulateSteps") in handlers
    public = {name for name in vars(StandardServices) if not name.startswith("_") and name != "offer"}
    assert handlers == public
