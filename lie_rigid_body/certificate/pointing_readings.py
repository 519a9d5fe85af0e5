"""Readings of an attitude sensor and a sun sensor computed anew; see `readings`."""

from __future__ import annotations

from typing import Any

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.readings import LARGEST_DEVIATE, ROUNDINGS, Expected, Readings, seconds, turned
from lie_rigid_body.motion.drift import U
from lie_rigid_body.sensors import AttitudeSensor, SunSensor
from lie_rigid_body.simulation import Segment


class AttitudeReadings(Readings):
    """What an attitude sensor reads; nothing of it walks. See `Readings` for the parameters."""

    def __init__(self, segment: Segment, duration: float) -> None:
        model = segment.scenario.sensors.attitude_sensor
        assert model is not None
        super().__init__(segment, model.rate, duration)
        self._sensor, self._model = AttitudeSensor(model), model

    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """The attitude and its covariance, which depends on the attitude that is read."""
        model, angle = self._model, self._tolerance.attitude(seconds(elapsed_ns))
        attitude = turned(signal["attitude_xyzw"].values, angle, model.cross_noise + model.roll_noise)
        covariance = signal["covariance"].values.reshape(-1, 9)
        size = model.cross_noise**2 + model.roll_noise**2
        # the boresight turns by the angle, which is twice the error of the quaternion, and stands in it twice
        uncertainty = np.broadcast_to(size * (4.0 * attitude.uncertainty[:, :1] + ROUNDINGS * U), covariance.shape)
        return attitude, Expected(covariance, uncertainty)


class SunReadings(Readings):
    """What a sun sensor reads; nothing of it walks. See `Readings` for the parameters."""

    def __init__(self, segment: Segment, duration: float) -> None:
        model = segment.scenario.sensors.sun_sensor
        assert model is not None
        super().__init__(segment, model.rate, duration)
        self._sensor = SunSensor(model)
        self._rounding = ROUNDINGS * U * (1.0 + LARGEST_DEVIATE * model.noise)

    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """The direction of the sun."""
        uncertainty = self._tolerance.attitude(seconds(elapsed_ns)) + self._rounding
        direction = signal["direction"].values
        return (Expected(direction, np.broadcast_to(uncertainty[:, np.newaxis], direction.shape)),)
