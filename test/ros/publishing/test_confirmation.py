"""Samples never wait for subscribers, late or not: one that hangs holds nobody up. Only the end does."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec

import pytest

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.ros.timing.sink import MAX_BATCH, Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

if find_spec("rclpy"):
    import rclpy
    from rclpy.publisher import Publisher
    from rclpy.qos import HistoryPolicy

    from lie_rigid_body.ros import session
    from lie_rigid_body.ros.publishing.publisher import SamplePublisher

pytestmark = pytest.mark.ros
BURSTS = 3


@pytest.fixture
def publisher() -> Iterator[SamplePublisher]:
    rclpy.init(args=[])
    node = rclpy.create_node("patient")
    yield SamplePublisher(node, stamped_twist=True, sensors=Scenario.from_parameters({}).sensors, clock=False)
    node.destroy_node()
    rclpy.try_shutdown()


@pytest.mark.parametrize("lateness_ns", [100_000, 10**9])
def test_only_the_end_waits(publisher: SamplePublisher, monkeypatch: pytest.MonkeyPatch, lateness_ns: int) -> None:
    waited: list[Publisher] = []

    def acknowledged(publisher: Publisher, timeout: object) -> bool:
        waited.append(publisher)
        return True

    monkeypatch.setattr(Publisher, "wait_for_all_acked", acknowledged)
    scenario = Scenario.from_parameters({"rate": 1000.0, "motion": "closed_form"})
    simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
    for k in range(BURSTS * MAX_BATCH):
        publisher.write(encoder.encode(simulation.take_until(simulation.clock.stamp_ns(k), 1)))
        publisher.tick(k * 1_000_000, Punctuality(lateness_ns=lateness_ns))
    assert waited == []
    publisher.close()
    assert [each.topic_name for each in waited] == ["/pose", "/twist"]


def test_with_zenoh_no_history_keeps_all(publisher: SamplePublisher, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would wait in `publish`, with the lock of the interpreter, and no service would be answered."""
    from rclpy.qos import HistoryPolicy

    found = {}
    for name in ("rmw_fastrtps_cpp", session.ZENOH):
        node = rclpy.create_node("keeping")
        monkeypatch.setattr(session, "get_rmw_implementation_identifier", lambda name=name: name)
        sensors = Scenario.from_parameters({}).sensors
        made = SamplePublisher(node, stamped_twist=True, sensors=sensors, clock=True, keep_all=True)
        topics = ("pose", "twist", "/clock")
        found[name] = {made.publishers[topic].qos_profile.history for topic in topics}
        node.destroy_node()
    assert found == {"rmw_fastrtps_cpp": {HistoryPolicy.KEEP_ALL}, session.ZENOH: {HistoryPolicy.KEEP_LAST}}


OVERRIDDEN = ["--ros-args", "-p", "qos_overrides./pose.publisher.history:=keep_all"]


def test_where_the_user_has_a_history_keep_all_messages_wait_for_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """As behind a subscriber that hangs: Fast DDS then refuses, after 100 ms."""
    scenario = Scenario.from_parameters({"rate": 1000.0, "motion": "closed_form"})
    simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
    batch = encoder.encode(simulation.take_until(0, 1))
    sent: list[str] = []
    full = True

    def publish(publisher: Publisher, message: object) -> None:
        if full and publisher.qos_profile.history is HistoryPolicy.KEEP_ALL:
            raise RuntimeError("cannot publish data, at ./src/rmw_publish.cpp:65")
        sent.append(publisher.topic_name)

    with session.initialised(OVERRIDDEN):
        node = rclpy.create_node("patient", automatically_declare_parameters_from_overrides=True)
        sink = SamplePublisher(node, stamped_twist=True, sensors=scenario.sensors, clock=False)
        monkeypatch.setattr(Publisher, "publish", publish)
        sink.write(batch)
        assert (sink.ready(), sent) == (False, [])
        full = False
        assert sink.ready()
        assert sent == ["/pose", "/twist"]
        node.destroy_node()


def test_with_zenoh_the_user_cannot_have_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "get_rmw_implementation_identifier", lambda: session.ZENOH)
    with session.initialised(OVERRIDDEN):
        node = rclpy.create_node("hasty")
        with pytest.raises(InputError) as refused:
            SamplePublisher(node, stamped_twist=True, sensors=Scenario.from_parameters({}).sensors, clock=False)
        node.destroy_node()
    assert "keep_all" in str(refused.value)
