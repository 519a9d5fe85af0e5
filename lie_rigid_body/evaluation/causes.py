"""Causes of errors that lie in what a filter gives, not in what it computes: the table, and the fit of their constants.

A cause is a transform of attitudes and their stamps, with constants or without. Undone with the right constants it
leaves no error. Estimates of several runs share the constants.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Final, Literal, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.alignment import ENU_TO_NED, FLU_TO_FRD, UP
from lie_rigid_body.evaluation.attitude_error import angles
from lie_rigid_body.evaluation.attitudes import angles_between, mean, turns
from lie_rigid_body.evaluation.findings import angle_and_axis
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.truth import Truth
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

LONGEST_LAG: Final = 0.5
"""Largest lag that is looked for, s."""
LARGEST_CLOCK_RATE: Final = 2.0
"""Largest rate of a clock that is looked for, and the inverse of the smallest."""
_SCANNED: Final = 40
"""Samples of a track at which starts of a fit are compared."""
_STEPS: Final = 12
"""Largest number of steps of Gauss and Newton."""


@dataclass(frozen=True, eq=False)
class Track:
    """Attitudes that were estimated, beside the truth.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Stamps, ns.
    attitude_xyzw : ndarray, shape (N, 4)
        World-from-body, scalar last, of unit norm.
    truth : Truth
        The true attitude at any stamp.
    origin_ns : int, optional
        Stamp at which a clock of another rate was right, ns; by default the first of the whole track.
    """

    stamps_ns: Integers
    attitude_xyzw: Array
    truth: Truth
    origin_ns: int | None = None

    __repr__ = short_repr

    def part(self, chosen: slice | Integers) -> Track:
        """Some of the samples."""
        stamps, attitude = self.stamps_ns[chosen], self.attitude_xyzw[chosen]
        return replace(self, stamps_ns=stamps, attitude_xyzw=attitude, origin_ns=self.origin)

    @property
    def origin(self) -> int:
        """Stamp at which a clock of another rate was right, ns."""
        return int(self.stamps_ns[0]) if self.origin_ns is None else self.origin_ns

    def few(self, most: int = _SCANNED) -> Track:
        """About so many of the samples, evenly chosen."""
        return self.part(slice(None, None, max(1, len(self.stamps_ns) // most)))

    def errors(self) -> Array:
        """Total error of each sample, shape (N,), rad."""
        truth = self.truth.at(self.stamps_ns)
        return angles(quaternion.multiply(self.attitude_xyzw, quaternion.conjugate(truth))).total

    def partial_errors(self) -> tuple[float, float]:
        """RMS of the error of the vertical, and of that of the turns over a tenth of the samples, rad."""
        truth = self.truth.at(self.stamps_ns)
        tilt = angles(quaternion.multiply(self.attitude_xyzw, quaternion.conjugate(truth))).inclination
        step = max(1, len(truth) // 10)
        wrong, right = (turns(q[:-step], q[step:]) for q in (self.attitude_xyzw, truth))
        return rms(tilt), rms(angles_between(quaternion.exp(wrong), quaternion.exp(right)))


Tracks = Sequence[Track]


@dataclass(frozen=True)
class Cause:
    """One cause.

    Attributes
    ----------
    code : str
        Name in results.
    price : int
        Number of constants that are fitted.
    undo : callable
        The track without the cause, from the track and the constants.
    fits : callable
        Constants that may be right, from tracks which share them; at least one.
    fact : callable
        What is wrong with the estimate, a sentence without a full stop, from the constants.
    deed : callable
        The repair in a few words, as a part of speech before "leaves", from the constants.
    """

    code: str
    price: int
    undo: Callable[[Track, Array], Track]
    fits: Callable[[Tracks], Sequence[Array]]
    fact: Callable[[Array], str]
    deed: Callable[[Array], str]

    def fitted(self, tracks: Tracks) -> tuple[Array, float]:
        """The best constants, and the RMS of the total error that they leave, rad."""
        found = self.fits(tracks)
        if len(found) > 1:
            found = [min(found, key=lambda constants: self.left([track.few() for track in tracks], constants))]
        return found[0], self.left(tracks, found[0])

    def left(self, tracks: Tracks, constants: Array) -> float:
        """RMS of the total error of tracks without the cause, rad."""
        return error_of([self.undo(track, constants) for track in tracks])


def error_of(tracks: Tracks) -> float:
    """RMS of the total error over all samples of tracks, rad."""
    return rms(np.concatenate([track.errors() for track in tracks]))


def _turned(track: Track, left: Array | None = None, right: Array | None = None) -> Track:
    q = track.attitude_xyzw
    q = q if left is None else quaternion.multiply(left, q)
    return replace(track, attitude_xyzw=q if right is None else quaternion.multiply(q, right))


def _conjugated(track: Track, constants: Array) -> Track:
    return replace(track, attitude_xyzw=quaternion.conjugate(track.attitude_xyzw))


def _scalar_last(track: Track, constants: Array) -> Track:
    return replace(track, attitude_xyzw=np.roll(track.attitude_xyzw, -1, axis=-1))


def _z_up(track: Track, frd_body: Array) -> Track:
    return _turned(track, ENU_TO_NED, FLU_TO_FRD if frd_body[0] else None)


def _reordered(track: Track, orders: Array) -> Track:
    """The attitude of the same three angles in another order of axes."""
    wrong, right = (_ORDERS[int(order)] for order in orders)
    given = Rotation.from_quat(track.attitude_xyzw).as_euler(wrong)
    sorted_angles = given[:, [wrong.index(axis) for axis in right]]
    return replace(track, attitude_xyzw=Rotation.from_euler(right, sorted_angles).as_quat())


def _heading_undone(track: Track, heading: Array) -> Track:
    return _turned(track, left=quaternion.exp(-heading[0] * UP))


def _world_undone(track: Track, vector: Array) -> Track:
    return _turned(track, left=quaternion.exp(-vector))


def _mounting_undone(track: Track, vector: Array) -> Track:
    return _turned(track, right=quaternion.exp(-vector))


def _moved(track: Track, lag_s: Array) -> Track:
    return replace(track, stamps_ns=track.stamps_ns - np.int64(np.round(lag_s[0] * 1e9)))


def _by_clock(track: Track, rate: Array) -> Track:
    since = np.round((track.stamps_ns - track.origin) * rate[0]).astype(np.int64)
    return replace(track, stamps_ns=track.origin + since)


def _fixed(*values: float) -> Callable[[Tracks], Sequence[Array]]:
    found = [np.array([value]) for value in values]
    return lambda tracks: found


def _world_errors(tracks: Tracks) -> Array:
    """Error quaternions on the axes of the world, shape (N, 4)."""
    pairs = [(track.attitude_xyzw, track.truth.at(track.stamps_ns)) for track in tracks]
    return np.concatenate([quaternion.multiply(q, quaternion.conjugate(truth)) for q, truth in pairs])


def _heading(tracks: Tracks) -> Sequence[Array]:
    """The turn about the vertical that is nearest to the errors: an eigenvector as in `attitudes.mean`, of z and w."""
    zw = _world_errors(tracks)[:, 2:]
    z, w = np.linalg.eigh(zw.T @ zw)[1][:, -1]
    return [np.array([2.0 * np.arctan2(z, w)])]


def _world(tracks: Tracks) -> Sequence[Array]:
    return [quaternion.log(mean(_world_errors(tracks)))]


def _mounting(tracks: Tracks) -> Sequence[Array]:
    pairs = [(track.attitude_xyzw, track.truth.at(track.stamps_ns)) for track in tracks]
    return [quaternion.log(mean(np.concatenate([quaternion.multiply(quaternion.conjugate(t), q) for q, t in pairs])))]


def _best_of_scan(tracks: Tracks, undo: Callable[[Track, Array], Track], values: Array) -> float:
    """The value that leaves the least, of a constant in whose fit there are several valleys."""
    few = [track.few() for track in tracks]
    left = np.zeros(len(values))
    for track in few:
        stamps = np.stack([undo(track, np.array([value])).stamps_ns for value in values])
        truth = track.truth.at(stamps)
        left += np.sum(angles(quaternion.multiply(track.attitude_xyzw, quaternion.conjugate(truth))).total ** 2, axis=1)
    return float(values[np.argmin(left)])


def _by_time(
    tracks: Tracks,
    undo: Callable[[Track, Array], Track],
    start: float,
    slopes: Callable[[Track], Array],
) -> Array:
    """Gauss and Newton's fit of a constant that changes stamps; `slopes` is the change of each stamp with it, s."""
    value, few = start, [track.few(200) for track in tracks]
    for _ in range(_STEPS):
        normal = slope = 0.0
        for track in few:
            truth, rate = track.truth.states(undo(track, np.array([value])).stamps_ns)
            J = rate * slopes(track)[:, np.newaxis]
            normal += float(np.sum(J * J))
            slope += float(np.sum(J * turns(truth, track.attitude_xyzw)))
        step = slope / normal if normal else 0.0
        value += float(np.clip(step, -0.1, 0.1))
        if abs(step) < 1e-10:
            break
    return np.array([value])


def _lag(tracks: Tracks) -> Sequence[Array]:
    start = _best_of_scan(tracks, _moved, np.linspace(-LONGEST_LAG, LONGEST_LAG, 41))
    return [_by_time(tracks, _moved, start, lambda track: -np.ones(len(track.stamps_ns)))]


def _lag_of(sign: float) -> Callable[[Tracks], Sequence[Array]]:
    """The lag, where it has a sign and is more than one sample; else none."""

    def fits(tracks: Tracks) -> Sequence[Array]:
        period_s = float(np.median(np.diff(tracks[0].stamps_ns))) / 1e9
        lag_s = float(_lag(tracks)[0][0])
        return [np.array([lag_s if sign * lag_s > 1.001 * period_s else 0.0])]

    return fits


def _clock_rate(tracks: Tracks) -> Sequence[Array]:
    rates = np.geomspace(1.0 / LARGEST_CLOCK_RATE, LARGEST_CLOCK_RATE, 141)
    start = _best_of_scan(tracks, _by_clock, rates)
    return [_by_time(tracks, _by_clock, start, lambda track: (track.stamps_ns - track.origin) / 1e9)]


def _euler(tracks: Tracks) -> Sequence[Array]:
    """Every two orders of axes that differ."""
    return [np.array(pair, dtype=np.float64) for pair in permutations(range(len(_ORDERS)), 2)]


Order = Literal["ZYX", "XYZ", "YXZ", "ZXY", "XZY", "YZX"]
_ORDERS: Final[tuple[Order, ...]] = get_args(Order)
"""Orders of turns about axes of the body, the usual one first."""
_NONE: Final = _fixed(0.0)


def _said(text: str) -> Callable[[Array], str]:
    return lambda constants: text


CAUSES: Final = (
    Cause(
        "inverted",
        0,
        _conjugated,
        _NONE,
        _said("The quaternion is the inverse, it takes world vectors to the body: publish its conjugate, -x -y -z w"),
        _said("Conjugated it"),
    ),
    Cause(
        "scalar_first",
        0,
        _scalar_last,
        _NONE,
        _said("The quaternion comes scalar first, w x y z, where x y z w is read: move the first number to the end"),
        _said("With the scalar last it"),
    ),
    Cause(
        "ned_world",
        0,
        _z_up,
        _fixed(0.0, 1.0),
        lambda c: f"The world of the estimate is north-east-down{' and its body forward-right-down' if c[0] else ''}",
        lambda c: f"Turned to z up from the left{', and half a turn about x from the right' if c[0] else ''}, it",
    ),
    Cause(
        "euler_order",
        0,
        _reordered,
        _euler,
        lambda c: f"The three Euler angles are put together in the order {_order(c[0])} instead of {_order(c[1])}",
        lambda c: f"Put together as {_order(c[1])} they",
    ),
    Cause(
        "heading_offset",
        1,
        _heading_undone,
        _heading,
        lambda c: (
            f"The world of the estimate is turned by {np.degrees(c[0]):+.4g}° about the vertical: tell the filter its "
            "magnetic declination or what its x axis is"
        ),
        lambda c: f"Turned by {-np.degrees(c[0]):+.4g}° from the left the estimate",
    ),
    Cause(
        "world_turned",
        3,
        _world_undone,
        _world,
        lambda c: f"The world of the estimate is turned by {angle_and_axis(quaternion.exp(c))} of the world",
        _said("Turned back from the left the estimate"),
    ),
    Cause(
        "lagging",
        1,
        _moved,
        _lag_of(1.0),
        lambda c: f"The estimate is late by {c[0]:.4g} s: stamp it with the time of the readings it is made of",
        _said("With these stamps it"),
    ),
    Cause(
        "leading",
        1,
        _moved,
        _lag_of(-1.0),
        lambda c: f"The estimate is ahead by {-c[0]:.4g} s: stamp it with the end of the last gyro step it contains",
        _said("With these stamps it"),
    ),
    Cause(
        "clock_rate",
        1,
        _by_clock,
        _clock_rate,
        lambda c: f"The clock of the estimate's stamps runs {1.0 / c[0]:.5g} times as fast as that of the readings",
        _said("Stamped with the time of the readings it"),
    ),
    Cause(
        "body_mounting",
        3,
        _mounting_undone,
        _mounting,
        lambda c: f"The body axes of the estimate are turned by {angle_and_axis(quaternion.exp(c))} of the body",
        _said("Turned back from the right the estimate"),
    ),
)
"""The causes, in the order in which they are named where several do as well and cost as much."""


def _order(number: float) -> str:
    return " ".join(_ORDERS[int(number)].lower())
