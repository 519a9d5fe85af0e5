"""Readings that were changed, taken out, doubled or displaced are named, each with its topic and place."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from sensor_bags import AT, BIAS, EPOCH, IMU, MAG, TOPICS, VALUES, broken, certificate, laws
from tampering import Message, at, messages_of, on, with_numbers

from lie_rigid_body.certificate.stamps import DISORDER, DUPLICATE, GAP, OFF_GRID

PLACES = {  # where a vector ends, in numbers from the end of the message, and the law that speaks of it
    (IMU, 24): "gyro",
    (IMU, 12): "accelerometer",
    (BIAS, 24): "gyro bias",
    (BIAS, 12): "accelerometer bias",
    (MAG, 12): "magnetometer",
}


@pytest.mark.parametrize("place", PLACES, ids=PLACES.values())
@pytest.mark.parametrize(
    ("axis", "number"), [(0, lambda x: x * (1 + 1e-11)), (1, lambda x: 123.0), (2, lambda x: np.nan), (1, lambda x: -x)]
)
def test_a_changed_number_is_named(bag, tmp_path, place, axis, number):
    (topic, from_end), name = place, PLACES[place]

    def changed(numbers: np.ndarray) -> np.ndarray:
        numbers[axis] = number(numbers[axis])
        return numbers

    found = certificate(bag, tmp_path, on(topic, at(AT, lambda m: with_numbers(m, from_end, changed))))
    assert broken(found) == {name}
    [law] = laws(found, name)
    rate = 70.0 if topic == MAG else 333.3
    assert (law.sample, law.broken) == (AT, 1)
    assert law.stamp_ns == pytest.approx(EPOCH + AT / rate * 1e9, abs=300)


@pytest.mark.parametrize("topic", TOPICS)
@pytest.mark.parametrize("index", [0, AT, -1])
def test_a_missing_reading_is_named(bag, tmp_path, topic, index):
    def drop(ms: list[Message]) -> list[Message]:
        del ms[index]
        return ms

    found = certificate(bag, tmp_path, on(topic, drop))
    count = sum(message.topic == topic for message in messages_of(bag))
    name = "magnetometer stamps" if topic == MAG else "IMU stamps"
    assert broken(found) == {name}
    [law] = laws(found, name)
    assert (law.unit, law.sample, law.worst) == (GAP, index % count, 1)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_doubled_or_displaced_reading_is_named(bag, tmp_path, topic):
    doubled = certificate(bag, tmp_path, on(topic, lambda ms: [*ms[: AT + 1], *ms[AT:]]))
    name = "magnetometer stamps" if topic == MAG else "IMU stamps"
    [law] = laws(doubled, name)
    assert (broken(doubled), law.unit, law.sample) == ({name}, DUPLICATE, AT)
    swapped = certificate(bag, tmp_path, on(topic, lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]]))
    [law] = laws(swapped, name)
    assert (broken(swapped), law.unit, law.sample) == ({name}, DISORDER, AT + 1)


@pytest.mark.parametrize("topic", TOPICS)
def test_readings_under_each_others_stamps_are_named(bag, tmp_path, topic):
    def restamped(ms: list[Message]) -> list[Message]:
        a, b = ms[AT], ms[AT + 1]
        return [
            *ms[:AT],
            a._replace(data=a.data[:12] + b.data[12:]),
            b._replace(data=b.data[:12] + a.data[12:]),
            *ms[AT + 2 :],
        ]

    found = certificate(bag, tmp_path, on(topic, restamped))
    assert "stamps" not in "".join(broken(found))
    values = [law for name in broken(found) for law in laws(found, name)]
    assert all(law.sample in (AT, AT + 1) and law.broken == 2 for law in values)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_stamp_moved_by_a_nanosecond_is_named(bag, tmp_path, topic):
    def move(message: Message) -> Message:
        [nanosec] = struct.unpack("<I", message.data[8:12])
        return message._replace(data=message.data[:8] + struct.pack("<I", nanosec + 1) + message.data[12:])

    found = certificate(bag, tmp_path, on(topic, at(AT, move)))
    [law] = laws(found, f"{'magnetometer' if topic == MAG else 'IMU'} stamps")
    assert (law.unit, law.sample, law.worst, law.holds) == (OFF_GRID, AT, 1.0, False)


@pytest.mark.parametrize("topic", TOPICS)
def test_all_readings_later_by_one_are_caught(bag, tmp_path, topic):
    """Every stamp is right, and every number is that of the reading before."""

    def shift(ms: list[Message]) -> list[Message]:
        pairs = zip(ms, [ms[0], *ms], strict=False)
        return [m._replace(data=m.data[:12] + before.data[12:]) for m, before in pairs]

    assert broken(certificate(bag, tmp_path, on(topic, shift))) & set(VALUES)


FIXED = {
    (IMU, 37): "orientation",
    (IMU, 33): "orientation_covariance",
    (IMU, 21): "angular_velocity_covariance",
    (IMU, 9): "linear_acceleration_covariance",
    (BIAS, 33): "orientation_covariance of the bias",
    (BIAS, 1): "linear_acceleration_covariance of the bias",
    (MAG, 9): "magnetic_field_covariance",
}


@pytest.mark.parametrize("place", FIXED, ids=FIXED.values())
def test_another_covariance_or_orientation_is_named(bag, tmp_path, place):
    topic, from_end = place
    change = lambda numbers: np.concatenate([[numbers[0] + 1e-9], numbers[1:]])  # noqa: E731
    found = certificate(bag, tmp_path, on(topic, at(AT, lambda m: with_numbers(m, from_end, change))))
    [name] = broken(found)
    assert name.endswith("frame and covariances")
    [law] = laws(found, name)
    assert (law.sample, law.broken) == (AT, 1)


@pytest.mark.parametrize("topic", TOPICS)
def test_another_frame_is_named(bag, tmp_path, topic):
    rename = lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lunk"))  # noqa: E731
    found = certificate(bag, tmp_path, on(topic, at(AT, rename)))
    [name] = broken(found)
    [law] = laws(found, name)
    assert (law.sample, law.broken) == (AT, 1)
