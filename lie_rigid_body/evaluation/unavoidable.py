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
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import numbers, quantity, read_series, read_stamps, real_numbers
from lie_rigid_body.evaluation.attitudes import turns
from lie_rigid_body.evaluation.consistency import factor_of
from lie_rigid_body.evaluation.kalman_covariances import Steps, covariances
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import components, shown
from lie_rigid_body.lie import quaternion, so3

LARGEST_DEVIATION: Final = 1e50
"""Largest standard deviation, and largest vector: squares and their ratios stay finite."""
SMALLEST_NOISE: Final = 1e-14
"""Least standard deviation of a reading, as a share of the vector or in rad: 45 roundings of double precision.

Measured with MEMS sensors: at 9e-15 all digits that are shown are right, at 9e-17 the smoother errs by half."""
AT_RANDOM: Final = np.pi**2 / 3.0 + 2.0
"""Mean square of the total angle of an attitude at random, whose angle θ has the density (1 − cos θ)/π; rad²."""
UNSEEN: Final = 0.25
"""Variance of the attitude about an axis, rad², from which on no reading tells anything about that axis."""


def deviation(name: str, value: object, *, or_zero: bool = False) -> None:
    """Refuse what is no standard deviation of a noise, or so large that its square is none.

    Raises
    ------
    InputError
    """
    number = quantity(name, value, "SI units", "0.01", or_zero=or_zero)
    if number and not 1.0 / LARGEST_DEVIATION < number < LARGEST_DEVIATION:
        raise InputError(f"{name}: {number:g} is beyond 1e-50 to 1e50: give its standard deviation in SI units")


def _require_resolved(name: str, relative: float) -> None:
    """Refuse a noise beside which the other numbers of the error state are lost in rounding."""
    if relative < SMALLEST_NOISE:
        raise InputError(
            f"{name}: a deviation of {relative:.3g} of what is read is below {SMALLEST_NOISE:g}: rounding is larger"
        )


def _require_kind(name: str, value: object, kind: type, *, several: bool = False) -> None:
    """Refuse what is not of a kind, or not several of it in a sequence."""
    each = value if several else [value]
    if not isinstance(each, Sequence) or not all(isinstance(one, kind) for one in each):
        raise InputError(f"{name}: {shown(value)} is none: give a {'list of ' * several}{kind.__name__}")


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


@short_dataclass(frozen=True, eq=False)
class VectorReadings:
    """Readings of a vector that is constant in the world, such as gravity or the magnetic field.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (L,)
    vector : array_like, shape (3,)
        In the world frame, its length above 1e-50 and below 1e50; not 0, which would tell nothing.
    noise : float
        Standard deviation of the white noise on each axis of a reading, unit of the vector; at least 1e-14 of it.
    bias : BiasNoise, optional
    linear_errors : array_like, shape (c, 3, 3), optional
        Matrices L_i: the reading of x has the error Σ θ_i L_i x, with unknown constants θ_i of variance 1 about 0.
    """

    stamps_ns: ArrayLike
    vector: ArrayLike
    noise: float
    bias: BiasNoise = BiasNoise()
    linear_errors: ArrayLike | None = None

    def __post_init__(self) -> None:
        read_stamps("VectorReadings", self.stamps_ns)
        _matrices("linear_errors", self.linear_errors)
        vector = numbers("vector", self.vector, 3)
        if vector.shape != (3,) or not vector.any():
            raise InputError(f"vector: {shown(self.vector)} has no direction: give three numbers that are not all 0")
        length = float(so3.norm(vector))
        if not 1.0 / LARGEST_DEVIATION < length < LARGEST_DEVIATION:
            raise InputError(f"vector: its length {length:g} is beyond 1e-50 to 1e50: give it in SI units")
        deviation("noise of a vector", self.noise)
        _require_resolved("noise", self.noise / length)
        _require_kind("bias", self.bias, BiasNoise)


@short_dataclass(frozen=True, eq=False)
class AttitudeReadings:
    """Readings of the whole attitude, as of a star tracker.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (L,)
    covariance : array_like, shape (3, 3)
        Of the error of a reading on the body's axes, rad²; the least deviation is at least 1e-14 rad.
    """

    stamps_ns: ArrayLike
    covariance: ArrayLike

    def __post_init__(self) -> None:
        read_stamps("AttitudeReadings", self.stamps_ns)
        self.whitening()

    def whitening(self) -> Array:
        """Matrix that makes the error of a reading one of unit variance on each axis, shape (3, 3)."""
        covariance = numbers("covariance", self.covariance, 3, 3)
        if covariance.ndim > 2:
            raise InputError(f"covariance: shape {covariance.shape} is not (3, 3): give one for all readings")
        factor = factor_of(covariance)
        _require_resolved("covariance", float(np.linalg.svd(factor, compute_uv=False)[-1]))
        return np.asarray(np.linalg.inv(factor))


@short_dataclass(frozen=True, eq=False)
class UnavoidableError:
    """Bounds of the attitude's error at each sample, for estimators that do not know the constants of the sensors.

    Parameters
    ----------
    filtered : ndarray, shape (N, 3, 3)
        Covariance of the error on the body's axes, rad², from the readings up to the sample.
    smoothed : ndarray, shape (N, 3, 3)
        Covariance of the error on the body's axes, rad², from all readings.
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
        If stamps do not rise, readings are no such list, or a noise is not above 0: without it there is no bound but 0.
    """
    stamps, truth = read_series("unavoidable_error", stamps_ns, truth_xyzw)
    if not (np.diff(stamps) > 0).all():
        raise InputError("stamps_ns: one occurs twice: give rising ones")
    deviation("gyro_noise", gyro_noise)
    deviation("initial", initial)
    _require_kind("gyro_bias", gyro_bias, BiasNoise)
    _require_kind("vectors", vectors, VectorReadings, several=True)
    _require_kind("attitudes", attitudes, AttitudeReadings, several=True)
    readings = np.ones(len(stamps)) if gyro_readings is None else numbers("gyro_readings", gyro_readings, len(stamps))
    if readings.shape != stamps.shape or readings.min() < 1.0:
        raise InputError(
            f"gyro_readings: {shown(gyro_readings)}: give a number of 1 or more for each of {len(stamps)} stamps"
        )
    gyro_errors = _matrices("gyro_linear_errors", gyro_linear_errors)
    noise, walk = gyro_noise / np.sqrt(readings), gyro_bias.step * np.sqrt(readings) * (np.arange(len(stamps)) > 0)
    steps, first = _system(stamps, truth, initial, noise, walk, gyro_bias, gyro_errors, vectors, attitudes)
    known, unknown = covariances(steps, first)
    # where a sample's readings stand for some that come one by one until the next, a filter is between before and after
    share = (0.5 - 0.5 / readings)[:, np.newaxis, np.newaxis]
    R = quaternion.to_matrix(truth[-1])

    def bound(found: Array, calibrated: UnavoidableError | None = None) -> UnavoidableError:
        before, filtered, smoothed = found
        filtered = filtered + share * (before - filtered)
        bias = np.zeros((len(stamps), 3, 3)) if gyro_bias == BiasNoise() else filtered[:, 3:6, 3:6]
        unobserved = _unobserved(R @ filtered[-1, :3, :3] @ R.T) if initial**2 > UNSEEN else ""
        return UnavoidableError(filtered[:, :3, :3], smoothed[:, :3, :3], bias, stamps, unobserved, calibrated)

    return bound(unknown, bound(known) if steps[3].size else None)


def _matrices(name: str, given: ArrayLike | None) -> Array:
    """Linear errors of a sensor, shape (c, 3, 3); none by default."""
    read = real_numbers(name, () if given is None else given, "(c, 3, 3)")
    return numbers(name, read, 3, 3).reshape(-1, 3, 3) if read.size else np.zeros((0, 3, 3))


def _unobserved(world_covariance: Array) -> str:
    """Name of the directions of the world about which an error of half a radian or more would not be seen."""
    variances, axes = np.linalg.eigh(world_covariance)
    axis = axes[:, -1] * np.sign(axes[np.argmax(np.abs(axes[:, -1])), -1])
    one = f"a turn about {'the vertical' if axis[2] > 0.999 else f'({components(axis, 3)}) of the world'}"
    return ("", one, "the attitude", "the attitude")[np.count_nonzero(variances > UNSEEN)]


def _system(
    stamps: Integers,
    truth: Array,
    initial: float,
    gyro_noise: Array,
    gyro_walk: Array,
    gyro_bias: BiasNoise,
    gyro_errors: Array,
    vectors: Sequence[VectorReadings],
    attitudes: Sequence[AttitudeReadings],
) -> tuple[Steps, Array]:
    """The linear system of the error state, and the deviations of its state before the first sample.

    A bias counts in units of its vector: the numbers are near those of angles, and rounding is small. Biases that are 0
    for ever are no part of the state. Each constant of each sensor has a column: what it adds to a turn, and to the
    readings of a vector.
    """
    units = [1.0, *(float(so3.norm(sensor.vector)) for sensor in vectors)]
    biases = [gyro_bias, *(sensor.bias for sensor in vectors)]
    matrices = [gyro_errors, *(_matrices("linear_errors", sensor.linear_errors) for sensor in vectors)]
    ends = np.cumsum([0, *map(len, matrices)]).tolist()
    columns = [slice(*part) for part in pairwise(ends)]
    count, n, c, sensors = len(stamps), 3 + 3 * len(biases), ends[-1], len(vectors) + len(attitudes)
    F = np.tile(np.eye(n), (count, 1, 1))
    noise, B = np.zeros((count, 1 + len(biases), 3, n)), np.zeros((count, n, c))
    H, D = np.zeros((count, sensors, 3, n)), np.zeros((count, sensors, 3, c))
    turn = np.concatenate([np.zeros((1, 3)), turns(truth[:-1], truth[1:])])
    jacobian = so3.right_jacobian(turn)
    pushed = (np.diff(stamps, prepend=stamps[0]) / 1e9)[:, np.newaxis, np.newaxis] * jacobian
    F[:, :3, :3], F[:, :3, 3:6] = so3.exp(-turn), pushed
    noise[:, 1, :, 3:6] = _diagonal(gyro_walk)
    B[:, :3, columns[0]] = jacobian @ np.einsum("cij,nj->nic", gyro_errors, turn)
    for i, (sensor, unit) in enumerate(zip(vectors, units[1:], strict=True)):
        read = _count(stamps, sensor)
        weight = np.sqrt(read) * (unit / sensor.noise)  # as many readings of one vector are one of as much less noise
        direction = np.asarray(sensor.vector, dtype=np.float64) / unit
        body = weight[:, np.newaxis] * quaternion.rotate(quaternion.conjugate(truth), direction)
        H[:, i, :, :3], H[:, i, :, 6 + 3 * i : 9 + 3 * i] = -so3.hat(body), _diagonal(weight)
        D[:, i, :, columns[i + 1]] = np.einsum("cij,nj->nic", matrices[i + 1], body)
        read[np.argmax(read > 0.0)] -= 1.0  # the bias begins at the first
        noise[:, 2 + i, :, 6 + 3 * i : 9 + 3 * i] = _diagonal(sensor.bias.step / unit * np.sqrt(np.maximum(read, 0.0)))
    for i, attitude in enumerate(attitudes, len(vectors)):
        H[:, i, :, :3] = np.sqrt(_count(stamps, attitude))[:, np.newaxis, np.newaxis] * attitude.whitening()
    # the noise of a turn, to which a step of the bias adds in the same interval
    of_turn = np.stack([gyro_noise, gyro_walk], axis=1)
    noise[:, :2, :, :3] = of_turn[..., np.newaxis, np.newaxis] * pushed.swapaxes(1, 2)[:, np.newaxis]
    # the recursion divides by what a bias that wanders begins with
    begins = [max(bias.turn_on, 1e-6 * bias.step) / unit for bias, unit in zip(biases, units, strict=True)]
    first = np.repeat([initial, *begins], 3)
    pushes, rows, of_constants = (part.reshape(count, 3 * part.shape[1], part.shape[3]) for part in (noise, H, D))
    kept = first > 0.0
    return (F[:, kept][..., kept], pushes[..., kept], rows[..., kept], B[:, kept], of_constants), first[kept]


def _count(stamps: Integers, readings: VectorReadings | AttitudeReadings) -> Array:
    """Number of readings that count at each sample: those from it on until the next; none before the first."""
    at = np.searchsorted(stamps, read_stamps("readings", readings.stamps_ns), side="right") - 1
    return np.bincount(at[at >= 0], minlength=len(stamps)).astype(np.float64)


def _diagonal(values: Array) -> Array:
    """Multiples of the identity, shape (N, 3, 3)."""
    return np.asarray(values[:, np.newaxis, np.newaxis] * np.eye(3))
