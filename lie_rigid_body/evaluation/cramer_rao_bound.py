"""The Cramér–Rao bound of the attitude's error along the true motion, by the noise of the sensors.

An estimator that reads a gyro and known directions (gravity, the magnetic field) and does not know the dynamics has the
error state x = (δ, β, ..., θ). The attitude's error δ is a rotation vector on the body's axes, R̂ = R exp(δ). Then come
the gyro's bias, and a bias of each other sensor that has one. The constants θ are those that the estimator does not
know: scale, mounting and soft iron add Σ θ_i L_i x to the reading of a vector x. Linearised at the true motion and at
sensors without them,

    δ_k = exp(−hω) δ_(k−1) + h J_r (β_k + Σ θ_i L_i ω_k + n_k),   b_k = b_(k−1) + w_k
    y_k = −[Rᵀv]× δ_k + a_k + Σ θ_i L_i Rᵀv + m_k

with the right Jacobian J_r at hω, known variances of the noises n, w and m, and the reading y of a world vector v. For
Gaussian noise the covariances of the Kalman filter of this system are the posterior Cramér–Rao bound of every such
filter that uses readings up to a time. Those of its smoother are the bound of every such estimator that uses all of
them. An estimator that knows the constants has the conditional covariance, given θ. All hold as far as the error is
small enough for the linearisation.

An estimator that knows the inertia and Euler's equations has a smaller bound. Its state is the error (δ_0, η_0) of the
attitude and of the body rate at the start, which is constant, and the biases. The errors δ_k and η_k follow from it by
the exact motion, linearised. The gyro's readings are measurements as others are, and only biases have
process noise. As an estimator of the start is one of all times, its covariance by all readings has those of all times.

References
----------
P. Tichavský, C. H. Muravchik, A. Nehorai, "Posterior Cramér–Rao bounds for discrete-time nonlinear filtering", IEEE
Transactions on Signal Processing 46 (1998) 1386.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import field, replace
from itertools import pairwise
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from lie_rigid_body.evaluation.attitudes import relative_rotations
from lie_rigid_body.evaluation.consistency import factor_of
from lie_rigid_body.evaluation.kalman import covariances
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import components
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.lie.vectors import norm

Motion: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]
"""Attitudes and body rates by those at the start."""

MIN_NOISE: Final = 1e-7
"""Smallest standard deviation of a reading, as a share of the vector, in rad or in rad/s.

Measured: at 1e-7 rounding changes a variance by 0.2 %, at 1e-8 the innovations' covariance has no inverse.
"""
MAX_NOISE: Final = 1e50
"""Largest of these: squares and their ratios stay finite."""
AT_RANDOM: Final = np.pi**2 / 3.0 + 2.0
"""Mean square of the total angle of an attitude at random, whose angle θ has the density (1 − cos θ)/π; rad²."""
UNSEEN: Final = 0.25
"""Variance of the attitude about an axis, rad², from which on no reading tells anything about that axis."""
UNKNOWN_RATE: Final = 100.0
"""Standard deviation of a body rate of which nothing is known, rad/s."""
STEP: Final = 1e-7
"""Step of the differences by the start of a motion, rad and rad/s: rounding is 1e-7 of them, and over an hour their
curvature as well."""
DRAWS: Final = 100_000
"""Number of errors drawn at the bound, whose share below an error is told to about 1e-4."""
JOINT: Final = 60
"""Number of stamps at which the smoothed errors of a dynamic bound are known together."""


class BiasNoise(NamedTuple):
    """Noise of a bias on each axis, in the unit of the readings.

    Attributes
    ----------
    turn_on : float
        Standard deviation at the first reading.
    step : float
        Standard deviation of its change from one reading to the next.
    """

    turn_on: float = 0.0
    step: float = 0.0


NO_BIAS: Final = BiasNoise()


@short_dataclass(eq=False)
class VectorReadings:
    """Readings of a vector that is constant in the world, such as gravity or the magnetic field.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (L,)
    vector : ndarray, shape (3,)
        The vector in the world frame; not 0, which would tell nothing.
    noise : float
        Standard deviation of the white noise on each axis of a reading, unit of the vector.
    bias : BiasNoise, optional
    linear_errors : ndarray, shape (c, 3, 3), optional
        Matrices L_i: the reading of x has the error Σ θ_i L_i x, with unknown constants θ_i of variance 1 about 0.
    """

    stamps_ns: Integers
    vector: Array
    noise: float
    bias: BiasNoise = NO_BIAS
    linear_errors: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))


@short_dataclass(eq=False)
class AttitudeReadings:
    """Readings of the whole attitude, as of a star tracker.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (L,)
    covariance : ndarray, shape (3, 3)
        Covariance of the error of a reading on the body's axes, rad².
    """

    stamps_ns: Integers
    covariance: Array


@short_dataclass(eq=False)
class NoisySensors:
    """Sensors of an estimator, with the noise of each.

    Parameters
    ----------
    gyro_noise : float
        Standard deviation of the white noise on each axis of a reading, rad/s.
    gyro_bias : BiasNoise, optional
        rad/s.
    vectors : sequence of VectorReadings, optional
        Each reading counts at the gyro's reading before it, or with it.
    attitudes : sequence of AttitudeReadings, optional
        The same.
    gyro_linear_errors : ndarray, shape (c, 3, 3), optional
        Matrices as those of `VectorReadings`, of the gyro.
    initial : float, optional
        Standard deviation of the first attitude on each axis, rad; half a turn if nothing is known of it.
    """

    gyro_noise: float
    gyro_bias: BiasNoise = NO_BIAS
    vectors: Sequence[VectorReadings] = ()
    attitudes: Sequence[AttitudeReadings] = ()
    gyro_linear_errors: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    initial: float = np.pi

    def calibrated(self) -> NoisySensors:
        """Sensors without linear errors."""
        none = np.zeros((0, 3, 3))
        vectors = [replace(each, linear_errors=none) for each in self.vectors]
        return replace(self, vectors=vectors, gyro_linear_errors=none)


@short_dataclass(eq=False)
class CramerRaoBound:
    """Bounds of the attitude's error at each sample, for estimators that do not know the dynamics.

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
    calibrated : CramerRaoBound or None
        Bounds for estimators that know the constants of the sensors; None where there are none.
    dynamic : CramerRaoBound or None
        Bounds for estimators that know the constants, the inertia and Euler's equations, at stamps of their own.
    joint_ns : ndarray of int64, shape (A,)
        Some of the stamps, of a dynamic bound.
    joint : ndarray, shape (3 A, 3 A)
        Covariance of the smoothed errors at these stamps together, rad².
    carried : bool
        Whether the body is accelerated, and its acceleration counts as known along its own axes.
    """

    filtered: Array
    smoothed: Array
    gyro_bias: Array
    stamps_ns: Integers
    unobserved: str = ""
    calibrated: CramerRaoBound | None = None
    dynamic: CramerRaoBound | None = None
    joint_ns: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    joint: Array = field(default_factory=lambda: np.empty((0, 0)))
    carried: bool = False

    @staticmethod
    def rms(covariance: Array) -> float:
        """Root mean square of the total angle over all samples, rad; at most that of a guess, 2.3 rad."""
        return math.sqrt(np.mean(mean_square(covariance)))

    def is_below(self, stamps_ns: Integers, square: float, probability: float) -> bool:
        """Whether a mean square error, rad², at these stamps is below the point of this probability at the bound.

        The sum of the squares is Σ λ χ², with the eigenvalues λ of the joint covariance, which depends on the six
        numbers of a start; so many are drawn. False of a bound without a joint covariance.
        """
        inside = np.flatnonzero((self.joint_ns >= stamps_ns[0]) & (self.joint_ns <= stamps_ns[-1]))
        if self.unobserved or not len(inside):
            return False
        rows = (3 * inside[:, np.newaxis] + np.arange(3)).reshape(-1)
        sizes = np.linalg.eigvalsh(self.joint[np.ix_(rows, rows)] / len(inside))[-6:].clip(0.0)
        squares = np.random.default_rng(0).chisquare(1.0, (DRAWS, len(sizes))) @ sizes
        return bool(np.mean(squares < square) < probability)


def mean_square(covariance: Array) -> Array:
    """Mean square of the total angle of each covariance, rad², shape (...): no more than of an attitude at random."""
    return np.asarray(np.minimum(np.trace(covariance, axis1=-2, axis2=-1), AT_RANDOM))


def cramer_rao_bound(
    stamps_ns: Integers, truth_xyzw: Array, sensors: NoisySensors, readings: Array | None = None
) -> CramerRaoBound:
    """Bound the errors of every estimator without dynamics that reads a gyro at each sample, and vectors at some.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Rising stamps of the gyro's readings; each tells the turn since the one before.
    truth_xyzw : ndarray, shape (N, 4)
        The true attitude at them, world-from-body, of unit norm.
    sensors : NoisySensors
    readings : ndarray, shape (N,), optional
        Number of readings of the gyro of which each turn is the sum, by default one: for the bound at some stamps of
        many.

    Raises
    ------
    InputError
        If a noise is so small or so large beside what is read that rounding would decide.
    """
    counts = np.ones(len(stamps_ns)) if readings is None else readings
    *system, constants = _system(stamps_ns, truth_xyzw, sensors, counts)
    found = covariances(*_determined(*system))
    whole = _bound(stamps_ns, truth_xyzw, found, sensors, counts)
    if not constants:
        return whole
    given = [_given(P, constants) for P in found]
    return replace(whole, calibrated=_bound(stamps_ns, truth_xyzw, given, sensors, counts))


def dynamic_bound(
    stamps_ns: Integers, motion: Motion, start: tuple[Array, Array], sensors: NoisySensors, readings: Array
) -> CramerRaoBound:
    """Bound the errors of every estimator that reads the same, and knows the inertia and Euler's equations.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        As of `cramer_rao_bound`, as the other parameters are. Linear errors of the sensors are known.
    motion : callable
        Exact motion from an attitude, shape (4,), and a body rate, shape (3,), at the start. It gives the attitudes,
        shape (N, 4), and body rates, rad/s, shape (N, 3), at the stamps.
    start : tuple of ndarray, shapes (4,) and (3,)
        The true attitude and body rate at the start.
    sensors : NoisySensors
    readings : ndarray, shape (N,)

    Raises
    ------
    InputError
        As `cramer_rao_bound`.
    """
    known = sensors.calibrated()
    truth, turn, rate = _flow(motion, *start)
    _, Q, H, deviations, _ = _system(stamps_ns, truth, known, readings)
    # the start in the place of the attitude, and readings of the gyro beside those of the vectors
    weight = (np.sqrt(readings) / known.gyro_noise)[:, np.newaxis, np.newaxis]
    of_gyro = np.broadcast_to(np.eye(3, H.shape[-1] - 3), (len(H), 3, H.shape[-1] - 3))
    H = np.concatenate([np.dstack([H[..., :3] @ turn, H[..., 3:]]), weight * np.dstack([rate, of_gyro])], axis=1)
    Q = np.pad(Q, ((0, 0), (3, 0), (3, 0)))
    Q[:, :6] = Q[:, :, :6] = 0.0
    first = np.insert(deviations, 3, [UNKNOWN_RATE] * 3)
    F = np.broadcast_to(np.eye(len(first)), Q.shape)
    to_now = np.zeros((len(H), 6, len(first)))
    to_now[:, :3, :6] = turn
    to_now[:, 3:, 6:9] = np.eye(3)
    to_now = to_now[..., first > 0.0]
    predicted, updated, _ = covariances(*_determined(F, Q, H, first))
    found = [to_now @ P @ np.swapaxes(to_now, 1, 2) for P in (predicted, updated, updated[-1])]
    bound = _bound(stamps_ns, truth, found, known, readings)
    at = np.unique(np.searchsorted(stamps_ns, np.linspace(stamps_ns[0], stamps_ns[-1], JOINT)))
    some = turn[at].reshape(-1, 6)
    return replace(bound, joint_ns=stamps_ns[at], joint=some @ updated[-1, :6, :6] @ some.T)


def _flow(motion: Motion, attitude_xyzw: Array, body_rate: Array) -> tuple[Array, Array, Array]:
    """True attitudes, shape (N, 4), and derivatives of attitude and body rate by those of the start, shape (N, 3, 6).

    By central differences.
    """
    turns = list[Array]()
    rates = list[Array]()
    for off in np.eye(6) * STEP:
        before, after = (
            motion(quaternion.multiply(attitude_xyzw, quaternion.exp(step[:3])), body_rate + step[3:])
            for step in (-off, off)
        )
        turns.append(relative_rotations(before[0], after[0]))
        rates.append(after[1] - before[1])
    turn, rate = (np.stack(each, axis=2) / (2.0 * STEP) for each in (turns, rates))
    return motion(attitude_xyzw, body_rate)[0], turn, rate


def _bound(
    stamps_ns: Integers, truth_xyzw: Array, found: Sequence[Array], sensors: NoisySensors, readings: Array
) -> CramerRaoBound:
    """Bounds by the covariances of states before and after each update, and by all readings."""
    # where a sample's readings stand for some that come one by one until the next, a filter is between before and after
    share = (0.5 - 0.5 / readings)[:, np.newaxis, np.newaxis]
    predicted, updated, smoothed = found
    filtered = updated + share * (predicted - updated)
    bias = filtered[:, 3:6, 3:6] if any(sensors.gyro_bias) else np.zeros((len(stamps_ns), 3, 3))
    R = quaternion.to_matrix(truth_xyzw[-1])
    unobserved = _unobserved(R @ filtered[-1, :3, :3] @ R.T) if sensors.initial**2 > UNSEEN else ""
    return CramerRaoBound(filtered[:, :3, :3], smoothed[:, :3, :3], bias, stamps_ns, unobserved)


def _given(P: Array, constants: int) -> Array:
    """Covariances of states for an estimator that knows the constants, which are the last of the state."""
    n = P.shape[-1] - constants
    across = P[:, n:, :n]
    return P[:, :n, :n] - np.swapaxes(across, 1, 2) @ np.linalg.solve(P[:, n:, n:], across)


def _require_noise(name: str, relative: float) -> None:
    """Refuse a noise beside which the other numbers of the error state are lost in rounding, or that is beyond doubles.

    Raises
    ------
    InputError
    """
    if not MIN_NOISE <= relative <= MAX_NOISE:
        raise InputError(
            f"{name}: a noise of {relative:.3g} of what is read is beyond {MIN_NOISE:g} to {MAX_NOISE:g}: rounding "
            "would decide: change the noise or the vector"
        )


def _unobserved(world_covariance: Array) -> str:
    """Name of the directions of the world about which an error of half a radian or more would not be seen."""
    variances, axes = np.linalg.eigh(world_covariance)
    axis = axes[:, -1] * np.sign(axes[np.argmax(np.abs(axes[:, -1])), -1])
    one = f"a turn about {'the vertical' if axis[2] > 0.999 else f'({components(axis, 3)}) of the world'}"
    return ("", one, "the attitude", "the attitude")[np.count_nonzero(variances > UNSEEN)]


def _system(
    stamps: Integers, truth: Array, noisy: NoisySensors, readings: Array
) -> tuple[Array, Array, Array, Array, int]:
    """Transitions, covariances of noise and measurements of the error state, its first deviations, number of constants.

    A bias counts in units of its vector: the numbers are near those of angles, and rounding is small. Each linear error
    of each sensor is a constant: it adds to a turn, or to the readings of a vector.
    """
    vectors = noisy.vectors
    gyro = VectorReadings(
        stamps, np.array([1.0, 0.0, 0.0]), noisy.gyro_noise, noisy.gyro_bias, noisy.gyro_linear_errors
    )
    sensors = [gyro, *vectors]
    for number, sensor in enumerate(sensors):
        _require_noise("vector" if number else "gyro", sensor.noise / float(norm(sensor.vector)))
    count = len(stamps)
    begins = np.cumsum([3 + 3 * len(sensors), *(len(sensor.linear_errors) for sensor in sensors)]).tolist()
    constants = [slice(*part) for part in pairwise(begins)]
    n = begins[-1]
    F = np.tile(np.eye(n), (count, 1, 1))
    Q = np.zeros((count, n, n))
    H = np.zeros((count, max(1, len(vectors) + len(noisy.attitudes)), 3, n))  # without a sensor a reading of nothing
    deviations = [noisy.initial] * 3
    turn = np.concatenate([np.zeros((1, 3)), relative_rotations(truth[:-1], truth[1:])])
    jacobian = so3.right_jacobian(turn)
    pushed = (np.diff(stamps, prepend=stamps[0]) / 1e9)[:, np.newaxis, np.newaxis] * jacobian
    walk = readings * gyro.bias.step**2
    walk[0] = 0.0
    # a step of the bias adds to the turn of the same interval
    F[:, :3, :3] = so3.exp(-turn)
    F[:, :3, 3:6] = pushed
    F[:, :3, constants[0]] = jacobian @ np.einsum("cij,nj->nic", gyro.linear_errors, turn)
    into = np.concatenate([pushed, np.broadcast_to(np.eye(3), pushed.shape)], axis=1)
    Q[:, :6, :6] = np.einsum("n,nij,nkj->nik", walk, into, into)
    Q[:, :3, :3] += np.einsum("n,nij,nkj->nik", gyro.noise**2 / readings, pushed, pushed)
    for i, sensor in enumerate(vectors):
        unit = norm(sensor.vector)
        own = slice(6 + 3 * i, 9 + 3 * i)
        read = _count(stamps, sensor.stamps_ns)
        # as many readings of one vector are one of as much less noise
        weight = np.sqrt(read) * (unit / sensor.noise)
        body = weight[:, np.newaxis] * quaternion.rotate(quaternion.conjugate(truth), sensor.vector / unit)
        H[:, i, :, :3] = -so3.hat(body)
        H[:, i, :, own] = _diagonal(weight)
        H[:, i, :, constants[i + 1]] = np.einsum("cij,nj->nic", sensor.linear_errors, body)
        read[np.argmax(read > 0.0)] -= 1.0  # the bias begins at the first
        Q[:, own, own] = _diagonal((sensor.bias.step / unit) ** 2 * np.maximum(read, 0.0))
    for i, attitude in enumerate(noisy.attitudes, len(vectors)):
        factor = factor_of(attitude.covariance)
        _require_noise("attitude", np.linalg.svd(factor, compute_uv=False)[-1])
        H[:, i, :, :3] = np.sqrt(_count(stamps, attitude.stamps_ns))[:, np.newaxis, np.newaxis] * np.linalg.inv(factor)
    for sensor in sensors:
        # the smoother divides by what a bias that wanders begins with
        begin = max(sensor.bias.turn_on, 1e-6 * sensor.bias.step)
        deviations += [begin / float(norm(sensor.vector))] * 3
    first = np.array([*deviations, *[1.0] * (n - begins[0])])
    return F, Q, H.reshape(count, -1, n), first, n - begins[0]


def _determined(F: Array, Q: Array, H: Array, first: Array) -> tuple[Array, Array, Array, Array]:
    """A system without the states that are 0 for ever, whose first deviation is 0."""
    kept = np.flatnonzero(first)
    return F[:, kept][..., kept], Q[:, kept][..., kept], H[..., kept], first[kept]


def _count(stamps: Integers, readings_ns: Integers) -> Array:
    """Number of readings that count at each sample: those from it on until the next; none before the first."""
    at = np.searchsorted(stamps, readings_ns, side="right") - 1
    return np.bincount(at[at >= 0], minlength=len(stamps)).astype(np.float64)


def _diagonal(values: Array) -> Array:
    """Multiples of the identity, shape (N, 3, 3)."""
    return values[:, np.newaxis, np.newaxis] * np.eye(3)
