"""Faults: each does what it says of itself, drawn from the seed alone, and moves nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_models import MOTION, imu_model, magnetometer, readings_at_rest, sensors_of, times

from lie_rigid_body.sensors import SENSORS, Fault
from lie_rigid_body.sensors.fault import (
    AXES,
    END_OF_TIME,
    KINDS,
    MAX_FAULT_TEXT,
    STREAMS,
    IntermittentFault,
    Window,
    stream,
)
from lie_rigid_body.sensors.noise import Draws, NoiseSource
from untyped import simulate

NS = 1_000_000_000
COUNT = 4000
SENSORS_ON: dict[str, Any] = {"duration": 40.0, "motion": "closed_form", "imu_rate": 100.0, "magnetometer_rate": 50.0}


def run(**given: Any) -> Any:
    return simulate(**{**SENSORS_ON, **given})


def of_kind(found: Any, kind: str) -> list[Fault]:
    return [fault for fault in found.faults if fault.kind == kind]


def inside(t_ns: np.ndarray, faults: list[Fault]) -> np.ndarray:
    """Which times are in one of some faults."""
    ends = [(fault.begin_ns, fault.end_ns or END_OF_TIME) for fault in faults]
    return np.any([(t_ns >= begin) & (t_ns < end) for begin, end in ends], axis=0)


@pytest.fixture(scope="module")
def clean() -> Any:
    return run(gyro_noise_density=1e-3)


def test_streams_are_these_for_ever_and_no_two_are_alike() -> None:
    """Else what is recorded today could not be recorded again."""
    streams = [stream(sensor, kind, part) for sensor in STREAMS for kind in KINDS for part in (0, 1)]
    assert len({*streams, *NoiseSource}) == len(streams) + len(NoiseSource)
    assert stream("imu", "dropout") == 256
    assert stream("gyro", "spike", 1) == 525
    assert stream("magnetometer", "stuck") == 1040
    assert stream("attitude_sensor", "outage") == 1282
    assert stream("sun_sensor", "magnetic_disturbance") == 1558


@given(st.lists(st.integers(0, 10**6), max_size=30))
def test_draws_are_the_same_in_whatever_order(numbers: list[int]) -> None:
    draws = Draws(7, 300)
    asked = np.array(numbers, dtype=np.int64)
    one_by_one = [draws.following(number, 1) for number in numbers]
    assert draws.of(asked).tobytes() == np.concatenate([np.empty((0, 4)), *one_by_one]).tobytes()


@given(
    seed=st.integers(0, 2**63 - 1),
    interval=st.integers(10**6, 10**10),
    share=st.floats(1e-3, 1.0),
    begin=st.integers(0, 10**10),
)
def test_there_is_one_episode_in_each_interval(seed: int, interval: int, share: float, begin: int) -> None:
    window = Window(begin, begin + 20 * interval + interval // 2)
    episodes = IntermittentFault(seed, "gyro", "stuck", window, interval, max(1, int(share * interval)))
    found = list(episodes.between(0, END_OF_TIME))
    assert [number for number, *_ in found[:20]] == list(range(20))
    assert len(found) in (20, 21)
    for number, first, end in found:
        assert begin + number * interval <= first < end <= min(begin + (number + 1) * interval, window.end_ns)
        assert episodes.at(np.array([first - 1, first, end - 1])).tolist()[1:] == [number, number]
    cut = begin + 7 * interval + 3
    assert [*episodes.between(0, cut), *episodes.between(cut, END_OF_TIME)] == found


def test_a_time_that_is_wanted_can_be_given() -> None:
    given = {"gyro_stuck_interval": 5.0, "gyro_stuck_duration": 5.0, "fault_begin": 10.0, "fault_end": 15.0}
    [stuck] = of_kind(run(**given), "stuck")
    assert (stuck.begin_ns, stuck.end_ns) == (10 * NS, 15 * NS)


FAULTS: dict[str, dict[str, Any]] = {
    "dropout": {"imu_dropout_probability": 0.1},
    "outage": {"imu_outage_interval": 10.0},
    "latency": {"imu_latency": 0.05},
    "latency_jitter": {"imu_latency_jitter": 0.05},
    "clock_offset": {"imu_clock_offset": 0.05},
    "clock_skew": {"imu_clock_skew": 1e-4},
    "spike": {"gyro_spike_probability": 0.01},
    "noise_burst": {"gyro_noise_burst_interval": 10.0},
    "stuck": {"gyro_stuck_interval": 10.0},
    "saturation": {"gyro_saturation_interval": 10.0},
    "temperature_drift": {"gyro_temperature_drift": 0.1},
    "magnetic_disturbance": {"magnetic_disturbance_interval": 10.0},
}


def test_there_is_a_case_of_every_kind() -> None:
    assert set(FAULTS) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_is_told_and_moves_no_other_reading(kind: str, clean: Any) -> None:
    """Not those of another sensor, nor of its own outside of the fault, nor any noise."""
    found = run(gyro_noise_density=1e-3, **FAULTS[kind])
    assert {fault.kind for fault in found.faults} == {kind}
    assert found.truth.attitude_xyzw.tobytes() == clean.truth.attitude_xyzw.tobytes()
    if kind != "magnetic_disturbance":
        assert found.magnetometer.field.tobytes() == clean.magnetometer.field.tobytes()
    imu, before = found.imu, clean.imu
    if kind in ("dropout", "outage", "latency", "latency_jitter"):
        kept = np.isin(before.t_ns, imu.t_ns)
        assert imu.gyro.tobytes() == before.gyro[kept].tobytes()
        assert imu.t_ns.tobytes() == before.t_ns[kept].tobytes()
    elif kind in ("spike", "noise_burst", "stuck", "saturation"):
        if kind == "spike":
            outside = ~np.isin(before.t_ns, [fault.begin_ns for fault in found.faults])
        else:
            outside = ~inside(before.t_ns, of_kind(found, kind))
        assert 0 < (~outside).sum() < outside.sum()
        assert imu.gyro[outside].tobytes() == before.gyro[outside].tobytes()
        assert not np.array_equal(imu.gyro, before.gyro)
        assert imu.specific_force.tobytes() == before.specific_force.tobytes()


@pytest.mark.parametrize("kind", KINDS)
def test_one_fault_does_not_move_another(kind: str) -> None:
    everything = {name: value for given in FAULTS.values() for name, value in given.items()}
    alone, together = of_kind(run(**FAULTS[kind]), kind), of_kind(run(**everything), kind)
    # the log ends with the last message: one that is late makes it no shorter
    count = min(len(alone), len(together))
    assert count
    assert alone[:count] == together[:count]


def test_what_is_lost_is_what_is_told_and_no_more_than_the_probability() -> None:
    found = run(imu_dropout_probability=0.1, imu_outage_interval=8.0, imu_outage_duration=0.5)
    all_ns = np.arange(COUNT, dtype=np.int64) * 10_000_000
    dropped = np.isin(all_ns, [fault.begin_ns for fault in of_kind(found, "dropout")])
    outages = of_kind(found, "outage")
    assert len(outages) == 5
    assert found.imu.t_ns.tolist() == all_ns[~dropped & ~inside(all_ns, outages)].tolist()
    assert abs(dropped.mean() - 0.1) < 5.0 * np.sqrt(0.09 / COUNT)
    assert len(run(imu_dropout_probability=1.0).imu.t_ns) == 0


def test_stamps_are_of_the_sensors_clock_and_arrival_is_later_by_the_latency() -> None:
    offset, skew, latency, jitter = 0.2, -1e-3, 0.03, 0.045
    found = run(
        epoch_ns=NS, imu_clock_offset=offset, imu_clock_skew=skew, imu_latency=latency, imu_latency_jitter=jitter
    )
    imu = found.imu
    measured = NS + np.arange(len(imu.t_ns), dtype=np.int64) * 10_000_000
    shown = NS * offset + np.rint(skew * (measured - NS))
    assert (imu.t_ns - measured).tolist() == shown.astype(np.int64).tolist()
    delay = (imu.arrival_ns - measured) / NS
    assert latency <= delay.min() < latency + 0.01
    assert latency + jitter - 0.005 < delay.max() < latency + jitter
    assert np.diff(imu.arrival_ns).min() == 0  # one waits for the one before, and none overtakes it
    assert len(imu.t_ns) == (imu.arrival_ns <= NS + 40 * NS - 1).sum() < COUNT


def test_jitter_is_drawn_evenly_where_no_reading_waits_for_another() -> None:
    imu = run(imu_latency_jitter=0.01).imu
    delay = np.sort((imu.arrival_ns - imu.t_ns) / 1e7)
    even = (np.arange(len(delay)) + 0.5) / len(delay)
    assert np.abs(delay - even).max() < 1.95 / np.sqrt(len(delay))  # Kolmogorov: once in a thousand seeds


def test_a_spike_has_its_size_on_one_axis() -> None:
    spiky = readings_at_rest(COUNT, gyro_spike_probability=0.05, gyro_spike_size=2.0)["gyro"]
    assert set(np.abs(spiky[spiky != 0.0]).tolist()) == {2.0}
    hit = np.flatnonzero(spiky.any(axis=1))
    assert ((spiky[hit] != 0.0).sum(axis=1) == 1).all()
    assert abs(len(hit) / COUNT - 0.05) < 5.0 * np.sqrt(0.05 / COUNT)
    assert {tuple(np.sign(row)) for row in spiky[hit]} == {tuple(s * e) for e in np.eye(3) for s in (-1.0, 1.0)}


def test_a_burst_is_white_noise_of_its_density() -> None:
    given = {"gyro_noise_burst_interval": 40.0, "gyro_noise_burst_duration": 40.0, "gyro_noise_burst_density": 0.02}
    burst = readings_at_rest(COUNT, **given)["gyro"]
    assert np.abs(burst.var(axis=0) / (0.02**2 * 100.0) - 1.0).max() < 10.0 / np.sqrt(COUNT)


def test_a_stuck_axis_repeats_what_it_read_before(clean: Any) -> None:
    found = run(gyro_noise_density=1e-3, gyro_stuck_interval=4.0, gyro_stuck_duration=4.0)
    before, imu = clean.imu.gyro, found.imu
    axes = set()
    for fault in of_kind(found, "stuck"):
        rows = np.flatnonzero(inside(imu.t_ns, [fault]))
        axis = AXES.index(fault.axis)
        first = int(rows[0])
        held = imu.gyro[first - 1, axis] if first else before[0, axis]
        assert (imu.gyro[rows, axis] == held).all()
        others = [i for i in range(3) if i != axis]
        assert imu.gyro[np.ix_(rows, others)].tobytes() == before[np.ix_(rows, others)].tobytes()
        axes.add(axis)
    assert len(axes) > 1


def test_saturation_and_spikes_stay_within_the_range() -> None:
    given = {"gyro_range": 1.5, "gyro_spike_probability": 0.5, "gyro_spike_size": 9.0, "gyro_saturation_level": 0.3}
    found = run(**given, gyro_saturation_interval=10.0, gyro_saturation_duration=2.0)
    imu = found.imu
    low = inside(imu.t_ns, of_kind(found, "saturation"))
    assert np.abs(imu.gyro[low]).max() == 0.3
    assert np.abs(imu.gyro[~low]).max() == 1.5


@pytest.mark.parametrize("sensor", ["gyro", "magnetometer"])
@pytest.mark.parametrize("share", [0.6, 1.0, 2.7, 100.4])
def test_saturation_reads_the_last_step_within_its_level(sensor: str, share: float) -> None:
    """The level, like the range, need be no multiple of the resolution."""
    level = {"gyro": 0.3, "magnetometer": 1e-5}[sensor]
    given = {"resolution": level / share, "range": 7.7 * level / min(share, 1.0), "saturation_level": level}
    episodes = {"saturation_interval": 10.0, "saturation_duration": 2.0}
    found = run(**{f"{sensor}_{key}": value for key, value in (given | episodes).items()})
    t_ns, read = {
        "gyro": (found.imu.t_ns, found.imu.gyro),
        "magnetometer": (found.magnetometer.t_ns, found.magnetometer.field),
    }[sensor]
    low = inside(t_ns, of_kind(found, "saturation"))
    assert np.abs(read[low]).max() == pytest.approx(np.floor(share) * level / share, rel=1e-15)
    assert np.abs(read[~low]).max() > level


def test_a_drift_with_temperature_is_a_ramp_of_the_bias() -> None:
    given = {"gyro_temperature_drift": 0.1, "gyro_temperature_drift_duration": 20.0, "fault_begin": 10.0}
    found = run(**given, gyro_turn_on_bias=0.01)
    imu = found.imu
    whole = np.array([fault.size for fault in of_kind(found, "temperature_drift")])
    share = np.clip((imu.t_ns / NS - 10.0) / 20.0, 0.0, 1.0)
    np.testing.assert_allclose(imu.gyro_bias - imu.gyro_bias[0], share[:, np.newaxis] * whole, rtol=0, atol=1e-15)
    sizes = np.array([sensors_of({"imu_rate": 1.0, **given, "sensor_seed": s}) for s in range(300)])
    drawn = np.array([s.imu.gyro.faults.drifted for s in sizes])
    assert np.abs(drawn.std(axis=0) / 0.1 - 1.0).max() < 0.2


def test_a_magnetic_disturbance_comes_and_goes_with_its_size_in_the_world() -> None:
    t, given = times(COUNT), {"magnetic_disturbance_interval": 20.0, "magnetic_disturbance_size": 3e-5}
    states = MOTION.at(t)
    difference = magnetometer(**given).measure(t, states)["field"] - magnetometer().measure(t, states)["field"]
    size = np.linalg.norm(difference, axis=1)
    values = {**_defaults(), **given}
    episodes: Any = IntermittentFault.from_values(values, "magnetometer", "magnetic_disturbance", KINDS[-1])
    for _, begin, end in episodes.between(0, 40 * NS):
        there = (t >= begin) & (t < end)
        s = 2.0 * (t[there] - begin) / (end - begin) - 1.0
        np.testing.assert_allclose(size[there], 3e-5 * (1.0 - s * s) ** 2, rtol=0, atol=1e-19)
        size[there] = 0.0
    assert not size.any()


def _defaults() -> dict[str, Any]:
    return {parameter.name: parameter.default for parameter in SENSORS.parameters.values()}


@given(
    kind=st.sampled_from(KINDS),
    sensor=st.sampled_from(list(STREAMS)),
    axis=st.sampled_from([*AXES, ""]),
    begin=st.integers(0, 2**61),
    end=st.none() | st.integers(0, 2**61),
    size=st.none() | st.floats(allow_nan=False, allow_infinity=False),
)
def test_a_fault_comes_back_from_its_text(kind, sensor, axis, begin, end, size) -> None:
    fault = Fault(kind, sensor, axis, begin, end, size)
    text = fault.to_json()
    assert len(text) <= MAX_FAULT_TEXT
    assert Fault.from_json(text.ljust(MAX_FAULT_TEXT)) == fault


def test_without_a_fault_the_models_are_what_they_were() -> None:
    model = imu_model(fault_begin=3.0)
    assert (model.delivery, model.gyro.faults, model.accelerometer.faults) == (None, None, None)
