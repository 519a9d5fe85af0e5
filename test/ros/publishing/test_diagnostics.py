"""What diagnostics report of a run whose clock the test holds."""

from __future__ import annotations

import time
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import pytest

from lie_rigid_body import State
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep

if find_spec("rclpy"):
    from builtin_interfaces.msg import Time

    from lie_rigid_body.ros.publishing.diagnostics import MAX_DRIFT, Diagnostics

pytestmark = pytest.mark.ros

NS = 1_000_000_000
SCENARIO = Scenario.from_parameters({"motion": "closed_form", "rate": 50.0})
OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"


@pytest.fixture
def published() -> list[Any]:
    return []


@pytest.fixture
def diagnostics(published: list[Any]) -> Diagnostics:
    stands_still = SimpleNamespace(to_msg=lambda: Time(sec=0))  # as where a node waits for /clock
    node: Any = SimpleNamespace(
        create_publisher=lambda kind, topic, qos: SimpleNamespace(publish=published.append),
        get_clock=lambda: SimpleNamespace(now=lambda: stands_still),
        get_name=lambda: "top",
        get_fully_qualified_name=lambda: "/a/top",
    )
    made = Diagnostics(node)
    made.begin_segment(Simulation(SCENARIO, NS).segment)
    return made


def values(report: Any) -> dict[str, str]:
    return {pair.key: pair.value for pair in report.status[0].values}


def test_a_report_a_second(diagnostics: Diagnostics, published: list[Any]) -> None:
    assert diagnostics.tick(5 * NS, Punctuality()) == NS
    assert diagnostics.tick(6 * NS - 1, Punctuality(49)) == 1
    assert published == []
    assert diagnostics.tick(6 * NS, Punctuality(50, 0, 1_500_000, 2_000_000)) == NS
    assert diagnostics.tick(8 * NS, Punctuality(250, 3, 0, 9_000_000)) == NS
    first, second = published
    assert abs(first.header.stamp.sec - time.time()) < 600
    assert (first.status[0].name, first.status[0].hardware_id) == ("/a/top: simulation", "top")
    assert (first.status[0].level, second.status[0].level) == (OK, WARN)
    assert len({first.status[0].message, second.status[0].message} - {""}) == 2
    assert [values(report)["samples per second"] for report in published] == ["50", "100"]
    assert float(values(first)["samples per second of simulated time"]) == 50.0
    assert [values(report)["samples sent"] for report in published] == ["50", "250"]
    assert [values(report)["missed deadlines in this interval"] for report in published] == ["0", "3"]
    assert values(first)["lateness of the latest sample (ms)"] == "1.500"
    assert values(second)["worst lateness so far (ms)"] == "9.000"
    assert values(second)["missed deadlines so far"] == "3"


def test_a_kick_is_no_drift_and_a_drift_after_it_is(diagnostics: Diagnostics, published: list[Any]) -> None:
    """Also of a body that rests, whose own energy is 0."""
    kicks = [0.5, 0.0, 0.0, 0.0, 1.0, 3.0, -1.0, 2.0]
    kicked = Scenario.from_parameters({**SCENARIO.parameters(), "kicks": kicks})
    simulation = Simulation(kicked, NS)
    diagnostics.begin_segment(simulation.segment)
    diagnostics.tick(0, Punctuality())
    for k in range(1, 6):  # the last sample is at 0.4, 0.9, ... s
        samples = simulation.take(20 if k == 1 else 25)
        diagnostics.write(BatchEncoder(kicked).encode(SimulationStep(samples)))
        diagnostics.tick(k * NS, Punctuality())
    assert [report.status[0].level for report in published] == [OK] * 5
    last = samples[-1:]
    faster = State(last.states.attitude_xyzw, (1.0 + MAX_DRIFT) * last.states.body_rate)
    diagnostics.write(BatchEncoder(kicked).encode(SimulationStep(type(last)(last.stamps_ns, faster))))
    assert diagnostics.drifts() == pytest.approx((2.0 * MAX_DRIFT, MAX_DRIFT), rel=1e-2)


@pytest.mark.parametrize(("drift", "level"), [(0.0, OK), (0.1, OK), (10.0, ERROR)])
def test_a_motion_that_drifts_is_an_error(
    diagnostics: Diagnostics, published: list[Any], drift: float, level: bytes
) -> None:
    samples = Simulation(SCENARIO, NS).take(1)
    faster = (1.0 + drift * MAX_DRIFT) * samples.states.body_rate
    drifted = type(samples)(samples.stamps_ns, State(samples.states.attitude_xyzw, faster))
    diagnostics.write(BatchEncoder(SCENARIO).encode(SimulationStep(drifted)))
    diagnostics.tick(0, Punctuality())
    diagnostics.tick(NS, Punctuality())
    [report] = published
    assert report.status[0].level == level
    momentum = float(values(report)["momentum drift since the last reset or kick (relative)"])
    assert momentum == pytest.approx(drift * MAX_DRIFT, rel=1e-2, abs=1e-15)
    energy = float(values(report)["energy drift since the last reset or kick (relative)"])
    assert energy == pytest.approx(2.0 * drift * MAX_DRIFT, rel=1e-2, abs=1e-15)
