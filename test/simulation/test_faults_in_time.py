"""Faults in time: how a run is cut makes no difference, a reset begins anew, and late readings come late."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lie_rigid_body import Run
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.batch import FAULTS_TOPIC, BatchEncoder
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Fault, TransportFaults
from lie_rigid_body.sensors.fault import END_OF_TIME, Window
from lie_rigid_body.simulation import SampleClock, Simulation, SimulationStep
from lie_rigid_body.simulation.segment import Arrivals
from untyped import simulate

NS = 1_000_000_000
EPOCH = 1_234_567_890_123_456_789
EVERYTHING: dict[str, Any] = {
    "motion": "closed_form",
    "rate": 20.0,
    "imu_rate": 333.3,
    "gyro_rate": "integrated",
    "magnetometer_rate": 50.0,
    "attitude_sensor_rate": 7.0,
    "attitude_sensor_roll_noise": 1e-3,
    "sun_sensor_rate": 3.0,
    "gyro_noise_density": 1e-3,
    "imu_dropout_probability": 0.05,
    "imu_outage_interval": 0.7,
    "imu_outage_duration": 0.05,
    "imu_latency": 0.02,
    "imu_latency_jitter": 0.01,
    "imu_clock_skew": 1e-3,
    "gyro_spike_probability": 0.02,
    "gyro_noise_burst_interval": 0.5,
    "gyro_noise_burst_duration": 0.1,
    "gyro_stuck_interval": 0.6,
    "gyro_stuck_duration": 0.2,
    "accelerometer_saturation_interval": 0.4,
    "accelerometer_saturation_duration": 0.1,
    "magnetometer_temperature_drift": 1e-6,
    "magnetometer_stuck_interval": 0.9,
    "magnetometer_stuck_duration": 0.3,
    "magnetic_disturbance_interval": 1.0,
    "magnetic_disturbance_duration": 0.5,
    "attitude_sensor_latency": 0.5,
    "sun_sensor_clock_offset": 0.01,
}
SCENARIO = Scenario.from_parameters(EVERYTHING)

Message = tuple[int, str, bytes]


def messages(simulation: Simulation, taken: SimulationStep) -> list[Message]:
    return list(BatchEncoder(simulation.segment.scenario).encode(taken).in_order())


@pytest.fixture(scope="module")
def at_once() -> list[Message]:
    simulation = Simulation(SCENARIO, EPOCH)
    return messages(simulation, simulation.take_until(EPOCH + 2 * NS, 10**6))


@given(st.lists(st.tuples(st.integers(0, 400_000_000), st.integers(20, 200)), max_size=8))
@settings(max_examples=8)
def test_how_it_is_cut_makes_no_difference(at_once: list[Message], cuts: list[tuple[int, int]]) -> None:
    simulation, parts, now = Simulation(SCENARIO, EPOCH), [], EPOCH
    for later, at_most in [*cuts, (2 * NS, 1000)]:
        now = min(now + later, EPOCH + 2 * NS)
        parts += messages(simulation, simulation.take_until(now, at_most))
    while simulation.next_stamp_ns <= EPOCH + 2 * NS:
        parts += messages(simulation, simulation.take_until(EPOCH + 2 * NS, 1000))
    assert parts == at_once
    assert [time for time, *_ in parts] == sorted(time for time, *_ in parts)


def test_a_bag_in_small_batches_is_the_bag_of_arrays(tmp_path: Path) -> None:
    run = simulate(SCENARIO, duration=1.5, epoch_ns=EPOCH)
    run.to_bag(tmp_path / "run.mcap")
    simulation = Simulation(Scenario.from_parameters({**EVERYTHING, "epoch_ns": EPOCH}))
    last_ns = simulation.clock.last_ns_before(Fraction(3, 2))
    with BagWriter(tmp_path / "cut.mcap", stamped_twist=True) as bag:
        bag.begin_segment(simulation.segment)
        while simulation.next_stamp_ns < EPOCH + 3 * NS // 2:
            last = min(simulation.next_stamp_ns + 23_000_000, last_ns)
            bag.write(BatchEncoder(simulation.segment.scenario).encode(simulation.take_until(last, 70)))
    assert (tmp_path / "cut.mcap").read_bytes() == (tmp_path / "run.mcap").read_bytes()
    read: Any = Run.from_bag(tmp_path / "run.mcap")
    read.to_bag(tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == (tmp_path / "run.mcap").read_bytes()
    assert read.faults == run.faults
    assert read.imu.arrival_ns.tobytes() == run.imu.arrival_ns.tobytes()
    assert read.attitude_sensor.covariance.tobytes() == run.attitude_sensor.covariance.tobytes()
    assert run.certificate().passed


def test_a_reset_begins_anew_and_loses_what_is_under_way(tmp_path: Path) -> None:
    """Each segment has the bytes that its scenario determines, whatever came before."""
    given = {**EVERYTHING, "imu_latency": 0.2, "imu_latency_jitter": 0.0}
    simulation = Simulation(Scenario.from_parameters(given), EPOCH)
    before = messages(simulation, simulation.take_until(EPOCH + NS + 1, 10**6))
    start = simulation.reset(Scenario.from_parameters(given)).start_ns
    after = []
    while simulation.next_stamp_ns <= start + NS + 1:
        after += messages(simulation, simulation.take_until(start + NS + 1, 10**6))
    assert before[-1][0] <= EPOCH + NS + 1 < start
    readings = [time for time, topic, _ in before + after if topic == "imu/data_raw"]
    assert not [time for time in readings if start <= time < start + 200_000_000]
    assert [time for time in readings if start - 50_000_000 < time < start]
    told = [Fault.from_json(decode_string(data)) for _, topic, data in before + after if topic == FAULTS_TOPIC]
    assert [fault.begin_ns for fault in told] == sorted(fault.begin_ns for fault in told)
    # the start lies off the IMU's grid: only what does not depend on it repeats
    first, second = (
        [fault for fault in told if fault.kind == "noise_burst" and begin <= fault.begin_ns < begin + NS]
        for begin in (EPOCH, start)
    )
    assert [fault.later(start - EPOCH) for fault in first] == second


@given(
    rate=st.sampled_from([3.0, 100.0, 333.3, 1000.0]),
    latency_ns=st.integers(0, 10**8),
    jitter_ns=st.integers(0, 10**8),
    first=st.integers(0, 50),
    at=st.integers(-(10**9), 10**9),
)
def test_readings_are_counted_when_they_have_arrived(
    rate: float, latency_ns: int, jitter_ns: int, first: int, at: int
) -> None:
    clock = SampleClock(EPOCH, rate)
    start = clock.stamp_ns(first)
    window = Window(0, END_OF_TIME)
    delivery = TransportFaults("imu", 3, window, 0.0, None, latency_ns / 1e9, jitter_ns / 1e9, 0.0, 0.0)
    arrivals = Arrivals(clock, first, start, delivery)
    times, *_ = arrivals.of(first, clock.stamps_ns(first, 1500))
    assert (np.diff(times) >= 0).all()
    numbers = range(first, first + 1500, 97)
    assert [arrivals.stamp_ns(number) for number in numbers] == times[::97][: len(numbers)].tolist()
    expected = int(np.searchsorted(times, start + at, side="right"))
    if start + at <= times[-1]:
        assert max(0, arrivals.count_until(start + at) - first) == expected


def test_a_run_that_loses_every_reading_ends() -> None:
    simulation = Simulation(Scenario.from_parameters({"imu_rate": 100.0, "imu_dropout_probability": 1.0}))
    taken = simulation.take_until(2**63, 50)
    assert (len(taken.samples), len(taken.faults)) == (50, 50)
    assert not len(taken.sensors["imu"])


@pytest.mark.parametrize("at_most", [1, 2, 1000])
def test_faults_are_told_up_to_the_last_message(at_most: int) -> None:
    """Not up to the end of the time that was asked for: a run cut at that message would lack them."""
    given = {"motion": "closed_form", "rate": 1.0, "imu_rate": 1.0, "gyro_noise_burst_interval": 0.1}
    simulation = Simulation(Scenario.from_parameters({**given, "gyro_noise_burst_duration": 0.01}))
    told: list[Fault] = []
    while simulation.next_stamp_ns <= 5 * NS + NS // 2:
        told += simulation.take_until(5 * NS + NS // 2, at_most).faults
    assert [fault.begin_ns // (NS // 10) for fault in told] == list(range(50))


@pytest.mark.parametrize("after_ns", [0, NS // 3, NS])
def test_those_before_a_reset_are_told_as_if_there_was_none(after_ns: int) -> None:
    one, other = Simulation(SCENARIO, EPOCH), Simulation(SCENARIO, EPOCH)
    told = list(one.take_until(EPOCH + after_ns, 1000).faults)
    start = one.reset(SCENARIO).start_ns
    told += one.take_until(start + NS, 1000).faults
    expected = other.take_until(start + NS, 1000).faults
    before = [fault for fault in expected if fault.begin_ns < start]
    assert before
    assert [fault for fault in told if fault.begin_ns < start] == before


def test_what_is_lost_after_a_reset_is_what_is_told() -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form", "imu_rate": 100.0, "imu_dropout_probability": 0.3})
    simulation = Simulation(scenario, EPOCH)
    simulation.take_until(EPOCH + NS // 2, 1000)
    start = simulation.reset(scenario).start_ns
    taken = simulation.take_until(start + 2 * NS, 1000)
    lost = [fault.begin_ns for fault in taken.faults if fault.begin_ns >= start]
    received = taken.sensors["imu"].stamps_ns[taken.sensors["imu"].stamps_ns >= start].tolist()
    assert sorted(lost + received) == list(range(start, start + 2 * NS + 1, 10_000_000))


@pytest.mark.parametrize(
    ("parameters", "most"),
    [
        ({"imu_rate": 1e9, "imu_latency": 1.0, "imu_dropout_probability": 1.0}, 130),
        ({"rate": 1e-6, "imu_rate": 1e-3, "gyro_stuck_interval": 1e-3, "gyro_stuck_duration": 1e-4}, 130),
    ],
)
def test_faults_of_readings_under_way_come_in_parts(parameters: dict[str, float], most: int) -> None:
    # made at once until the next message they are millions
    simulation = Simulation(Scenario.from_parameters({"epoch_ns": 0, "sensor_seed": 1, **parameters}))
    simulation.take_until(0, 64)
    parts = [simulation.take_until(10**10, 64).faults for _ in range(50)]
    assert all(len(part) <= most for part in parts)
    told = [fault for part in parts for fault in part]
    other = Simulation(Scenario.from_parameters({"epoch_ns": 0, "sensor_seed": 1, **parameters}))._faults
    assert len(told) >= 3000
    assert told == list(other.take(told[-1].begin_ns))[-len(told) :]
