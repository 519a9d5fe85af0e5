"""Readings of an IMU and its biases computed anew; see `readings`."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.readings import (
    DEVIATE,
    LARGEST_DEVIATE,
    ROUNDINGS,
    Expected,
    Readings,
    Times,
    deviate_rounding,
    may_repeat,
    seconds,
    size_of,
    turned,
)
from lie_rigid_body.lie import so3
from lie_rigid_body.motion.drift import U
from lie_rigid_body.sensors import Imu, ImuModel
from lie_rigid_body.sensors.triad import TriadModel
from lie_rigid_body.simulation import Segment

_WALK: Final = 8.0
"""Factor of random walks, in standard deviations."""
_OF_CENTRIPETAL: Final = math.sqrt(2.0) + 2.0
_BLOCKS_KEPT: Final = 4
"""Blocks of an IMU's biases that wait for the topic that tells them, which may end at another reading."""


class ImuReadings(Readings):
    """What an IMU reads. See `Readings` for the parameters."""

    def __init__(self, segment: Segment, duration: float) -> None:
        model = _imu_of(segment)
        super().__init__(segment, model.rate, duration)
        self._model, self._sensor = model, _imu(self._times, model, segment)
        self._biases = _last_biases(segment)
        self._span = None if model.gyro_rate == "instantaneous" else 1.0 / model.rate
        fastest, arm = self._tolerance.fastest, float(so3.norm(np.array(model.lever_arm)))
        self._force_of_rate = _OF_CENTRIPETAL * fastest * fastest * arm
        self.walks, self.repeats = _walks(model), may_repeat(model.gyro.faults, model.accelerometer.faults)
        self._of_orientation = 0.0 if model.orientation is None else sum(vars(model.orientation).values())
        self._gyro = _Uncertainty(model.gyro, model.rate, fastest)
        self._accelerometer = _Uncertainty(
            model.accelerometer, model.rate, 2.0 * fastest * fastest * arm + model.support
        )

    def _signal(self, elapsed_ns: Integers) -> Any:
        signals = super()._signal(elapsed_ns)
        self._biases.keep(elapsed_ns, signals["gyro_bias"].values, signals["accelerometer_bias"].values)
        return signals

    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """Orientation, if it tells one, angular velocity and specific force."""
        t, limits, model = seconds(elapsed_ns), self._tolerance, self._model
        relative = limits.rate(t)
        rate = limits.fastest * relative if self._span is None else limits.mean_rate(t, self._span)
        force = np.asarray(self._force_of_rate * relative)
        if model.support:
            force += model.support * limits.attitude(t)
        attitude = signal.get("orientation_xyzw")
        oriented = () if attitude is None else (turned(attitude.values, limits.attitude(t), self._of_orientation),)
        return (
            *oriented,
            Expected(signal["gyro"].values, self._gyro.at(rate, before), model.gyro.converter),
            Expected(
                signal["specific_force"].values, self._accelerometer.at(force, before), model.accelerometer.converter
            ),
        )


class _LastBiases:
    """The biases of an IMU that were computed last, for the two topics that tell them."""

    def __init__(self) -> None:
        self._kept: tuple[tuple[Integers, Array, Array], ...] = ()

    def keep(self, elapsed_ns: Integers, gyro: Array, accelerometer: Array) -> None:
        """Keep those of readings at so many ns after the start, and of some before."""
        before = [block for block in self._kept if block[0][-1] < elapsed_ns[0]]  # others are of an earlier certificate
        self._kept = (*before, (elapsed_ns, gyro, accelerometer))[-_BLOCKS_KEPT:]

    def of(self, elapsed_ns: Integers) -> tuple[Array, Array] | None:
        """Those of gyro and accelerometer at consecutive readings, if all of them are kept."""
        gyro, accelerometer = [np.empty((0, 3))], [np.empty((0, 3))]
        for times, *biases in self._kept:
            rows = slice(*np.searchsorted(times, [elapsed_ns[0], elapsed_ns[-1] + 1]))
            gyro.append(biases[0][rows])
            accelerometer.append(biases[1][rows])
        found = np.concatenate(gyro), np.concatenate(accelerometer)
        return found if len(found[0]) == len(elapsed_ns) else None


@lru_cache(maxsize=4)
def _last_biases(segment: Segment) -> _LastBiases:
    """What the two topics of a segment's IMU share."""
    return _LastBiases()


class BiasReadings(Readings):
    """The true biases of an IMU, which no motion changes. See `Readings` for the parameters."""

    def __init__(self, segment: Segment, duration: float) -> None:
        model = _imu_of(segment)
        super().__init__(segment, model.rate, duration)
        self._model, self.walks, self.motion_error = model, _walks(model), 0.0
        self._sensor = _imu(self._times, replace(model, gyro_rate="instantaneous"), segment)
        self._biases, self._behind = _last_biases(segment), 0

    def _skip(self, first: int, count: int) -> None:
        self._sensor.skip(count + self._behind, 0, self._times.motion.at(0))
        self._behind = 0

    def _signal(self, elapsed_ns: Integers) -> Any:
        """Those that the readings were computed with, or else as `Imu` computes them alone."""
        known = self._biases.of(elapsed_ns)
        if known is not None:
            self._behind += len(elapsed_ns)
            return known
        if self._behind:
            self._skip(0, 0)
        return self._sensor.biases(elapsed_ns)

    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """Biases of gyro and accelerometer."""
        triads = self._model.gyro, self._model.accelerometer
        limits = (_bias_uncertainty(triad, self._model.rate, before) for triad in triads)
        return tuple(
            Expected(bias, np.broadcast_to(limit, bias.shape)) for bias, limit in zip(signal, limits, strict=True)
        )


def _walks(model: ImuModel) -> bool:
    return bool(model.gyro.bias_random_walk or model.accelerometer.bias_random_walk)


def _imu_of(segment: Segment) -> ImuModel:
    model: ImuModel = segment.scenario.sensors.imu
    return model


def _imu(times: Times, model: ImuModel, segment: Segment) -> Imu:
    before_ns = times.before(times.first)
    return Imu(model, segment.scenario.body(), before_ns, times.motion.at(before_ns))


class _Uncertainty:
    """How far readings of a triad may be from those of the exact motion.

    Parameters
    ----------
    model : TriadModel
    rate : float
        Readings per second.
    largest : float
        Bound of the true quantity, in the body frame.
    """

    def __init__(self, model: TriadModel, rate: float, largest: float) -> None:
        self._model, self._rate = model, rate
        self._gain = np.abs(model.scale_factor)  # the rows of a rotation have the norm 1
        noise = LARGEST_DEVIATE * model.noise_density * math.sqrt(rate)
        self._rounding = ROUNDINGS * U * (self._gain * largest + noise + size_of(model.faults, rate))

    def at(self, error: Array, k: Array) -> Array:
        """For errors of the true quantity, shape (N,), at readings with so many before them, shape (N, 1)."""
        bias = _bias_uncertainty(self._model, self._rate, k)
        return np.asarray(self._gain * error[:, np.newaxis] + self._rounding + bias)


def _bias_uncertainty(model: TriadModel, rate: float, k: Array) -> Array:
    """Round-off of a bias after k steps, shape (N, 1): of its deviates, and of the sums, each of the bias' size."""
    walked = np.sqrt(k)
    size = LARGEST_DEVIATE * model.turn_on_bias + _WALK * model.bias_random_walk / math.sqrt(rate) * walked
    drift = 0.0 if model.faults is None else model.faults.drift
    return np.asarray(U * (DEVIATE + ROUNDINGS + _WALK * walked) * size + deviate_rounding(drift))
