"""Sensors beside one another: switches, and batches of any size with the same bits."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_models import EVERYTHING, MOTION, imu, magnetometer, sensors_of, times

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.sensors import SENSORS, Imu, Magnetometer, Sensors, frame_parameters

TRIADS = ("gyro", "accelerometer")
NOT_NEGATIVE = [p.name for p in SENSORS.parameters.values() if p.kind == "double" and p.minimum == 0.0]
ARRAYS = [p for p in SENSORS.parameters.values() if p.kind == "double_array"]
LIMITS = {
    "jitter": ("sun_sensor_latency_jitter", {"sun_sensor_rate": 1e5, "sun_sensor_latency_jitter": 1.1}, "at most 1 s"),
    "imu_rate too slow": ("imu_rate", {"imu_rate": 1e-7}, "1e-07 is below 1e-06 samples"),
    "magnetometer_rate too slow": ("magnetometer_rate", {"magnetometer_rate": 1e-7}, "or 0 for none"),
    "rate too fast": ("imu_rate", {"imu_rate": 1e10}, r"outside \[0, 1e\+09\]"),
    "frame": ("imu_frame", {"imu_frame": "/imu"}, "not a frame name"),
    "empty frame": ("imu_frame", {"imu_frame": ""}, "not a frame name"),
    "seed below 0": ("sensor_seed", {"sensor_seed": -1}, r"outside \[0, 9223372036854775807\]"),
    "seed too large": ("sensor_seed", {"sensor_seed": 2**63}, "outside"),
    "seed no integer": ("sensor_seed", {"sensor_seed": 1.5}, "not an integer"),
    "gyro rate": ("gyro_rate", {"gyro_rate": "mean"}, "choose one of instantaneous, integrated"),
    "mode": ("accelerometer_mode", {"accelerometer_mode": "pivot"}, "choose one of free_fall, pivot_gravity"),
    "lever arm": ("accelerometer_lever_arm", {"accelerometer_lever_arm": [0.0, -2e6, 1.0]}, r"-2e\+06 .*±1e\+06 m"),
    "field": ("magnetic_field", {"magnetic_field": [0.0, 0.0, 48.0e6]}, r"±1000 T"),
    "hard iron": ("magnetometer_hard_iron", {"magnetometer_hard_iron": [1e4, 0.0, 0.0]}, r"±1000 T"),
    "soft iron": ("magnetometer_soft_iron", {"magnetometer_soft_iron": [1e7] * 9}, r"±1e\+06: give"),
    "boresight": ("attitude_sensor_boresight", {"attitude_sensor_boresight": [0.0] * 3}, "tells no direction"),
    "episodes": ("gyro_stuck_duration", {"gyro_stuck_interval": 0.5}, "at most gyro_stuck_interval, 0.5 s"),
    "interval": ("imu_outage_interval", {"imu_outage_interval": 1e-4}, "below 0.001 s"),
    "window": ("fault_end", {"fault_begin": 3.0, "fault_end": 2.0}, "not after fault_begin, 3 s"),
    "grade": ("sensor_grade", {"sensor_grade": "cheap"}, "choose one of perfect, navigation"),
    "unknown": ("gyro_noise_densty", {"gyro_noise_densty": 1.0}, r"did you mean gyro_noise_density or "),
    **{
        f"{sensor} resolution": (
            f"{sensor}_resolution",
            {f"{sensor}_resolution": 2.0, f"{sensor}_range": 1.0},
            f"2 is more than {sensor}_range, 1: give a finer resolution",
        )
        for sensor in (*TRIADS, "magnetometer")
    },
    **{
        f"{sensor} fine resolution": (f"{sensor}_resolution", {f"{sensor}_resolution": 1e-300}, "the finest step")
        for sensor in (*TRIADS, "magnetometer")
    },
    **{
        f"{sensor} scale": (f"{sensor}_scale_factor", {f"{sensor}_scale_factor": [1.0, 2e6, 1.0]}, r"±1e\+06: give")
        for sensor in TRIADS
    },
    **{
        f"{sensor} mounting": (
            f"{sensor}_misalignment",
            {f"{sensor}_misalignment": [2.0, 2.0, 2.0]},
            "turns by 3.4641 rad, more than pi",
        )
        for sensor in TRIADS
    },
}


def refusal(given: dict[str, object]) -> ParameterError:
    with pytest.raises(ParameterError) as caught:
        sensors_of(given)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"{caught.value.name}: ")
    return caught.value


def test_sensors_are_off_by_default() -> None:
    assert sensors_of({}) == Sensors()


def test_each_is_turned_on_by_its_rate() -> None:
    imu, magnetometer = (sensors_of({name: 50.0}) for name in ("imu_rate", "magnetometer_rate"))
    assert imu.imu is not None
    assert magnetometer.magnetometer is not None
    assert (imu.imu.rate, imu.magnetometer) == (50.0, None)
    assert (magnetometer.magnetometer.rate, magnetometer.imu) == (50.0, None)


def test_every_parameter_reaches_its_sensor() -> None:
    """A value other than the default makes other sensors; names of frames go to their messages."""
    on: dict[str, object] = {p.name: 100.0 for p in SENSORS.parameters.values() if p.name.endswith("sensor_rate")}
    on |= {"imu_rate": 100.0, "magnetometer_rate": 100.0, "imu_orientation": True}
    on |= {p.name: 0.5 for p in SENSORS.parameters.values() if p.name.endswith("_probability")}
    on |= {p.name: 8.0 for p in SENSORS.parameters.values() if p.name.endswith("_interval")}
    on |= {p.name: 0.3 for p in SENSORS.parameters.values() if p.name.endswith("_drift")}
    plain = sensors_of(on)
    for parameter in (p for p in SENSORS.parameters.values() if p.name not in frame_parameters()):
        other: object = 0.005 if parameter.name.endswith("_skew") else 9.0 if parameter.name in on else 0.25
        if parameter.name.endswith("_probability"):
            other = 0.75
        elif parameter.kind == "bool":
            other = False
        elif parameter.kind == "double_array":
            other = [0.25 + k / 8 for k in range(parameter.lengths[0])]
        elif parameter.kind == "int":
            other = 3
        elif parameter.kind == "string":
            other = parameter.choices[1] if parameter.choices else "other_link"
        changed = sensors_of({**on, parameter.name: other})
        assert changed != plain, parameter.name


def test_sensors_are_frozen() -> None:
    sensors = sensors_of({"imu_rate": 1.0})
    with pytest.raises(dataclasses.FrozenInstanceError):
        sensors.models = ()  # type: ignore[misc]


def test_names_are_distinct_and_defaults_are_allowed() -> None:
    names = [parameter.name for parameter in SENSORS.parameters.values()]
    assert len(set(names)) == len(names)
    for parameter in SENSORS.parameters.values():
        value = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
        assert parameter.read(value) == parameter.default


@pytest.mark.parametrize("value", [-1e-9, math.nan, math.inf, "much", True])
def test_amounts_are_finite_and_not_negative(value: object) -> None:
    assert [refusal({name: value}).name for name in NOT_NEGATIVE] == NOT_NEGATIVE


@pytest.mark.parametrize("value", [math.nan, math.inf, "much", None])
def test_arrays_are_finite_numbers(value: object) -> None:
    for parameter in ARRAYS:
        good, name = [0.0] * parameter.lengths[0], parameter.name
        assert refusal({name: [*good[1:], value]}).name == name
        assert refusal({name: good[1:]}).name == name


@pytest.mark.parametrize(("name", "given", "said"), LIMITS.values(), ids=LIMITS)
def test_what_cannot_be_is_refused(name: str, given: dict[str, object], said: str) -> None:
    error = refusal(given)
    assert error.name == name
    assert re.search(said, str(error))


COUNT = 700
T = times(COUNT)
STATES = MOTION.at(T)
FIELDS = ("gyro", "specific_force", "gyro_bias", "accelerometer_bias")
ALONE = {key: value for key, value in EVERYTHING.items() if key != "magnetometer_rate"}


def imu_bytes(sensor: Imu, cuts: list[int]) -> list[bytes]:
    reads = [sensor.measure(T[a:b], STATES[a:b], a) for a, b in zip([0, *cuts], [*cuts, COUNT], strict=True)]
    return [np.concatenate([read[name] for read in reads]).tobytes() for name in FIELDS]


def field_bytes(sensor: Magnetometer, cuts: list[int]) -> bytes:
    pairs = zip([0, *cuts], [*cuts, COUNT], strict=True)
    return np.concatenate([sensor.measure(T[a:b], STATES[a:b], a)["field"] for a, b in pairs]).tobytes()


@pytest.mark.parametrize("gyro_rate", ["instantaneous", "integrated"])
def test_one_by_one_is_all_at_once(gyro_rate: str) -> None:
    settings = {**EVERYTHING, "gyro_rate": gyro_rate}
    singles = list(range(1, COUNT))
    assert imu_bytes(imu(**settings), singles) == imu_bytes(imu(**settings), [])
    assert field_bytes(magnetometer(**settings), singles) == field_bytes(magnetometer(**settings), [])


@given(st.lists(st.integers(0, COUNT), max_size=5).map(sorted))
def test_where_batches_begin_changes_nothing(cuts: list[int]) -> None:
    assert imu_bytes(imu(**EVERYTHING), cuts) == imu_bytes(imu(**EVERYTHING), [])
    assert field_bytes(magnetometer(**EVERYTHING), cuts) == field_bytes(magnetometer(**EVERYTHING), [])


def test_sensors_do_not_move_each_other() -> None:
    together, field = imu(**EVERYTHING), magnetometer(**EVERYTHING)
    reads, fields = [], []
    for k in range(50):  # in turns
        fields.append(field.measure(T[k : k + 1], STATES[k : k + 1], k)["field"])
        reads.append(together.measure(T[k : k + 1], STATES[k : k + 1], k))
    alone = imu(**ALONE).measure(T[:50], STATES[:50])
    for name in FIELDS:
        assert np.concatenate([read[name] for read in reads]).tobytes() == alone[name].tobytes()
    assert (
        np.concatenate(fields).tobytes() == magnetometer(**EVERYTHING).measure(T[:50], STATES[:50])["field"].tobytes()
    )


def test_the_noise_of_one_sensor_does_not_move_another() -> None:
    quiet = {key: value for key, value in EVERYTHING.items() if not key.startswith("gyro_")}
    with_gyro, without = (imu(**settings).measure(T, STATES) for settings in (EVERYTHING, quiet))
    assert with_gyro["specific_force"].tobytes() == without["specific_force"].tobytes()
    assert with_gyro["gyro"].tobytes() != without["gyro"].tobytes()


def test_the_seed_decides() -> None:
    first, again, other = (
        imu_bytes(imu(**{**EVERYTHING, "sensor_seed": seed}), []) for seed in (2**63 - 1, 2**63 - 1, 2**63 - 2)
    )
    assert first == again
    assert not set(first) & set(other)


def test_an_empty_batch_is_one() -> None:
    sensor = imu(**EVERYTHING)
    nothing = sensor.measure(T[:0], STATES[:0])
    assert [nothing[name].shape for name in FIELDS] == [(0, 3)] * 4
    assert imu_bytes(sensor, []) == imu_bytes(imu(**EVERYTHING), [])


def test_where_arrays_lie_in_memory_changes_nothing() -> None:
    """Some functions of NumPy look at it: the same readings have to come from arrays of many addresses."""
    rng = np.random.default_rng(1)
    first, held = imu_bytes(imu(**EVERYTHING), []), []
    for _ in range(60):
        held.append(np.empty(rng.integers(1, 3000)))
        assert imu_bytes(imu(**EVERYTHING), []) == first
