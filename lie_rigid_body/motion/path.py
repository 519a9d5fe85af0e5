"""A prescribed motion: a smooth spline through poses, whose rates and accelerations follow exactly.

The rotation from one knot to the next is exp(φ(t)) on the body's axes, with a cubic φ. The body rates at the knots are
those that make the angular acceleration continuous (SciPy's `RotationSpline`). The position is a cubic spline, whose
acceleration is continuous as well. No law of mechanics is asked for, so that nothing is conserved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.state import UNIT_NORM_TOLERANCE
from lie_rigid_body.motion.mass_centre import MassCentre
from lie_rigid_body.motion.motion import Samples, states_at

KNOT_NUMBERS: Final = 8
"""Numbers of a knot: its time, s, its position, m, and its attitude, scalar last."""
MIN_KNOTS: Final = 4
"""Smallest number of knots: a cubic spline needs as many."""
MAX_KNOTS: Final = 5000
"""Largest number of knots."""
MAX_STEP_DEG: Final = 170.0
"""Largest rotation from one knot to the next, degrees: of one near 180° nobody knows which way round it was."""
RISING: Final = "is not after the one before: give rising times"
"""Fault of a pose whose time does not rise."""


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
        rows = np.reshape(numbers, (-1, KNOT_NUMBERS))
        return cls(np.rint(rows[:, 0] * NS).astype(np.int64), rows[:, 1:4], rows[:, 4:])

    def numbers(self) -> list[float]:
        """The knots as numbers, `KNOT_NUMBERS` for each, from which `of` makes the same ones to the bit."""
        rows = np.column_stack([self.t_ns / NS, self.position, self.attitude_xyzw])
        return rows.ravel().tolist()

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
        mean_ns = np.rint(np.add.reduceat(self.t_ns, begins) / counts).astype(np.int64)
        position = np.add.reduceat(self.position, begins) / counts[:, np.newaxis]
        products = self.attitude_xyzw[:, :, np.newaxis] * self.attitude_xyzw[:, np.newaxis]
        attitude = np.linalg.eigh(np.add.reduceat(products, begins))[1][..., -1]
        before = np.concatenate([self.attitude_xyzw[:1], attitude[:-1]])
        signs = np.cumprod(np.copysign(1.0, np.einsum("ij,ij->i", attitude, before)))
        return Knots(mean_ns, position, attitude * signs[:, np.newaxis])


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

    Raises
    ------
    ParameterError
        If the knots are too few or too many, their times do not rise, or two that follow each other are nearly half a
        turn apart.
    """

    def __init__(self, knots: Knots) -> None:
        from scipy.interpolate import CubicSpline  # slow to import: not before there is a path
        from scipy.spatial.transform import Rotation, RotationSpline

        require_path(knots)
        self.knots = knots
        self.last_ns = int(knots.t_ns[-1])
        self._seconds = knots.t_ns / NS
        self._rotation = RotationSpline(self._seconds, Rotation.from_quat(knots.attitude_xyzw))
        self._position = CubicSpline(self._seconds, knots.position)
        # |ω| ≤ |φ̇|, as J_r lengthens no vector; φ̇ is quadratic, and in the hull of its Bézier points
        cubic, square, linear, _ = self._rotation.interpolator.c
        steps = np.diff(self._seconds)[:, np.newaxis]
        middle = linear + square * steps
        self.rate_bound = float(norm([linear, middle, middle + (square + 3.0 * cubic * steps) * steps]).max())

    def __len__(self) -> int:
        """Number of knots."""
        return len(self.knots.t_ns)

    def __deepcopy__(self, memo: object) -> PosePath:
        return self  # nothing of it changes

    def _inside(self, t_ns: Integers) -> tuple[Array, Array]:
        """The nearest times between the first knot and the last, s, and what is beyond them, s, shape (N, 1)."""
        inside = np.clip(t_ns, self.knots.t_ns[0], self.last_ns)
        return inside / NS, ((t_ns - inside) / NS)[:, np.newaxis]

    def _samples(self, t_ns: Integers) -> Samples:
        seconds, beyond = self._inside(t_ns)
        piece = np.searchsorted(self._seconds[1:-1], seconds, side="right")
        rate = self._rotation(seconds, 1)
        attitude = self.knots.attitude_xyzw[piece]
        # as products, and not as SciPy's rotations, quaternions keep the sign with which they go on
        for turn in (self._rotation.interpolator(seconds), beyond * rate):
            attitude = quaternion.multiply(attitude, quaternion.exp(turn))
        return quaternion.normalize(attitude), rate

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times, ns since the start; see `Motion.at`. Signs of quaternions are continuous."""
        return states_at(None, t_ns, self._samples)

    def angular_acceleration(self, t_ns: Integers) -> Array:
        """Angular acceleration in the body frame, rad/s², shape (N, 3), at N times, ns since the start."""
        seconds, beyond = self._inside(t_ns)
        return np.where(beyond == 0.0, self._rotation(seconds, 2), 0.0)

    def mass_centre(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        seconds, beyond = self._inside(t_ns)
        position, velocity, acceleration = (self._position(seconds, order) for order in range(3))
        return MassCentre(position + beyond * velocity, velocity, np.where(beyond == 0.0, acceleration, 0.0))

    def rms_acceleration(self) -> float:
        """Root mean square of the acceleration of the mass centre, m/s²."""
        times = np.arange(self.knots.t_ns[0], self.last_ns, 1 + self.last_ns // MAX_KNOTS // 20)
        return float(np.sqrt(np.mean(norm(self.mass_centre(times).acceleration) ** 2)))


@short_dataclass
class PathTranslation:
    """The motion of the mass centre along a path."""

    path: PosePath

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        return self.path.mass_centre(t_ns)


def require_path(knots: Knots) -> None:
    """Refuse knots through which there is no path.

    Raises
    ------
    ParameterError
    """
    t_ns, _, attitude = knots
    if not MIN_KNOTS <= len(t_ns) <= MAX_KNOTS:
        remedy = "more poses, or a shorter" if len(t_ns) < MIN_KNOTS else "fewer poses, or a longer"
        raise ParameterError(
            "path_knots", f"{len(t_ns)} knots are not {MIN_KNOTS} to {MAX_KNOTS}: give {remedy} path_interval"
        )
    before = np.concatenate([attitude[:1], attitude[:-1]])
    turns_deg = np.degrees(norm(quaternion.log(quaternion.multiply(quaternion.conjugate(before), attitude))))
    faults = {
        RISING: np.diff(t_ns, prepend=-1) <= 0,
        f"has a quaternion whose norm is not 1 to {UNIT_NORM_TOLERANCE:g}: give unit quaternions": (
            np.abs(quaternion.norm(attitude) - 1.0) > UNIT_NORM_TOLERANCE
        ),
        f"is turned by more than {MAX_STEP_DEG:g}° from the one before: give poses that follow each other faster, or a "
        "shorter path_interval": turns_deg > MAX_STEP_DEG,
    }
    refuse_first("path_knots", "knot", t_ns / NS, faults)


def refuse_first(name: str, noun: str, seconds: Array, faults: Mapping[str, Booleans]) -> None:
    """Refuse poses, naming the first one that has a fault, and its time, s.

    Raises
    ------
    ParameterError
    """
    for told, has_it in faults.items():
        if has_it.any():
            i = np.argmax(has_it)
            raise ParameterError(name, f"{noun} {i + 1}, at {seconds[i]:.15g} s, {told}")
