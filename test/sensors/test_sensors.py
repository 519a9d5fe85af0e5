"""Sensors beside one another: switches, and batches of any size with the same bits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from sensor_models import EVERYTHING, MOTION, imu, magnetometer, sensors_of, times

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.sensors import SENSORS, AttitudeSensor, Instrument, SunSensor, frame_parameters

NOT_NEGATIVE = [p.name for p in SENSORS.parameters.values() if p.kind == "double" and p.minimum == 0.0]
ARRAYS = [p for p in SENSORS.parameters.values() if p.kind == "double_array"]


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


def test_names_are_distinct_and_defaults_are_allowed() -> None:
    names = [parameter.name for parameter in SENSORS.parameters.values()]
    assert len(set(names)) == len(names)
    for parameter in SENSORS.parameters.values():
        value = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
        assert parameter.read(value) == parameter.default


def refusal(given: dict[str, object]) -> ParameterError:
    with pytest.raises(ParameterError) as caught:
        sensors_of(given)
    return caught.value


@pytest.mark.parametrize("value", [-1e-9, math.nan, math.inf, "much", True])
def test_amounts_are_finite_and_not_negative(value: object) -> None:
    assert [refusal({name: value}).name for name in NOT_NEGATIVE] == NOT_NEGATIVE


@pytest.mark.parametrize("value", [math.nan, math.inf, "much", None])
def test_arrays_are_finite_numbers(value: object) -> None:
    for parameter in ARRAYS:
        good, name = [0.0] * parameter.lengths[0], parameter.name
        assert refusal({name: [*good[1:], value]}).name == name
        assert refusal({name: good[1:]}).name == name


COUNT = 700
T = times(COUNT)
STATES = MOTION.at(T)
FIELDS = ("gyro", "specific_force", "gyro_bias", "accelerometer_bias")
ALONE = {key: value for key, value in EVERYTHING.items() if key != "magnetometer_rate"}


def readings(sensor: Instrument, cuts: list[int]) -> dict[str, bytes]:
    parts = [sensor.measure(T[a:b], STATES[a:b], a) for a, b in zip([0, *cuts], [*cuts, COUNT], strict=True)]
    return {name: np.concatenate([part[name] for part in parts]).tobytes() for name in parts[0]}


def pointing() -> Any:
    noise = {"attitude_sensor_roll_noise": 2e-3, "sun_sensor_noise": 0.01}
    return sensors_of({"attitude_sensor_rate": 4.0, "sun_sensor_rate": 1.0, **noise})


MAKERS: dict[str, Callable[[], Instrument]] = {
    "imu": lambda: imu(**EVERYTHING),
    "instantaneous imu": lambda: imu(**{**EVERYTHING, "gyro_rate": "instantaneous"}),
    "magnetometer": lambda: magnetometer(**EVERYTHING),
    "attitude sensor": lambda: AttitudeSensor(pointing().attitude_sensor),
    "sun sensor": lambda: SunSensor(pointing().sun_sensor),
}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
@given(st.lists(st.integers(0, COUNT), max_size=5).map(sorted))
@example(list(range(1, COUNT)))
def test_where_batches_begin_changes_nothing(make: Callable[[], Instrument], cuts: list[int]) -> None:
    assert readings(make(), cuts) == readings(make(), [])


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


def test_an_empty_batch_is_one() -> None:
    sensor = imu(**EVERYTHING)
    nothing = sensor.measure(T[:0], STATES[:0])
    assert [nothing[name].shape for name in FIELDS] == [(0, 3)] * 4
    assert readings(sensor, []) == readings(imu(**EVERYTHING), [])


def test_where_arrays_lie_in_memory_changes_nothing() -> None:
    """Some functions of NumPy look at it: the same readings have to come from arrays of many addresses."""
    rng = np.random.default_rng(1)
    first, held = readings(imu(**EVERYTHING), []), []
    for _ in range(60):
        held.append(np.empty(rng.integers(1, 3000)))
        assert readings(imu(**EVERYTHING), []) == first
