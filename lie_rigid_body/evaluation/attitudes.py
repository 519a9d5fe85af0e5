"""Attitudes beside each other, and the true attitude at any time: exact, as a function of time, or from samples.

The definition of the error is that of the BROAD benchmark (D. Laidig, M. Caruso, A. Cereatti, T. Seel: BROAD—A
Benchmark for Robust Inertial Orientation Estimation, Data 6(7):72, 2021). With world-from-body quaternions and the
world's z axis up, the error in the world frame is q_e = q_estimate ⊗ q_truth⁻¹ = (x, y, z, w), and

    total       = 2 arccos |w|
    heading     = 2 arctan |z / w|
    inclination = 2 arccos √(w² + z²).

So q_e is a turn about the vertical by the heading after a tilt about a horizontal axis by the inclination, and
cos(total/2) = cos(heading/2) cos(inclination/2). An arccos loses half of the digits near 0, so the angles are computed
by arctan2 of the same sides; they differ from the definition by round-off only.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable
from copy import copy
from itertools import permutations, product
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import MAX_STAMP_NS, as_stamps, integer_stamps, numbers, read_series, unit
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_repr
from lie_rigid_body.foundation.wording import components, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

QUATERNION_ROUND_OFF: Final = 2e-15
"""Round-off of the components of a product of unit quaternions: smaller z and w tell no heading, as their ratio is
arbitrary."""
SAME_AXES_DEG: Final = 5.0
"""Largest angle, degrees, from a mounting to axes that are swapped or negated, up to which it is told as such."""

SIGNED_PERMUTATIONS: Final = np.array(
    [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
)
"""Matrices that permute and reverse axes, the first of which is the identity: shape (48, 3, 3)."""

GAP_PERIODS: Final = 2.5
"""Least distance of neighbouring stamps that is a gap, in median periods: two samples or more are missing."""
DIFFERENCE_NS: Final = 100_000
"""Half of the time between the attitudes of the central difference, ns."""


class AttitudeError(NamedTuple):
    """Error angles of attitude estimates, all from 0 to π.

    Attributes
    ----------
    total : ndarray, shape (...)
        Angle of the rotation that takes the true attitude to the estimate, rad.
    heading : ndarray, shape (...)
        Its part about the world's vertical, rad. An inclination error of π has no heading error; within
        `QUATERNION_ROUND_OFF` of it 0 is given.
    inclination : ndarray, shape (...)
        Its part about a horizontal axis, rad: the angle between the true and the estimated vertical.
    """

    total: Array
    heading: Array
    inclination: Array

    def __eq__(self, other: object) -> bool:
        return self is other  # of arrays Python would ask for one answer

    def __ne__(self, other: object) -> bool:
        return self is not other

    def __hash__(self) -> int:
        return id(self)

    def __repr__(self) -> str:
        return short_repr(self)


def attitude_error(estimate_xyzw: ArrayLike, truth_xyzw: ArrayLike) -> AttitudeError:
    """Total, heading and inclination error of attitude estimates.

    Parameters
    ----------
    estimate_xyzw, truth_xyzw : array_like, shape (N, 4) or (..., 4)
        World-from-body quaternions of the same instants, scalar last, world z up. Norm and sign are ignored; a norm
        below 1e-12 counts as zero. Leading axes broadcast.

    Returns
    -------
    AttitudeError

    Raises
    ------
    InputError
        If the shapes do not go together, a number is not finite, or a quaternion is zero.
    """
    estimate = unit("estimate_xyzw", estimate_xyzw)
    truth = unit("truth_xyzw", truth_xyzw)
    try:
        return angles(quaternion.multiply(estimate, quaternion.conjugate(truth)))
    except ValueError:
        raise InputError(
            f"estimate_xyzw of shape {estimate.shape} does not go with truth_xyzw of shape {truth.shape}: "
            "give both at the same instants, one row each"
        ) from None


def angles(error_xyzw: Array) -> AttitudeError:
    """Error angles of an error quaternion in the world frame, shape (..., 4)."""
    # of each component its own array: arctan2 of a strided one, on NumPy 1.26 with AVX-512, has other last bits where
    # its result happens to lie behind it in memory
    x, y, z, w = np.ascontiguousarray(np.moveaxis(np.abs(error_xyzw), -1, 0))
    tilt = np.hypot(x, y)
    turn = np.hypot(z, w)
    heading = 2.0 * np.arctan2(np.where(turn > QUATERNION_ROUND_OFF, z, 0.0), w)
    return AttitudeError(2.0 * np.arctan2(np.hypot(tilt, z), w), heading, 2.0 * np.arctan2(tilt, turn))


def error_vectors(estimate_xyzw: Array, truth_xyzw: Array, axes: str = "world") -> Array:
    """Rotation vectors of errors, shape (..., 3), rad, about the axes of the world or of the body.

    They are log(q_estimate ⊗ q_truth⁻¹) and log(q_truth⁻¹ ⊗ q_estimate).
    """
    back = quaternion.conjugate(truth_xyzw)
    factors = (estimate_xyzw, back) if axes == "world" else (back, estimate_xyzw)
    return quaternion.log(quaternion.multiply(*factors))


def relative_rotations(start_xyzw: Array, end_xyzw: Array) -> Array:
    """Rotation vectors from some attitudes to others on the body's axes, log(q_start⁻¹ ⊗ q_end), (..., 3), rad."""
    return error_vectors(end_xyzw, start_xyzw, "body")


def angles_between(start_xyzw: Array, end_xyzw: Array) -> Array:
    """Angles of the turns from some attitudes to others, shape (...), rad."""
    return norm(relative_rotations(start_xyzw, end_xyzw))


def geodesic(start_xyzw: Array, end_xyzw: Array, fraction: Array) -> Array:
    """Attitude at a fraction of the shortest turn from one attitude to another, shape (..., 4)."""
    return quaternion.multiply(
        start_xyzw, quaternion.exp(relative_rotations(start_xyzw, end_xyzw) * np.asarray(fraction)[..., np.newaxis])
    )


def times(ratio: float, digits: int = 3) -> str:
    """Ratio of two rates in words, ``2 times as fast as``."""
    return f"{max(ratio, 1.0 / ratio):.{digits}g} times as {'fast' if ratio > 1.0 else 'slow'} as"


def named(axes: Array) -> str:
    """Rows of a matrix of axes that change places and signs, as ``y, -x, z``."""
    return ", ".join(f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in axes)


def places(mounting: Array) -> str:
    """Body axes of an estimate named by those of the body, where they only change places and signs; else empty."""
    axes = quaternion.rotate(mounting, np.eye(3))  # row by row, on the axes of the body
    nearest = np.round(axes)
    left = math.degrees(np.arccos(np.clip((np.sum(axes * nearest) - 1.0) / 2.0, -1.0, 1.0)))
    name = named(nearest)
    if left > SAME_AXES_DEG or name == "x, y, z" or np.abs(nearest).sum() != 3.0:
        return ""
    meaning = ", forward-right-down where the truth's are forward-left-up" if name == "x, -y, -z" else ""
    return f"; its x, y, z are {name} of the body{meaning}" + (f", but for {left:.2g}°" if left >= 0.01 else "")


def angle_and_axis(rotation: Array) -> str:
    """Angle and axis of a rotation, shape (4,), in words."""
    turn = quaternion.log(rotation)
    angle = float(norm(turn))
    return f"{np.degrees(angle):.4g}° about ({components(turn / angle if angle else turn, 3)})"


def period_ns(stamps_ns: Integers) -> int:
    """Median time between stamps, ns; 0 for a single one."""
    return int(np.median(np.diff(stamps_ns))) if len(stamps_ns) > 1 else 0


def in_order(stamps_ns: Integers, after_ns: int | None = None) -> Booleans:
    """Mask of the stamps, ns, that are no earlier than any that stands before them, and than `after_ns`."""
    before = stamps_ns[:1] if after_ns is None else np.array([after_ns])
    return stamps_ns >= np.maximum.accumulate(np.concatenate([before, stamps_ns]))[:-1]


def rising(stamps_ns: Integers) -> Booleans:
    """Mask of as many stamps as possible that never decrease, without a first or a last one that leaps far away.

    A wrong stamp so costs itself, wherever it leaps to. An end leaps far away if it is farther from its neighbour than
    all others from each other.
    """
    chosen = longest_rising(stamps_ns)
    mask = np.zeros(len(stamps_ns), dtype=np.bool_)
    mask[chosen] = True
    for end, rest in ((chosen[:1], chosen[1:]), (chosen[-1:], chosen[:-1])):
        if len(rest) > 2 and np.ptp(stamps_ns[chosen]) > 2 * np.ptp(stamps_ns[rest]):
            others = np.delete(np.arange(len(stamps_ns)), end)
            mask[end] = False
            mask[others] = rising(stamps_ns[others])
            break
    return mask


def longest_rising(stamps_ns: Integers) -> Integers:
    """Indices of a longest subsequence of stamps that never decreases.

    It is found by patience sorting (Fredman, Discrete Mathematics 11:29, 1975).
    """
    if in_order(stamps_ns).all():
        return np.arange(len(stamps_ns))
    ends: list[int] = []  # smallest last stamp of the rising sequences of each length
    places: list[int] = []  # index of that stamp
    before: list[int] = []
    for i, stamp in enumerate(stamps_ns.tolist()):
        length = bisect_right(ends, stamp)
        before.append(places[length - 1] if length else -1)
        ends[length : length + 1] = [stamp]
        places[length : length + 1] = [i]
    chosen = [places[-1]]
    while before[chosen[-1]] >= 0:
        chosen.append(before[chosen[-1]])
    return np.array(chosen[::-1])


T = TypeVar("T", bound="Truth")


class Truth(ABC):
    """True attitude as a function of time.

    Attributes
    ----------
    first_ns, last_ns : int
        The times between which it is known.
    """

    first_ns: int
    last_ns: int

    def __repr__(self) -> str:
        return f"<{type(self).__name__} from {self.first_ns} to {self.last_ns} ns>"

    @abstractmethod
    def at(self, stamps_ns: Integers) -> Array:
        """Unit quaternions world-from-body, scalar last, shape (..., 4), at stamps of any shape within its times."""

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Bound of the error of the truth itself at some stamps, rad, by interpolation; 0 if it is exact."""
        return 0.0

    def covers(self, stamps_ns: Integers) -> Booleans:
        """Whether the truth is known at each stamp."""
        stamps = as_stamps("truth", stamps_ns)
        return (stamps >= self.first_ns) & (stamps <= self.last_ns)

    def between(self: T, first_ns: int, last_ns: int) -> T:
        """Truth that is asked of only from one stamp to another, ns."""
        part = copy(self)
        part.first_ns = first_ns
        part.last_ns = last_ns
        return part

    def smooth_around(self, stamps_ns: Integers) -> tuple[Integers, Integers]:
        """First and last time, ns, of the smooth motion that each stamp belongs to."""
        return np.full_like(stamps_ns, self.first_ns), np.full_like(stamps_ns, self.last_ns)

    def periods_ns(self, stamps_ns: Integers) -> Array:
        """Usual time from each of N rising stamps to the next, ns, shape (N - 1,): rates may change at a reset.

        It is the median of those that begin in the same smooth motion.
        """
        begins, _ = self.smooth_around(stamps_ns[:-1])
        parts = np.split(np.diff(stamps_ns), np.flatnonzero(np.diff(begins)) + 1)
        return np.concatenate([np.full(len(part), np.median(part)) for part in parts if len(part)] or [np.empty(0)])

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitude, shape (..., 4), and body rate, rad/s, shape (..., 3), by a central difference over 0.2 ms.

        Stamps outside of the truth's times, which a fit of a lag may try, have the state of the first or the last time.
        """
        stamps = np.clip(as_stamps("truth", stamps_ns), self.first_ns, self.last_ns)
        begin, end = self.smooth_around(stamps)
        before = np.maximum(stamps - DIFFERENCE_NS, begin)
        after = np.minimum(stamps + DIFFERENCE_NS, end)
        earlier, now, later = self.at(np.stack([before, stamps, after]))
        return now, relative_rotations(earlier, later) / (np.maximum(after - before, 1) * 1e-9)[..., np.newaxis]


class ExactTruth(Truth):
    """A motion that is known at every instant.

    Parameters
    ----------
    attitude_xyzw : callable
        Takes stamps in ns, shape (N,), rising, and gives quaternions, array_like of shape (N, 4).
    first_ns, last_ns : int
        The times between which it may be asked.

    Raises
    ------
    InputError
        If it ends before it begins, or a time is none that a message can have.
    """

    def __init__(self, attitude_xyzw: Callable[[Integers], Array], first_ns: int, last_ns: int) -> None:
        self.first_ns = _time(first_ns)
        self.last_ns = _time(last_ns)
        if last_ns < first_ns:
            raise InputError(f"truth: it ends at {last_ns} ns, before its begin at {first_ns} ns: exchange them")
        self._attitude = attitude_xyzw

    def at(self, stamps_ns: Integers) -> Array:
        """Values of the function, asked once and in order of time."""
        stamps, place = np.unique(integer_stamps("truth", stamps_ns), return_inverse=True)
        if not len(stamps):
            return np.empty((*np.shape(stamps_ns), 4))
        attitude = numbers("truth", self._attitude(stamps), len(stamps), 4, whole=True)
        return np.asarray(attitude[place.reshape(np.shape(stamps_ns))])


class SampledTruth(Truth):
    """Samples of the true attitude, on the geodesic from one to the next (slerp) between their stamps.

    At a sample's own stamp it is that sample to the bit. Between samples h apart the geodesic misses the motion by at
    most |ω̇| h²/8. `uncertainty` measures this: each sample is left out and interpolated from its two neighbours, 2h
    apart, and misses them by four times as much. Nothing is interpolated across a gap.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (N,)
        Increasing.
    attitude_xyzw : array_like, shape (N, 4)
        World-from-body, scalar last.
    longest_gap_ns : int, optional
        Neighbours farther apart are not joined. By default 2.5 times the median period.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        The samples' own.

    Raises
    ------
    InputError
        If stamps are not increasing, or a quaternion is not finite or zero.
    """

    def __init__(self, stamps_ns: ArrayLike, attitude_xyzw: ArrayLike, longest_gap_ns: int | None = None) -> None:
        stamps, attitude = read_series("truth", stamps_ns, attitude_xyzw)
        if np.any(np.diff(stamps) == 0):
            raise InputError("truth: a stamp occurs twice: leave one of the two samples out")
        self._longest_gap = GAP_PERIODS * period_ns(stamps) if longest_gap_ns is None else _time(longest_gap_ns)
        self.first_ns = int(stamps[0])
        self.last_ns = int(stamps[-1])
        self.stamps_ns = stamps
        if len(stamps) == 1:  # an interval, within whose ends the truth is not asked for
            stamps = stamps + np.arange(2)
            attitude = np.repeat(attitude, 2, axis=0)
        self._stamps = stamps
        self._attitude = attitude
        around = stamps[2:] - stamps[:-2]
        middle = geodesic(attitude[:-2], attitude[2:], (stamps[1:-1] - stamps[:-2]) / around)
        misses = angles_between(middle, attitude[1:-1])[around <= 2 * self._longest_gap]
        self.uncertainty = float(misses.max(initial=0.0)) / 4.0

    def covers(self, stamps_ns: Integers) -> Booleans:
        """Whether a stamp is a sample's own, or between two that are joined."""
        stamps = as_stamps("truth", stamps_ns)
        i = self._interval(stamps)
        joined = self._stamps[i + 1] - self._stamps[i] <= self._longest_gap
        return super().covers(stamps) & (joined | np.isin(stamps, self._stamps))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Bound `uncertainty`, or 0 if every stamp is a sample's own."""
        return 0.0 if np.isin(as_stamps("truth", stamps_ns), self._stamps).all() else self.uncertainty

    def at(self, stamps_ns: Integers) -> Array:
        """Attitudes at the samples, and on the geodesics between them."""
        stamps = as_stamps("truth", stamps_ns)
        i = self._interval(stamps)
        fraction = (stamps - self._stamps[i]) / (self._stamps[i + 1] - self._stamps[i])
        between = geodesic(self._attitude[i], self._attitude[i + 1], fraction)
        return np.where((fraction == 1.0)[..., np.newaxis], self._attitude[i + 1], between)

    def _interval(self, stamps_ns: Integers) -> Integers:
        return np.clip(np.searchsorted(self._stamps, stamps_ns, side="right") - 1, 0, len(self._stamps) - 2)


def _time(value: Any) -> int:
    is_near = isinstance(value, int | float | np.integer) and -MAX_STAMP_NS <= value <= MAX_STAMP_NS
    if not is_near or value != int(value):
        raise InputError(f"truth: the time {shown(value)} is no whole number within 2**31 s of 0, as in ROS 2: give ns")
    return int(value)
