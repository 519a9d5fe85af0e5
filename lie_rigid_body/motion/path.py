"""A prescribed motion: a smooth spline through poses, whose rates and accelerations follow exactly.

The rotation from one knot to the next is exp(φ(t)) on the body's axes, with a cubic φ. The body rates at the knots are
those that make the angular acceleration continuous (SciPy's `RotationSpline`). The position is a cubic spline, whose
acceleration is continuous as well. No law of mechanics is asked for, so that nothing is conserved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.state import UNIT_NORM_TOLERANCE
from lie_rigid_body.motion.motion import states_at
from lie_rigid_body.motion.translation import MassCentre

KNOT_NUMBERS: Final = 8
"""Numbers of a knot: its time, s, its position, m, and its attitude, scalar last."""
MIN_KNOTS: Final = 4
"""Smallest number of knots: a cubic spline needs as many."""
MAX_KNOTS: Final = 5000
"""Largest number of knots."""
MAX_STEP_DEG: Final = 170.0
"""Largest rotation from one knot to the next, degrees: of one near 180° nobody knows which way round it was."""
MAX_PATH_S: Final = 1e6
"""Largest time of a knot, s: up to it the shortest decimal of a double tells each nanosecond."""


class Knots(NamedTuple):
    """Poses that a path goes through.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (K,)
        Times since the first pose, ns.
    position : ndarray, shape (K, 3)
        Of the mass centre in the world frame, m.
    attitude_xyzw : ndarray, shape (K, 4)
        World-from-body, unit, scalar last.
    """

    t_ns: Integers
    position: Array
    attitude_xyzw: Array

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Knots:
        """The knots of `KNOT_NUMBERS` each, as `numbers` gives them."""
        rows = np.array(numbers, dtype=np.float64).reshape(-1, KNOT_NUMBERS)
        return cls(np.rint(rows[:, 0] * NS).astype(np.int64), rows[:, 1:4].copy(), rows[:, 4:].copy())

    def numbers(self) -> list[float]:
        """The knots as numbers, `KNOT_NUMBERS` for each, from which `of` makes the same ones to the bit."""
        rows = np.column_stack([self.t_ns / NS, self.position, self.attitude_xyzw])
        return [float(number) for number in rows.ravel()]

    def averaged(self, interval_ns: int) -> Knots:
        """Knots of poses averaged over intervals, with signs that go on continuously.

        A knot is made of a pose and those that follow within less than the interval. It has their mean time, rounded
        to ns, and their mean position. Its attitude is the mean of their rotations in the chordal distance: R. Hartley
        and others, International Journal of Computer Vision 103 (2013), section 5.

        Parameters
        ----------
        interval_ns : int
            ns; 0: each pose is a knot.
        """
        begins = _begins(self.t_ns, interval_ns)
        counts = np.diff(begins, append=len(self.t_ns))
        mean_ns = np.add.reduceat(self.t_ns, begins) / counts
        position = np.add.reduceat(self.position, begins) / counts[:, np.newaxis]
        products = self.attitude_xyzw[:, :, np.newaxis] * self.attitude_xyzw[:, np.newaxis, :]
        mean = np.linalg.eigh(np.add.reduceat(products, begins))[1][:, :, -1]
        attitude = np.where(counts[:, np.newaxis] == 1, self.attitude_xyzw[begins], mean)
        signs = np.where(np.einsum("ij,ij->i", attitude[1:], attitude[:-1]) < 0.0, -1.0, 1.0)
        return Knots(np.rint(mean_ns).astype(np.int64), position, attitude * np.cumprod([1.0, *signs])[:, np.newaxis])


def _begins(t_ns: Integers, interval_ns: int) -> Integers:
    """Index of the first pose of each knot."""
    begins = [0]
    while (following := int(np.searchsorted(t_ns, t_ns[begins[-1]] + max(interval_ns, 1)))) < len(t_ns):
        begins.append(following)
    return np.array(begins)


class PosePath:
    """The motion through poses, from time 0 on. Before the first one, and after the last, its rates are constant.

    Parameters
    ----------
    knots : Knots

    Attributes
    ----------
    knots : Knots
    last_ns : int
        Time of the last knot, ns since the start.
    rate_bound : float
        Bound of the body rate, rad/s.
    rms_acceleration : float
        Root mean square of the acceleration of the mass centre, m/s².

    Raises
    ------
    ParameterError
        If the knots are too few or too many, their times do not rise, or two that follow each other are nearly half a
        turn apart.
    """

    def __init__(self, knots: Knots) -> None:
        _require_path(knots)
        self.knots = knots
        self.last_ns = int(knots.t_ns[-1])
        self._seconds = knots.t_ns / NS
        rotations = scipy.spatial.transform.Rotation.from_quat(knots.attitude_xyzw)
        self._rotation = scipy.spatial.transform.RotationSpline(self._seconds, rotations)
        self._position = scipy.interpolate.CubicSpline(self._seconds, knots.position)
        self._attitude = quaternion.normalize(knots.attitude_xyzw)
        self._set_pieces()
        attitude, rate = self._samples(np.zeros(1, dtype=np.int64))
        self._start = State.trusted(attitude[0], rate[0])
        acceleration = self._position(self._seconds, 2)
        # |a|² is integrated exactly, as a is linear between two knots
        before, after = acceleration[:-1], acceleration[1:]
        squares = np.sum(before * before + before * after + after * after, axis=1) / 3.0
        self.rms_acceleration = float(np.sqrt(np.average(squares, weights=np.diff(self._seconds))))

    def __len__(self) -> int:
        """Number of knots."""
        return len(self.knots.t_ns)

    def __deepcopy__(self, memo: object) -> PosePath:
        return self  # nothing of it changes

    def _set_pieces(self) -> None:
        """Coefficients of φ(t) = ((a τ + b) τ + c) τ, τ = t − t_k, of each piece, shape (K − 1, 3) each, and the bound.

        A cubic is known by its ends and its rates there. Those of φ follow from the body rates: eq. (11), solved.
        """
        dt = (np.diff(self.knots.t_ns) / NS)[:, np.newaxis]
        rates = self._rotation(self._seconds, 1)
        turn = quaternion.log(_steps(self._attitude))
        begin = rates[:-1]
        end = (so3.right_jacobian_inverse(turn) @ rates[1:, :, np.newaxis])[..., 0]
        self._cubic = (begin + end - 2.0 * turn / dt) / dt**2
        self._square = (3.0 * turn / dt - 2.0 * begin - end) / dt
        self._linear = begin
        # |ω| ≤ |φ̇|, as J_r lengthens no vector, and φ̇ is within the hull of its three Bézier points
        hull = np.stack([begin, 3.0 * turn / dt - begin - end, end])
        self.rate_bound = float(norm(hull).max())

    def _inside(self, t_ns: Integers) -> tuple[Integers, Array]:
        """The nearest times between the first knot and the last, ns, and what is beyond them, s, shape (N, 1)."""
        inside = np.clip(t_ns, self.knots.t_ns[0], self.last_ns)
        return inside, ((t_ns - inside) / NS)[:, np.newaxis]

    def _samples(self, t_ns: Integers) -> tuple[Array, Array]:
        inside, beyond = self._inside(t_ns)
        piece = np.clip(np.searchsorted(self.knots.t_ns, inside, side="right") - 1, 0, len(self._linear) - 1)
        tau = ((inside - self.knots.t_ns[piece]) / NS)[:, np.newaxis]
        cubic, square, linear = self._cubic[piece], self._square[piece], self._linear[piece]
        phi = ((cubic * tau + square) * tau + linear) * tau
        phi_dot = (3.0 * cubic * tau + 2.0 * square) * tau + linear
        rate = (so3.right_jacobian(phi) @ phi_dot[..., np.newaxis])[..., 0]
        attitude = quaternion.multiply(self._attitude[piece], quaternion.exp(phi))
        return quaternion.normalize(quaternion.multiply(attitude, quaternion.exp(beyond * rate))), rate

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times, ns since the start; see `Motion.at`. Signs of quaternions are continuous."""
        return states_at(self._start, t_ns, self._samples)

    def angular_acceleration(self, t_ns: Integers) -> Array:
        """Angular acceleration in the body frame, rad/s², shape (N, 3), at N times, ns since the start."""
        inside, beyond = self._inside(t_ns)
        return np.where(beyond == 0.0, self._rotation(inside / NS, 2), 0.0)

    def mass_centre(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        inside, beyond = self._inside(t_ns)
        position, velocity, acceleration = (self._position(inside / NS, order) for order in range(3))
        return MassCentre(position + beyond * velocity, velocity, np.where(beyond == 0.0, acceleration, 0.0))


@dataclass(frozen=True)
class PathTranslation:
    """The motion of the mass centre along a path."""

    path: PosePath

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        return self.path.mass_centre(t_ns)


def _require_path(knots: Knots) -> None:
    """Refuse knots through which there is no path."""
    t_ns = knots.t_ns
    if not MIN_KNOTS <= len(t_ns) <= MAX_KNOTS:
        remedy = "more poses, or a shorter" if len(t_ns) < MIN_KNOTS else "fewer poses, or a longer"
        raise _refusal(f"{len(t_ns)} knots are not {MIN_KNOTS} to {MAX_KNOTS}: give {remedy} path_interval")
    if t_ns[0] < 0 or t_ns[-1] > MAX_PATH_S * NS:
        at = t_ns[0] if t_ns[0] < 0 else t_ns[-1]
        raise _refusal(f"a knot is at {at / NS:.15g} s, outside of 0 to {MAX_PATH_S:g} s: give a shorter path")
    if (np.diff(t_ns) <= 0).any():
        i = int(np.argmax(np.diff(t_ns) <= 0))
        told = f"knot {i + 2} is at {t_ns[i + 1] / NS:.15g} s, which is not after the one before"
        raise _refusal(f"{told}, {t_ns[i] / NS:.15g} s: give rising times")
    lengths = quaternion.norm(knots.attitude_xyzw)
    if (np.abs(lengths - 1.0) > UNIT_NORM_TOLERANCE).any():
        i = int(np.argmax(np.abs(lengths - 1.0)))
        raise _refusal(
            f"the quaternion of knot {i + 1} has the norm {lengths[i]:.6g}, which is not 1 to {UNIT_NORM_TOLERANCE:g}: "
            "give unit quaternions"
        )
    turns = norm(quaternion.log(_steps(knots.attitude_xyzw)))
    if (np.degrees(turns) > MAX_STEP_DEG).any():
        i = int(np.argmax(turns))
        raise _refusal(
            f"from knot {i + 1} to knot {i + 2} the body turns by {np.degrees(turns[i]):.4g}°, more than "
            f"{MAX_STEP_DEG:g}°: give poses that follow each other faster, or a shorter path_interval"
        )


def _steps(attitude_xyzw: Array) -> Array:
    """Rotations from each attitude to the next, on the axes of the body."""
    return quaternion.multiply(quaternion.conjugate(attitude_xyzw[:-1]), attitude_xyzw[1:])


def _refusal(message: str) -> ParameterError:
    return ParameterError("path_knots", message)
