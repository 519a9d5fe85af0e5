"""Sensors beside the truth: it does not feel them, and each of their stamps comes once, with what was true then."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lie_rigid_body import ClosedForm
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.messages.batch import POSE, TWIST, BatchEncoder
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep

EPOCH = 1_234_567_890_123_456_789
NORTH_AND_DOWN = [1e-6, 2e-5, -4e-5]
NS = 1_000_000_000
BODY = {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "initial_body_rate": [0.7, -1.3, 0.4]}
RATES = {"rate": 59.94, "imu_rate": 333.3, "magnetometer_rate": 7.0}
ORDER = [POSE, TWIST, "imu/data_raw", "imu/bias", "imu/mag"]

Message = tuple[int, str, bytes]


def scenario(**given: object) -> Scenario:
    return Scenario.from_parameters({"motion": "closed_form", **BODY, **given})


def definition(rate: float, first_ns: int, until_ns: int) -> list[int]:
    """The stamps of the definition, from one to another."""
    period, stamps, k = NS / Fraction(repr(rate)), [], 0
    while EPOCH + round(k * period) <= until_ns:
        stamps.append(EPOCH + round(k * period))
        k += 1
    return [stamp for stamp in stamps if stamp >= first_ns]


def messages(simulation: Simulation, taken: SimulationStep) -> list[Message]:
    return list(BatchEncoder(simulation.segment.scenario).encode(taken).in_order())


class Stamps:
    """The stamps that came out of a simulation."""

    def __init__(self) -> None:
        self.truth: list[int] = []
        self.imu: list[int] = []
        self.field: list[int] = []

    def add(self, taken: SimulationStep) -> None:
        self.truth += taken.samples.stamps_ns.tolist()
        self.imu += taken.sensors["imu"].stamps_ns.tolist()
        self.field += taken.sensors["magnetometer"].stamps_ns.tolist()


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_the_truth_does_not_feel_the_sensors(motion: str) -> None:
    alone = Simulation(scenario(motion=motion, rate=59.94))
    beside = Simulation(scenario(motion=motion, **RATES, gyro_noise_density=1e-3, gyro_bias_random_walk=1e-4))
    for until in (3 * 10**8, 10**9, 3 * 10**9):
        one, other = (simulation.take_until(until, 10**6).samples for simulation in (alone, beside))
        assert one.stamps_ns.tobytes() == other.stamps_ns.tobytes()
        assert one.states.attitude_xyzw.tobytes() == other.states.attitude_xyzw.tobytes()
        assert one.states.body_rate.tobytes() == other.states.body_rate.tobytes()


@pytest.mark.parametrize("rate", [3.0, 7.0, 29.97, 333.3, 999.9, 1024.0, 48000.0])
def test_stamps_of_a_sensor_are_those_of_the_definition(rate: float) -> None:
    simulation, seen = Simulation(scenario(imu_rate=rate, magnetometer_rate=rate), EPOCH), Stamps()
    until = EPOCH + round(200 * NS / rate)
    while simulation.next_stamp_ns <= until:
        seen.add(simulation.take_until(until, 17))
    assert seen.imu == seen.field == definition(rate, EPOCH, until)


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 40_000_000), st.booleans()), max_size=30))
def test_each_stamp_comes_once_whatever_the_resets(events: list[tuple[int, bool]]) -> None:
    """Resets at once one after the other, and between the samples of the truth, among them."""
    simulation, seen, now = Simulation(scenario(**RATES), EPOCH), Stamps(), EPOCH
    for later, with_reset in [*events, (0, False)]:
        now += later
        if with_reset:
            simulation.reset(scenario(**RATES, initial_body_rate=[0.0, 1.0, later * 1e-9]))
        while simulation.next_stamp_ns <= now:
            seen.add(simulation.take_until(now, 5))
    assert seen.truth == definition(59.94, EPOCH, now)
    assert seen.imu == definition(333.3, EPOCH, now)
    assert seen.field == definition(7.0, EPOCH, now)


@pytest.mark.parametrize("at_ns", [0, 1, 10_000_000, 16_683_350, 123_456_789])
def test_another_rate_leaves_no_gap_and_no_overlap(at_ns: int) -> None:
    simulation, seen = Simulation(scenario(**RATES), EPOCH), Stamps()
    seen.add(simulation.take_until(EPOCH + at_ns, 10**6))
    segment = simulation.reset(scenario(rate=100.0, imu_rate=250.0, magnetometer_rate=30.0))
    start = segment.start_ns
    assert (start, segment.first_sample) == (definition(59.94, EPOCH + at_ns + 1, EPOCH + NS)[0], 0)
    while simulation.next_stamp_ns <= start + NS // 10:
        seen.add(simulation.take_until(start + NS // 10, 10**6))
    for stamps, before, after in ((seen.truth, 59.94, 100.0), (seen.imu, 333.3, 250.0), (seen.field, 7.0, 30.0)):
        old = definition(before, EPOCH, start - 1)
        assert stamps[: len(old)] == old
        assert stamps[len(old) :] == [start + round(k * NS / after) for k in range(int(0.1 * after) + 1)]


CHANGES = [{"imu_frame": "elsewhere"}, {"imu_orientation": True}, {"gyro_noise_density": 1.0, "rate": 10.0}]


@pytest.mark.parametrize("change", CHANGES, ids=str)
def test_what_was_read_before_a_reset_is_told_as_if_there_was_none(change: dict[str, object]) -> None:
    """In the frame, with the covariances and with the fields of the scenario that made it."""
    one, other = (Simulation(scenario(rate=3.0, imu_rate=100.0, magnetometer_rate=70.0), EPOCH) for _ in range(2))
    one.take_until(EPOCH, 10)
    start = one.reset(scenario(**{"rate": 3.0, "imu_rate": 100.0, "magnetometer_rate": 70.0, **change})).start_ns
    told: list[tuple[int, str, bytes]] = []
    while one.next_stamp_ns <= start + NS:
        told += messages(one, one.take_until(start + NS, 40))
    expected = messages(other, other.take_until(start - 1, 10**6))
    before = [message for message in told if message[0] < start]
    assert before == [message for message in expected if message[0] > EPOCH]
    assert len(before) > 80


def test_sensors_feel_a_reset_from_its_stamp_on() -> None:
    """What they read before is of the motion before, also if it is taken after."""
    simulation = Simulation(scenario(rate=10.0, imu_rate=100.0), EPOCH)
    simulation.take_until(EPOCH + 20_000_000, 100)
    segment = simulation.reset(scenario(rate=10.0, imu_rate=100.0, initial_body_rate=[0.0, 0.0, 2.0]))
    parts = [simulation.take_until(segment.start_ns + 200_000_000, 100).sensors["imu"] for _ in range(2)]
    imu = parts[0].joined(parts)
    old, new = (ClosedForm(s.body(), s.start()) for s in (scenario(), segment.scenario))
    before = imu.stamps_ns < segment.start_ns
    assert before.sum() == 7
    for part, motion, start in ((before, old, EPOCH), (~before, new, segment.start_ns)):
        true = motion.at(imu.stamps_ns[part] - start).body_rate
        np.testing.assert_allclose(imu.arrays["gyro"][part], true, rtol=0, atol=1e-14)


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_readings_are_of_the_state_at_their_stamps(motion: str) -> None:
    given = {"accelerometer_mode": "pivot_gravity", "gravity": 9.81, "magnetic_field": NORTH_AND_DOWN}
    simulation = Simulation(scenario(motion=motion, **RATES, **given), EPOCH)
    taken = simulation.take_until(EPOCH + 2 * NS, 10**6)
    truth = ClosedForm(simulation.segment.scenario.body(), simulation.segment.scenario.start())
    imu, compass = taken.sensors["imu"], taken.sensors["magnetometer"]
    at_imu, at_field = (truth.at(track.stamps_ns - EPOCH) for track in (imu, compass))
    np.testing.assert_allclose(imu.arrays["gyro"], at_imu.body_rate, rtol=0, atol=1e-9)
    up, field = (
        Rotation.from_quat(states.attitude_xyzw).inv().apply(vector)
        for states, vector in ((at_imu, [0.0, 0.0, 9.81]), (at_field, NORTH_AND_DOWN))
    )
    np.testing.assert_allclose(imu.arrays["specific_force"], up, rtol=0, atol=1e-7)
    np.testing.assert_allclose(compass.arrays["field"], field, rtol=0, atol=1e-13)


def test_at_equal_stamps_the_truth_comes_first() -> None:
    simulation = Simulation(scenario(rate=100.0, imu_rate=200.0, magnetometer_rate=50.0), EPOCH)
    found = messages(simulation, simulation.take_until(EPOCH + NS, 10**6))
    places = [(stamp, ORDER.index(topic)) for stamp, topic, _ in found]
    assert places == sorted(places)
    assert [topic for stamp, topic, _ in found if stamp == EPOCH] == ORDER
    assert len(found) == 2 * 101 + 2 * 201 + 51


def test_a_reset_computes_nothing_ahead() -> None:
    """Between samples of a day's distance an IMU has many millions of readings."""
    scenario = Scenario.from_parameters({"rate": 1e-5, "imu_rate": 1e6, "motion": "closed_form"})
    simulation = Simulation(scenario)
    first = simulation.take_until(0, 1)
    segment = simulation.reset(scenario)
    assert segment.start_ns == 10**14
    later = simulation.take_until(10**14, 100)
    assert "imu" in first.sensors
    assert later.sensors["imu"].stamps_ns.tolist() == [1000 * k for k in range(1, 101)]


@pytest.mark.parametrize("sensor", ["imu", "magnetometer", "attitude_sensor", "sun_sensor"])
def test_a_reset_to_a_clock_that_no_stamp_can_show_is_refused_and_changes_nothing(sensor: str) -> None:
    """A node that began at the time of day would end with its next reading."""
    honest = {"rate": 10.0, f"{sensor}_rate": 10.0}
    wrong = Scenario.from_parameters({**honest, f"{sensor}_clock_offset": 2e9})
    simulation, other = (Simulation(Scenario.from_parameters(honest), EPOCH) for _ in range(2))
    simulation.take_until(EPOCH + NS, 5)
    other.take_until(EPOCH + NS, 5)
    before = simulation.segment
    with pytest.raises(ParameterError) as refusal:
        simulation.reset(wrong)
    assert refusal.value.name == f"{sensor}_clock_offset"
    assert simulation.segment == before
    left, expected = (each.take_until(EPOCH + NS, 50).samples.times_ns for each in (simulation, other))
    np.testing.assert_array_equal(left, expected)
    with pytest.raises(ParameterError):
        Simulation(wrong).start_at(EPOCH)


def test_a_clock_behind_is_judged_by_the_time_at_which_a_run_begins() -> None:
    """A node stamps its first sample by the time of day: what would be before 0 else is not."""
    simulation = Simulation(Scenario.from_parameters({"imu_rate": 10.0, "imu_clock_offset": -5.0}))
    with pytest.raises(ParameterError):
        simulation.take_until(NS, 5)
    simulation.start_at(EPOCH)
    assert simulation.take_until(EPOCH, 5).sensors["imu"].stamps_ns.tolist() == [EPOCH - 5 * NS]


@pytest.mark.parametrize(("offset", "count"), [(0.0, 8), (0.25, 4)])
@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_where_the_stamps_end_nothing_is_taken_that_has_none(motion: str, offset: float, count: int) -> None:
    given = {"rate": 20.0, "imu_rate": 5.0, "imu_clock_offset": offset}
    simulation = Simulation(Scenario.from_parameters({**given, "motion": motion}), MAX_EPOCH_NS - 7 * NS // 20)
    assert len(simulation.take_until(MAX_EPOCH_NS + NS, count).samples) == count
    for _ in range(2):
        with pytest.raises(ParameterError):
            simulation.take_until(MAX_EPOCH_NS + NS, 8)
    assert simulation.next_sample == count
