"""Transforms of the body in the world, and of the IMU on the body, as another library reads them."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

if find_spec("rclpy"):
    from rclpy.qos import DurabilityPolicy

    from lie_rigid_body.ros.publishing import views

pytestmark = pytest.mark.ros

NS = 1_000_000_000
STORE = get_typestore(Stores.ROS2_JAZZY)
MOVING = {"translation": "thrown", "initial_velocity": [1.0, 2.0, 3.0], "initial_position": [7.0, 8.0, 9.0]}


def send(messages: Iterable[tuple[Any, bytes]]) -> None:
    for publisher, payload in messages:
        publisher.publish(payload)


NODE: Any = None
SENDER: Any = SimpleNamespace(send=send)


@pytest.fixture
def topics(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Quality and messages of each topic; tf2_msgs is not on PyPI, and bytes are published in any case."""
    made: dict[str, Any] = {}

    def offered(node: object, kind: object, topic: str, quality: object) -> Any:
        made[topic] = SimpleNamespace(quality=quality, sent=[])
        return SimpleNamespace(publish=made[topic].sent.append)

    monkeypatch.setitem(sys.modules, "tf2_msgs", SimpleNamespace())
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", SimpleNamespace(TFMessage=object))
    monkeypatch.setattr(views, "offered", offered)
    return made


def transforms(topic: Any) -> list[Any]:
    messages: list[Any] = [STORE.deserialize_cdr(payload, "tf2_msgs/msg/TFMessage") for payload in topic.sent]
    return [transform for message in messages for transform in message.transforms]


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


@pytest.mark.parametrize("moving", [{}, MOVING, {"initial_position": [7.0, 8.0, 9.0]}])
def test_the_body_is_where_the_scenario_has_it(topics: dict[str, Any], moving: dict[str, Any]) -> None:
    scenario = Scenario.from_parameters({"world_frame": "map", "body_frame": "phone", **moving})
    simulation = Simulation(scenario, NS)
    sink = views.Transforms(NODE, SENDER)
    sink.begin_segment(simulation.segment)
    sink.write(BatchEncoder(scenario).encode(simulation.take_until(2 * NS, 100)))
    found = transforms(topics["/tf"])
    t_ns = np.arange(100) * 10_000_000
    states, centre = scenario.make_motion().at(t_ns), scenario.mass_centre().at(t_ns)
    assert [xyz(each.transform.translation) for each in found] == centre.position.tolist()
    rotations = [[*xyz(each.transform.rotation), each.transform.rotation.w] for each in found]
    assert rotations == states.attitude_xyzw.tolist()
    assert {(each.header.frame_id, each.child_frame_id) for each in found} == {("map", "phone")}
    assert not topics["/tf_static"].sent


def test_the_imu_is_at_its_lever_arm_and_late_listeners_hear_so(topics: dict[str, Any]) -> None:
    sink = views.Transforms(NODE, SENDER)
    on: dict[str, object] = {"imu_rate": 100.0, "accelerometer_lever_arm": [0.1, -0.2, 0.3], "body_frame": "phone"}
    for given in (on, {**on, "imu_frame": "phone"}, {**on, "imu_rate": 0.0}):
        sink.begin_segment(Simulation(Scenario.from_parameters(given), NS).segment)
    assert topics["/tf_static"].quality.durability == DurabilityPolicy.TRANSIENT_LOCAL
    [mounted] = transforms(topics["/tf_static"])
    assert (mounted.header.frame_id, mounted.child_frame_id) == ("phone", "imu_link")
    assert xyz(mounted.transform.translation) == [0.1, -0.2, 0.3]
    assert [*xyz(mounted.transform.rotation), mounted.transform.rotation.w] == [0.0, 0.0, 0.0, 1.0]
