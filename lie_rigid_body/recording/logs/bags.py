"""Readings on topics of sensor_msgs/Imu and MagneticField, found by their types."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers, linear
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.messages import NOT_GIVEN
from lie_rigid_body.messages.definitions import IMU, MAGNETIC_FIELD, places
from lie_rigid_body.recording.mcap_contents import McapContents, RawTopic, nothing
from lie_rigid_body.recording.sqlite_reader import bag_contents
from lie_rigid_body.recording.topic_messages import stamped_numbers
from lie_rigid_body.sensors import SENSORS

GYRO: Final = "gyro"
ACCELEROMETER: Final = "accelerometer"
MAGNETOMETER: Final = "magnetometer"
_FIELDS: Final = {
    IMU: {GYRO: "angular_velocity", ACCELEROMETER: "linear_acceleration"},
    MAGNETIC_FIELD: {MAGNETOMETER: "magnetic_field"},
}
"""Fields of vectors by the sensors that they are of; a covariance is called after its vector."""

_TRUE: Final = tuple(f"/{topic.name}" for sensor in SENSORS.values() for topic in sensor.topics[1:])
"""Topics of this package that tell the true errors of readings."""


@short_dataclass
class Vectors:
    """Readings of one sensor, in the order of the file.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (N,)
        Stamps as they stand: perhaps repeated, or falling.
    values : ndarray, shape (N, 3)
    arrival_ns : ndarray of int64, shape (N,), or None
        Log times of a bag, ns.
    variance : ndarray, shape (N, 3), or None
        Declared variances of the axes; None where none is declared.
    """

    t_ns: Integers
    values: Array
    arrival_ns: Integers | None = None
    variance: Array | None = None

    def at(self, t_ns: Integers) -> Array:
        """Readings at stamps, shape (K, 3): their own, or linear between them in the order of time."""
        if np.array_equal(t_ns, self.t_ns):
            return self.values
        order = np.argsort(self.t_ns, kind="stable")
        return linear(t_ns, self.t_ns[order], self.values[order])


def read_bag(path: Path, imu: str | None, magnetometer: str | None) -> tuple[dict[str, Vectors], list[str]]:
    """The readings of a bag by their sensors, and sentences about its topics.

    Raises
    ------
    BagError
        If it cannot be read, or a topic has to be chosen.
    InputError
        If it has no gyro.
    """
    contents = bag_contents(path, nothing)
    found = dict[str, Vectors]()
    taken = list[str]()
    for kind, option, given in ((IMU, "imu", imu), (MAGNETIC_FIELD, "magnetometer", magnetometer)):
        track = _chosen(path, contents, kind, option, given)
        if track is not None:
            read = dict(_read(path, contents, track))
            found |= read
            taken.append(f"The topic {track.topic}, of {kind}, has the {' and the '.join(read)}.")
    if GYRO not in found:
        raise InputError(f"{path}: its Imu declares no angular velocity, by a covariance of -1: give another topic")
    return found, taken


def _chosen(path: Path, contents: McapContents, kind: str, option: str, given: str | None) -> RawTopic | None:
    """The topic of a type that is given, or the only one; None where no magnetometer is there."""
    tracks = [track for track in contents.tracks.values() if track.count and not track.topic.endswith(_TRUE)]
    alike = [track for track in tracks if track.message_type == kind]
    chosen = [track for track in alike if given in (None, track.topic)]
    if len(chosen) == 1:
        return chosen[0]
    if kind != IMU and given is None and not alike:
        return None
    there = listed([f"{track.topic} of {track.message_type}" for track in alike or tracks]) or "no message at all"
    named = "" if given is None else f" called {shown(given)}"
    remedy = f"choose one by --{option}, in Python {option}=" if alike else "record one"
    raise BagError(f"{path} has {len(chosen)} topics of {kind}{named}: there is {there}: {remedy}")


def _read(path: Path, contents: McapContents, track: RawTopic) -> Iterator[tuple[str, Vectors]]:
    """The sensors on a topic, and their readings."""
    where = places(track.message_type)
    logged_ns, decoded = stamped_numbers(path, contents, track)
    assert decoded.stamps_ns is not None
    for sensor, field in _FIELDS[track.message_type].items():
        variance = decoded.numbers[:, where[f"{field}_covariance"][::4]]
        if not (variance[:, 0] == NOT_GIVEN).all():
            values = decoded.numbers[:, where[field]]
            yield sensor, Vectors(decoded.stamps_ns, values, logged_ns, variance if variance.any() else None)
