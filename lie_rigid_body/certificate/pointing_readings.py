"""Readings of an attitude sensor and a sun sensor computed anew; see `readings`."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.certificate.readings import (
    LARGEST_DEVIATE,
    ROUNDINGS,
    Expected,
    Times,
    limits_of,
    motion_error_of,
    seconds,
    turned,
)
from lie_rigid_body.motion.drift import U
from lie_rigid_body.sensors import AttitudeSensor, SunSensor
from lie_rigid_body.simulation import Segment


class AttitudeReadings:
    """What an attitude sensor reads; nothing of it walks.

    Parameters
    ----------
    segment : Segment
    duration : float
        Of the segment, s.
    """

    walks = repeats = False

    def __init__(self, segment: Segment, duration: float) -> None:
        model = segment.scenario.sensors.attitude_sensor
        assert model is not None
        self._times, self._sensor, self._model = Times(segment, model.rate), AttitudeSensor(model), model
        self._tolerance = limits_of(segment, model.rate, duration)
        self.motion_error = motion_error_of(self._tolerance, duration)

    @property
    def next(self) -> int:
        """Number of the reading that comes next."""
        return self._times.next

    def take(self, first: int, count: int) -> tuple[Expected, ...]:
        """The attitude and its covariance, which depends on the attitude that is read."""
        model, times = self._model, self._times
        if left_out := times.advance(first, count):
            self._sensor.skip(left_out)
        elapsed = times.elapsed_ns(first, count)
        angle = self._tolerance.attitude(seconds(elapsed))
        attitude = turned(
            self._sensor.measure(elapsed, times.motion.at(elapsed)), angle, model.cross_noise + model.roll_noise
        )
        covariance = model.covariance(attitude.signal).reshape(count, 9)
        size = model.cross_noise**2 + model.roll_noise**2
        # the boresight turns by the angle, which is twice the error of the quaternion, and stands in it twice
        uncertainty = np.broadcast_to(size * (4.0 * attitude.uncertainty[:, :1] + ROUNDINGS * U), covariance.shape)
        return attitude, Expected(_of_pose(covariance), _of_pose(uncertainty))


def _of_pose(rotation: Array) -> Array:
    """The covariance of a pose whose translation is known, row by row, shape (N, 36), of that of its rotation."""
    whole = np.zeros((len(rotation), 6, 6))
    whole[:, 3:, 3:] = rotation.reshape(-1, 3, 3)
    return whole.reshape(-1, 36)


class SunReadings:
    """What a sun sensor reads; nothing of it walks.

    Parameters
    ----------
    segment : Segment
    duration : float
        Of the segment, s.
    """

    walks = repeats = False

    def __init__(self, segment: Segment, duration: float) -> None:
        model = segment.scenario.sensors.sun_sensor
        assert model is not None
        self._times, self._sensor = Times(segment, model.rate), SunSensor(model)
        self._tolerance = limits_of(segment, model.rate, duration)
        self.motion_error = motion_error_of(self._tolerance, duration)
        self._rounding = ROUNDINGS * U * (1.0 + LARGEST_DEVIATE * model.noise)

    @property
    def next(self) -> int:
        """Number of the reading that comes next."""
        return self._times.next

    def take(self, first: int, count: int) -> tuple[Expected, ...]:
        """The direction of the sun."""
        if left_out := self._times.advance(first, count):
            self._sensor.skip(left_out)
        elapsed = self._times.elapsed_ns(first, count)
        direction = self._sensor.measure(elapsed, self._times.motion.at(elapsed))
        uncertainty = self._tolerance.attitude(seconds(elapsed)) + self._rounding
        return (Expected(direction, np.broadcast_to(uncertainty[:, np.newaxis], direction.shape)),)
