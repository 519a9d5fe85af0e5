"""The attitude error that the noise of the sensors makes unavoidable: the Cramér–Rao bound along the true motion.

An estimator that reads a gyro and known directions (gravity, the magnetic field) and knows nothing of the body has the
error state x = (δ, β, ...). The attitude's error δ is a rotation vector on the body's axes, R̂ = R exp(δ). Then come
the gyro's bias, and a bias of each other sensor that has one. Beside it are constants θ that it does not know: scale,
mounting and soft iron add Σ θ_i L_i x to the reading of a vector x. Linearised at the true motion and at sensors
without them,

    δ_k = exp(−hω) δ_(k−1) + h J_r (β_k + Σ θ_i L_i ω_k + n_k),   b_k = b_(k−1) + w_k
    y_k = −[Rᵀv]× δ_k + a_k + Σ θ_i L_i Rᵀv + m_k

with the right Jacobian J_r at hω, known variances of the noises n, w and m, and the reading y of a world vector v. For
Gaussian noise the covariances of the Kalman filter of this system are the posterior Cramér–Rao bound of every filter
that uses readings up to a time. Those of its Rauch–Tung–Striebel smoother are the bound of every estimator that uses
all of them. Both hold as far as the error is small enough for the linearisation.

References
----------
P. Tichavský, C. H. Muravchik, A. Nehorai, "Posterior Cramér–Rao bounds for discrete-time nonlinear filtering", IEEE
Transactions on Signal Processing 46 (1998) 1386. H. E. Rauch, F. Tung, C. T. Striebel, AIAA Journal 3 (1965) 1445.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import numbers, quantity, read_stamps, unit
from lie_rigid_body.evaluation.attitudes import turns
from lie_rigid_body.evaluation.kalman_covariances import Covariances, covariances, padded
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.lie.so3 import hat, right_jacobian
from lie_rigid_body.wording import components, short_repr, shown

LARGEST_DEVIATION: Final = 1e50
"""Largest standard deviation: squares and their ratios stay finite."""


def deviation(name: str, value: object, *, or_zero: bool = False) -> None:
    """Refuse what is no standard deviation of a noise, or so large that its square is none.

    Raises
    ------
    InputError
    """
    number = quantity(name, value, "SI units", "0.01", or_zero=or_zero)
    if number and not 1.0 / LARGEST_DEVIATION < number < LARGEST_DEVIATION:
        raise InputError(f"{name}: {number:g} is beyond 1e-50 to 1e50: give its standard deviation in SI units")


@dataclass(frozen=True)
class BiasNoise:
    """Noise of a bias on each axis: how it begins and wanders.

    Parameters
    ----------
    turn_on : float
        Standard deviation at the first reading, unit of the readings.
    step : float
        Standard deviation of its change from one reading to the next.
    """

    turn_on: float = 0.0
    step: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("turn_on", self.turn_on), ("step", self.step)):
            deviation(name, value, or_zero=True)


@dataclass(frozen=True)
class VectorReadings:
    """Readings of a vector that is constant in the world, such as gravity or the magnetic field.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (L,)
    vector : array_like, shape (3,)
        In the world frame; not 0, which would tell nothing.
    noise : float
        Standard deviation of the white noise on each axis of a reading, unit of the vector; above 0.
    bias : BiasNoise, optional
    linear_errors : array_like, shape (c, 3, 3), optional
        Matrices L_i: the reading of x has the error Σ θ_i L_i x, with unknown constants θ_i of variance 1 about 0.
    """

    stamps_ns: ArrayLike
    vector: ArrayLike
    noise: float
    bias: BiasNoise = BiasNoise()
    linear_errors: ArrayLike | None = None

    __repr__ = short_repr

    def __post_init__(self) -> None:
        read_stamps("VectorReadings", self.stamps_ns)
        self.matrices()
        vector = numbers("vector", self.vector, 3)
        if vector.shape != (3,) or not vector.any():
            raise InputError(f"vector: {shown(self.vector)} has no direction: give three numbers that are not all 0")
        deviation("noise of a vector", self.noise)
        if not isinstance(self.bias, BiasNoise):
            raise InputError(f"bias: {shown(self.bias)} is no BiasNoise: give for example BiasNoise(turn_on=0.03)")

    def matrices(self) -> Array:
        """The linear errors, shape (c, 3, 3)."""
        return _matrices("linear_errors", self.linear_errors)


@dataclass(frozen=True)
class AttitudeReadings:
    """Readings of the whole attitude, as of a star tracker.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (L,)
    covariance : array_like, shape (3, 3)
        Of the error of a reading on the body's axes, rad²; it has an inverse.
    """

    stamps_ns: ArrayLike
    covariance: ArrayLike

    __repr__ = short_repr

    def __post_init__(self) -> None:
        read_stamps("AttitudeReadings", self.stamps_ns)
        self.whitening()

    def whitening(self) -> Array:
        """Matrix that makes the error of a reading one of unit variance on each axis, shape (3, 3)."""
        covariance = numbers("covariance", self.covariance, 3, 3)
        if covariance.ndim > 2:
            raise InputError(f"covariance: shape {covariance.shape} is not (3, 3): give one for all readings")
        try:
            return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))
        except np.linalg.LinAlgError:
            raise InputError("covariance: not positive definite: give one that has an inverse") from None


@dataclass(frozen=True)
class UnavoidableError:
    """Bounds of the attitude's error at each sample, for estimators that do not know the constants of the sensors.

    Parameters
    ----------
    filtered : ndarray, shape (N, 3, 3)
        Covariance of the error on the body's axes, rad², from the readings up to the sample.
    smoothed : ndarray, shape (N, 3, 3)
        The same from all readings.
    gyro_bias : ndarray, shape (N, 3, 3)
        Covariance of the gyro's bias from the readings up to the sample, (rad/s)²; zeros where it has none.
    stamps_ns : ndarray of int64, shape (N,)
    unobserved : str
        What no reading tells, in words: ``the attitude``, or ``a turn about the vertical``. Empty if all is told.
    calibrated : UnavoidableError or None
        Bounds for estimators that know the constants; None where there are none.
    """

    filtered: Array
    smoothed: Array
    gyro_bias: Array
    stamps_ns: Integers
    unobserved: str = ""
    calibrated: UnavoidableError | None = None

    __repr__ = short_repr

    @staticmethod
    def rms(covariance: Array) -> float:
        """Root mean square of the total angle over all samples, rad; at most that of a guess, 2.3 rad."""
        return float(np.sqrt(np.mean(mean_square(covariance))))


def mean_square(covariance: Array) -> Array:
    """Mean square of the total angle of each covariance, rad², shape (...): no more than of an attitude at random."""
    return np.asarray(np.minimum(np.trace(covariance, axis1=-2, axis2=-1), AT_RANDOM))


def unavoidable_error(
    stamps_ns: ArrayLike,
    truth_xyzw: ArrayLike,
    *,
    gyro_noise: float,
    gyro_bias: BiasNoise = BiasNoise(),
    vectors: Sequence[VectorReadings] = (),
    attitudes: Sequence[AttitudeReadings] = (),
    initial: float = np.pi,
    gyro_readings: ArrayLike | None = None,
    gyro_linear_errors: ArrayLike | None = None,
) -> UnavoidableError:
    """Bound the errors of every estimator that reads a gyro at each sample, and vectors at some.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (N,)
        Of the gyro's readings; each tells the turn since the one before.
    truth_xyzw : array_like, shape (N, 4)
        The true attitude at them, world-from-body.
    gyro_noise : float
        Standard deviation of the white noise on each axis of a reading, rad/s; above 0.
    gyro_bias : BiasNoise, optional
        rad/s.
    vectors : sequence of VectorReadings, optional
        Each reading counts at the gyro's reading before it, or with it.
    attitudes : sequence of AttitudeReadings, optional
        The same.
    initial : float, optional
        Standard deviation of the first attitude on each axis, rad; half a turn if nothing is known of it.
    gyro_readings : array_like of int, shape (N,), optional
        From how many readings of the gyro each turn is the sum, by default one: for the bound at some stamps of many.
    gyro_linear_errors : array_like, shape (c, 3, 3), optional
        As those of `VectorReadings`, of the gyro.

    Returns
    -------
    UnavoidableError

    Raises
    ------
    InputError
        If stamps do not rise, or a noise is not above 0: without noise there is no bound but 0.
    """
    stamps, truth = read_stamps("stamps_ns", stamps_ns), unit("truth_xyzw", truth_xyzw)
    _require(stamps, truth, gyro_bias, vectors, attitudes)
    deviation("gyro_noise", gyro_noise)
    deviation("initial", initial)
    readings = _readings(gyro_readings, len(stamps))
    walk = gyro_bias.step * np.sqrt(readings) * (np.arange(len(stamps)) > 0)
    gyro_errors = _matrices("gyro_linear_errors", gyro_linear_errors)
    system = _System(stamps, truth, gyro_noise / np.sqrt(readings), walk, gyro_bias, gyro_errors, vectors, attitudes)
    known, unknown = system.covariances(initial)
    # where a sample's readings stand for some that come one by one until the next, a filter is between before and after
    share = (0.5 - 0.5 / readings)[:, np.newaxis, np.newaxis]
    R = quaternion.to_matrix(truth[-1])

    def bound(found: Covariances, calibrated: UnavoidableError | None = None) -> UnavoidableError:
        filtered = found.filtered + share * (found.before - found.filtered)
        bias = filtered[:, 3:6, 3:6] if system.gyro_bias is not None else np.zeros((len(stamps), 3, 3))
        unobserved = _unobserved(R @ filtered[-1, :3, :3] @ R.T) if initial**2 > UNSEEN else ""
        return UnavoidableError(filtered[:, :3, :3], found.smoothed[:, :3, :3], bias, stamps, unobserved, calibrated)

    return bound(unknown, bound(known) if system.constants else None)


def _matrices(name: str, given: ArrayLike | None) -> Array:
    """Linear errors of a sensor, shape (c, 3, 3); none by default."""
    return np.zeros((0, 3, 3)) if given is None or np.size(given) == 0 else numbers(name, given, 3, 3).reshape(-1, 3, 3)


def _require(
    stamps: Integers,
    truth: Array,
    gyro_bias: BiasNoise,
    vectors: Sequence[VectorReadings],
    attitudes: Sequence[AttitudeReadings],
) -> None:
    if truth.shape != (len(stamps), 4) or not (np.diff(stamps) > 0).all():
        raise InputError(
            f"stamps_ns: {stamps.shape} stamps for {truth.shape} attitudes: give rising ones, one for each"
        )
    if not isinstance(gyro_bias, BiasNoise):
        raise InputError(f"gyro_bias: {shown(gyro_bias)} is no BiasNoise: give for example BiasNoise(turn_on=3e-3)")
    kinds = {"vectors": (vectors, VectorReadings), "attitudes": (attitudes, AttitudeReadings)}
    for name, (given, kind) in kinds.items():
        if not isinstance(given, list | tuple) or not all(isinstance(readings, kind) for readings in given):
            raise InputError(f"{name}: {shown(given)} is not a list of {kind.__name__}: give a list of them")


def _readings(given: ArrayLike | None, count: int) -> Array:
    readings = np.ones(count) if given is None else numbers("gyro_readings", given, count)
    if readings.shape != (count,) or readings.min() < 1.0:
        raise InputError(f"gyro_readings: {shown(given)}: give a number of 1 or more for each of {count} stamps")
    return readings


def _unobserved(world_covariance: Array) -> str:
    """Name of the directions of the world about which an error of half a radian or more would not be seen."""
    variances, axes = np.linalg.eigh(world_covariance)
    if np.count_nonzero(variances > UNSEEN) > 1:
        return "the attitude"
    if variances[-1] <= UNSEEN:
        return ""
    axis = axes[:, -1] * np.sign(axes[np.argmax(np.abs(axes[:, -1])), -1])
    if axis[2] > VERTICAL:
        return "a turn about the vertical"
    return f"a turn about ({components(axis, 3)}) of the world"


class _System:
    """The linear system of the error state: what each step does to it, and what the readings of each sample tell."""

    def __init__(
        self,
        stamps: Integers,
        truth: Array,
        gyro_noise: Array,
        gyro_walk: Array,
        gyro_bias: BiasNoise,
        gyro_errors: Array,
        vectors: Sequence[VectorReadings],
        attitudes: Sequence[AttitudeReadings],
    ) -> None:
        # a bias counts in units of its vector: the numbers are near those of angles, and rounding is small
        units = [1.0, *(float(np.linalg.norm(sensor.vector)) for sensor in vectors)]
        biases = [gyro_bias, *(sensor.bias for sensor in vectors)]
        places, size = [], 3
        for bias in biases:
            known = bias.turn_on == 0.0 and bias.step == 0.0
            places.append(None if known else size)
            size += 0 if known else 3
        self.gyro_bias, *vector_biases = places
        self.size, self._stamps = size, stamps
        self._turn_on = [
            (place, max(bias.turn_on, SMALLEST * bias.step) / unit)
            for place, bias, unit in zip(places, biases, units, strict=True)
            if place
        ]
        self._padding = (0, padded(len(stamps)) - len(stamps))
        truth = np.pad(truth, (self._padding, (0, 0)), "edge")
        interval = np.diff(np.pad(stamps, self._padding, "edge"), prepend=stamps[0]) / 1e9
        turn = np.zeros((len(truth), 3))
        turn[1:] = turns(truth[:-1], truth[1:])
        self._back, jacobian = so3.exp(-turn), right_jacobian(turn)
        self._pushed = interval[:, np.newaxis, np.newaxis] * jacobian
        self._gyro_noise = np.pad(gyro_noise, self._padding)
        self._walks = [] if self.gyro_bias is None else [(self.gyro_bias, np.pad(gyro_walk, self._padding))]
        self._vectors = [self._vector(*each, truth) for each in zip(vectors, vector_biases, strict=True)]
        self._attitudes = [(self._count(each), each.whitening()) for each in attitudes]
        # a column for each constant of each sensor: what it adds to a turn, and to the readings of a vector
        errors = [gyro_errors, *(sensor.matrices() for sensor in vectors)]
        ends = np.cumsum([len(each) for each in errors]).tolist()
        self._columns = [slice(end - len(each), end) for each, end in zip(errors, ends, strict=True)]
        self.constants: int = ends[-1]
        self._turned = jacobian @ _errors(gyro_errors, turn)
        self._read = [_errors(matrices, body) for matrices, (body, _, _) in zip(errors[1:], self._vectors, strict=True)]

    def _count(self, readings: VectorReadings | AttitudeReadings) -> Array:
        """Number of readings that count at each sample: those from it on until the next; none before the first."""
        at = np.searchsorted(self._stamps, read_stamps("readings", readings.stamps_ns), side="right") - 1
        return np.pad(np.bincount(at[at >= 0], minlength=len(self._stamps)).astype(np.float64), self._padding)

    def _vector(self, sensor: VectorReadings, place: int | None, truth: Array) -> tuple[Array, Array, int | None]:
        """Readings at each sample: derivative by a turn over the noise, one over the noise, and place of the bias."""
        count, unit = self._count(sensor), float(np.linalg.norm(sensor.vector))
        if place is not None and count.any():
            steps = count.copy()
            steps[np.flatnonzero(count)[0]] -= 1.0
            self._walks.append((place, sensor.bias.step / unit * np.sqrt(steps)))
        weight = np.sqrt(count) * (unit / sensor.noise)  # as many readings of one vector are one of as much less noise
        body = quaternion.rotate(quaternion.conjugate(truth), np.asarray(sensor.vector, dtype=np.float64) / unit)
        return weight[:, np.newaxis] * body, weight, place

    def steps(self, k: Integers) -> tuple[Array, Array, Array, Array, Array]:
        """Steps to samples by number: transition, root of the noise, what readings tell, and the constants' parts."""
        transition = np.tile(np.eye(self.size), (len(k), 1, 1))
        transition[:, :3, :3] = self._back[k]
        noise = np.zeros((len(k), 1 + len(self._walks), 3, self.size))
        pushed = self._pushed[k].swapaxes(1, 2)
        noise[:, 0, :, :3] = self._gyro_noise[k, np.newaxis, np.newaxis] * pushed
        for i, (place, walk) in enumerate(self._walks, 1):
            noise[:, i, :, place : place + 3] = walk[k, np.newaxis, np.newaxis] * np.eye(3)
            if place == self.gyro_bias:  # a step of the bias acts on the turn of the same interval
                noise[:, i, :, :3] = walk[k, np.newaxis, np.newaxis] * pushed
        if self.gyro_bias is not None:
            transition[:, :3, self.gyro_bias : self.gyro_bias + 3] = self._pushed[k]
        turned = np.zeros((len(k), self.size, self.constants))
        turned[:, :3, self._columns[0]] = self._turned[k]
        seen, read = self._seen(k)
        return transition, noise.reshape(len(k), -1, self.size), seen, turned, read

    def _seen(self, k: Integers) -> tuple[Array, Array]:
        """Rows of the readings at samples, of unit variance each: three for each sensor, by state and by constants."""
        sensors = len(self._vectors) + len(self._attitudes)
        seen = np.zeros((len(k), sensors, 3, self.size))
        read = np.zeros((len(k), sensors, 3, self.constants))
        for i, (body, weight, place) in enumerate(self._vectors):
            seen[:, i, :, :3] = -hat(body[k])
            if place is not None:
                seen[:, i, :, place : place + 3] = weight[k, np.newaxis, np.newaxis] * np.eye(3)
            read[:, i, :, self._columns[i + 1]] = self._read[i][k]
        for i, (count, whitening) in enumerate(self._attitudes, len(self._vectors)):
            seen[:, i, :, :3] = np.sqrt(count[k])[:, np.newaxis, np.newaxis] * whitening
        return seen.reshape(len(k), 3 * sensors, self.size), read.reshape(len(k), 3 * sensors, self.constants)

    def covariances(self, initial: float) -> tuple[Covariances, Covariances]:
        """Covariances of the error state at each sample, where the constants are known, and where they are not."""
        deviations = np.full(self.size, initial)
        for place, deviation in self._turn_on:
            deviations[place : place + 3] = deviation
        return covariances(self.steps, len(self._stamps), deviations, self.constants)


def _errors(matrices: Array, vectors: Array) -> Array:
    """Derivatives of the readings of vectors, (N, 3), by the constants of a sensor, shape (N, 3, c)."""
    return np.asarray(np.einsum("cij,nj->nic", matrices, vectors))


SMALLEST: Final = 1e-6
"""Turn-on of a bias that has none, in steps of its walk: the recursion divides by it."""
AT_RANDOM: Final = np.pi**2 / 3.0 + 2.0
"""Mean square of the total angle of an attitude at random, whose angle θ has the density (1 − cos θ)/π; rad²."""
UNSEEN: Final = 0.25
"""Variance about an axis from which on nothing is known of it, rad²."""
VERTICAL: Final = 0.999
"""Cosine between an axis and the vertical above which the axis is called vertical."""
