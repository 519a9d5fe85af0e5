"""Batches: the messages of the truth and of the sensors that are published or recorded together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from typing import Final

from lie_rigid_body.arrays import Integers
from lie_rigid_body.messages import ImuEncoder, MagneticFieldEncoder, PoseTwistEncoder
from lie_rigid_body.messages.definitions import IMU, MAGNETIC_FIELD
from lie_rigid_body.messages.layout import Payloads
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import ImuModel, Sensors
from lie_rigid_body.simulation import ImuSamples, Samples, Taken
from lie_rigid_body.wording import short_repr

POSE: Final = "pose"
TWIST: Final = "twist"
IMU_DATA: Final = "imu/data_raw"
IMU_BIAS: Final = "imu/bias"
MAG: Final = "imu/mag"

SENSOR_TOPICS: Final = {IMU_DATA: IMU, IMU_BIAS: IMU, MAG: MAGNETIC_FIELD}
"""The topics of the sensors by their relative names, and their message types."""


@dataclass(frozen=True)
class Messages:
    """Messages of one topic.

    Parameters
    ----------
    topic : str
        Its relative name.
    stamps_ns : ndarray of int64, shape (N,)
    payloads : Payloads, N of them
    """

    topic: str
    stamps_ns: Integers
    payloads: Payloads

    __repr__ = short_repr


@dataclass(frozen=True)
class Batch:
    """The messages of what was taken from a simulation at once.

    Parameters
    ----------
    samples : Samples, N of them
    poses, twists : Payloads, N each
    sensors : tuple of Messages
    """

    samples: Samples
    poses: Payloads
    twists: Payloads
    sensors: tuple[Messages, ...] = ()

    __repr__ = short_repr

    @property
    def topics(self) -> tuple[Messages, ...]:
        """The messages of every topic, in the order in which those of equal stamps come: the truth before sensors."""
        stamps_ns = self.samples.stamps_ns
        return Messages(POSE, stamps_ns, self.poses), Messages(TWIST, stamps_ns, self.twists), *self.sensors

    def in_order(self) -> Iterator[tuple[int, str, bytes]]:
        """Stamp, topic and payload of every message; where stamps are equal: pose, twist, IMU, bias, magnetometer."""
        if not self.sensors:
            stamps: list[int] = self.samples.stamps_ns.tolist()
            for stamp, pose, twist in zip(stamps, self.poses, self.twists, strict=True):
                yield stamp, POSE, pose
                yield stamp, TWIST, twist
            return
        everything = [
            (stamp, messages.topic, payload)
            for messages in self.topics
            for stamp, payload in zip(messages.stamps_ns.tolist(), messages.payloads, strict=True)
        ]
        everything.sort(key=itemgetter(0))
        yield from everything


def sensor_topics(sensors: Sensors) -> list[str]:
    """Relative names of the topics that the sensors of a scenario have."""
    imu = [IMU_DATA, IMU_BIAS] if sensors.imu is not None else []
    return [*imu, *([MAG] if sensors.magnetometer is not None else [])]


class BatchEncoder:
    """Samples and readings of a simulation as messages, for publishers or a bag.

    Parameters
    ----------
    scenario : Scenario
    """

    def __init__(self, scenario: Scenario) -> None:
        self._truth = PoseTwistEncoder(scenario)
        imu, magnetometer = scenario.sensors.imu, scenario.sensors.magnetometer
        self._imu = None if imu is None else _ImuMessages(imu)
        self._field = None if magnetometer is None else MagneticFieldEncoder(magnetometer.frame, magnetometer.variance)

    def encode(self, taken: Taken) -> Batch:
        """The messages of samples and readings that were taken at once."""
        samples = taken.samples
        return Batch(samples, self._truth.poses(samples), self._truth.twists(samples), tuple(self._sensors(taken)))

    def _sensors(self, taken: Taken) -> Iterator[Messages]:
        # readings of a sensor that a reset has taken away are left out
        if self._imu is not None and taken.imu is not None:
            yield from self._imu.messages(taken.imu)
        if self._field is not None and taken.magnetometer is not None:
            stamps_ns = taken.magnetometer.stamps_ns
            yield Messages(MAG, stamps_ns, self._field.encode(stamps_ns, taken.magnetometer.magnetic_field))


class _ImuMessages:
    """The messages of an IMU: its readings, and their true bias."""

    def __init__(self, model: ImuModel) -> None:
        self._data = ImuEncoder(model.frame, model.angular_velocity_variance, model.linear_acceleration_variance)
        self._bias = ImuEncoder(model.frame)

    def messages(self, samples: ImuSamples) -> Iterator[Messages]:
        at, readings = samples.stamps_ns, samples.readings
        data = self._data.encode(at, readings.angular_velocity, readings.linear_acceleration)
        bias = self._bias.encode(at, readings.gyro_bias, readings.accelerometer_bias)
        yield Messages(IMU_DATA, at, data)
        yield Messages(IMU_BIAS, at, bias)
