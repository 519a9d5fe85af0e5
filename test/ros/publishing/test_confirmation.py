"""Samples in time never wait for subscribers; those that catch up, or know no time, do after each burst."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec

import pytest

from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.ros.timing.sink import MAX_BATCH, Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

if find_spec("rclpy"):
    import rclpy
    from rclpy.publisher import Publisher

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


@pytest.mark.parametrize(
    ("factor", "lateness_ns", "waits"), [(1.0, 100_000, 0), (1.0, 10**9, BURSTS), (0.0, 0, BURSTS)]
)
def test_only_those_that_catch_up_wait(
    publisher: SamplePublisher, monkeypatch: pytest.MonkeyPatch, factor: float, lateness_ns: int, waits: int
) -> None:
    waited: list[Publisher] = []

    def acknowledged(publisher: Publisher, timeout: object) -> bool:
        waited.append(publisher)
        return True

    monkeypatch.setattr(Publisher, "wait_for_all_acked", acknowledged)
    scenario = Scenario.from_parameters({"rate": 1000.0, "motion": "closed_form"})
    simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
    publisher.set_factor(factor)
    for k in range(BURSTS * MAX_BATCH):
        publisher.write(encoder.encode(simulation.take_until(simulation.clock.stamp_ns(k), 1)))
        publisher.tick(k * 1_000_000, Punctuality(lateness_ns=lateness_ns))
    pose_and_twist = 2
    assert len(waited) == waits * pose_and_twist
