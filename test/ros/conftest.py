"""What the tests of the node share. This file also puts its folder, with the helpers in it, on the path of imports."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any
from weakref import WeakSet

import pytest
from simulator_process import SimulatorProcess, assignments

from ros_domains import own_domain

ROS = find_spec("rclpy") is not None
if ROS:
    from peer import NODE, Peer
    from rclpy.exceptions import InvalidHandle
    from rclpy.node import Node
    from std_srvs.srv import Trigger


@pytest.fixture(scope="session", autouse=True)
def nodes() -> Iterator[WeakSet[Node]]:
    """Nodes that this process has made, and that something still holds."""
    made: WeakSet[Node] = WeakSet()
    if not ROS:
        yield made
        return
    begin = Node.__init__

    def noted(node: Node, *arguments: Any, **options: Any) -> None:
        made.add(node)
        begin(node, *arguments, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Node, "__init__", noted)
        yield made


@pytest.fixture(autouse=True)
def no_node_is_left(nodes: WeakSet[Node]) -> Iterator[None]:
    """A program that ends in this process has destroyed its node, which later tests would meet in the graph."""
    before = living(nodes)
    yield
    assert living(nodes) <= before


def living(nodes: WeakSet[Node]) -> set[int]:
    return {id(node) for node in nodes if is_alive(node)}


def is_alive(node: Node) -> bool:
    try:
        with node.handle:
            return True
    except InvalidHandle:
        return False


@pytest.fixture(scope="module")
def full_node(isolated_ros: None) -> Iterator[SimulatorProcess]:
    """A node with all sensors, a fault and the clock on, in a domain of its own, which tests leave as they find it.

    Each file starts one: it would work on through all that comes after, for far longer than it takes to start.
    """
    sensors = {"imu_rate": 40.0, "magnetometer_rate": 10.0, "attitude_sensor_rate": 5.0, "sun_sensor_rate": 5.0}
    given = assignments(rate=25.0, **sensors, inertia="[1, 2, 2.5]", publish_clock="true")
    given += assignments(gyro_temperature_drift=1e-6)
    with own_domain() as domain, SimulatorProcess(*given, domain=domain) as running:
        yield running


@pytest.fixture(scope="module")
def module_observer(full_node: SimulatorProcess) -> Iterator[Peer]:
    with Peer("observer", full_node.domain) as peer:
        peer.spin_until(lambda: NODE.removeprefix("/") in peer.node.get_node_names(), "the node")
        peer.client(Trigger, f"{NODE}/step")  # what the node makes last: all else is known as well
        yield peer


@pytest.fixture
def observer(module_observer: Peer) -> Iterator[Peer]:
    """Another node beside `full_node`, whose subscriptions end with the test."""
    yield module_observer
    module_observer.listen_no_more()


@pytest.fixture
def domain(isolated_ros: None) -> Iterator[int]:
    """A domain for processes of one test."""
    with own_domain() as number:
        yield number


@pytest.fixture
def peer(isolated_ros: None) -> Iterator[Peer]:
    """Another node beside the one that a test starts itself: it has not met those of other tests."""
    with Peer("peer") as peer:
        yield peer
