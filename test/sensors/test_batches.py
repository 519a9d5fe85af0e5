"""The same readings to the bit, in batches of any size and whatever else is on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_models import EVERYTHING, MOTION, imu, magnetometer, times

from lie_rigid_body.sensors import Imu, Magnetometer

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
