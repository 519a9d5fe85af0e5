"""Causes of errors that lie in what a filter gives, not in what it computes: the table, and the fit of their constants.

A cause is a transform of attitudes and their stamps, with constants or without. Undone with the right constants it
leaves no error. Estimates of several runs share the constants.

Most causes turn the quaternion as a vector of four numbers. The inverse, another order of the components and turns of
the world and of the body are orthogonal 4 × 4 matrices U. Of a cause with constants it is U = Σ cᵢ Bᵢ with |c| = 1.
With true attitudes q and estimates p the mean of cos² of half of the error is (1/N) Σ (qᵀ U p)² = uᵀ T u. Here u are
the 16 numbers of U, and T = (1/N) Σ (q ⊗ p)(q ⊗ p)ᵀ. One matrix of sums judges them all, and the best c is an
eigenvector.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.evaluation.attitudes import angle_and_axis, places, relative_rotations, times
from lie_rigid_body.evaluation.matched import Matched, MatchedRuns, error_of, products, valleys
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import components, program
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

UP: Final = np.array([0.0, 0.0, 1.0])
"""Vertical of the world, its z axis."""
IDENTITY: Final = np.array([0.0, 0.0, 0.0, 1.0])
"""Quaternion of no turn."""
NED: Final = np.sqrt([0.5, 0.5, 0.0, 0.0])
"""Quaternion of the rotation from our world, east, north, up, to north, east, down; its own inverse."""
MIN_COVERED: Final = 0.25
"""Smallest share of the samples that a constant of the stamps puts within the truth's times."""
CONVERGED: Final = 1e-4
"""Share of the errors by which a step changes them that ends a fit; chance in 4 000 samples changes them by 1.6e-2."""
FEIGNED: Final = f"a mistake in its readings does the same, which '{program('diagnose')}' tells"
"""Words for a cause that a mistake at the input of the filter may imitate."""
Words: TypeAlias = Callable[[Array], str]
"""Words about a cause, from its constants."""


@dataclass(frozen=True, eq=False)
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
        The repair in a few words, with the verb of what it leaves, from the constants.
    remedy : callable
        What to do about an estimate whose filter is not at hand, from the constants; empty where `fact` has it.
    unit : str
        Unit of the constants.
    maps : tuple of ndarray, shape (d, 4, 4) each
        Matrices of the repair, of several that there may be; of one with constants the base B. None of time.
    slopes : callable
        Derivative of the error, undone so far, by the constants, shape (N, 3, n), from the track, the truth and its
        body rate.
    moved : callable
        The constants after that.
    """

    code: str
    price: int
    undo: Callable[[Matched, Array], Matched]
    fits: Callable[[MatchedRuns], Sequence[Array]]
    fact: Words
    deed: Words
    maps: tuple[Array, ...] = ()
    slopes: Callable[[Matched, Array, Array], Array] = field(
        default=lambda track, truth, rate: np.zeros((len(truth), 3, 0)), repr=False
    )
    moved: Callable[[Array, Array], Array] = field(default=np.add, repr=False)
    remedy: Words = field(default=lambda constants: "", repr=False)
    unit: str = ""

    def fitted(self, tracks: MatchedRuns) -> tuple[Array, float]:
        """The best constants, and the RMS of the total error that they leave, rad."""
        few = [track.thinned() for track in tracks]
        best = min(self.fits(tracks), key=lambda constants: self.left(few, constants))
        return best, self.left(tracks, best)

    def left(self, tracks: MatchedRuns, constants: Array) -> float:
        """RMS of the total error of tracks without the cause, rad."""
        return error_of([self.undo(track, constants) for track in tracks])


Part = tuple[Cause, Array]
"""A cause with its constants."""
Parts = Sequence[Part]
"""Causes in the order in which they are undone."""


def undone(track: Matched, parts: Parts) -> Matched:
    """The track without some causes, in their order."""
    for cause, constants in parts:
        track = cause.undo(track, constants)
    return track


def by_maps(
    code: str,
    maps: Sequence[Array],
    fact: Words,
    deed: Words,
    remedy: Words = lambda constants: "",
) -> Cause:
    """A cause that is undone by one of several matrices, shape (4, 4); its constant is the number of the matrix."""
    return Cause(
        code,
        0,
        lambda track, chosen: replace(track, attitude_xyzw=track.attitude_xyzw @ maps[int(chosen[0])].T),
        lambda tracks: [np.array([float(number)]) for number in range(len(maps))],
        fact,
        deed,
        tuple(each[np.newaxis] for each in maps),
        remedy=remedy,
    )


def fit(tracks: MatchedRuns, parts: Parts, steps: int = 12) -> Parts:
    """Fit the constants of some causes together, from a start near them.

    Gauss and Newton's steps, with the weights of Geman and McClure: far errors, as while a filter converges, hardly
    count. What the motion does not tell apart stays where it was.
    """
    for _ in range(steps if any(cause.price for cause, _ in parts) else 0):
        normal = 0.0
        slope = 0.0
        left = 0.0
        for track in tracks:
            J, error, _ = derivative(track, parts)
            size = norm(error)
            weight = weights(size)
            weighted = J * weight[:, np.newaxis, np.newaxis]
            normal = normal + np.einsum("nia,nib->ab", weighted, J)
            slope = slope + np.einsum("nia,ni->a", weighted, error)
            left += float(np.sum(weight * size**2))
        step = np.clip(np.linalg.lstsq(np.atleast_2d(normal), np.atleast_1d(slope), rcond=1e-10)[0], -0.3, 0.3)
        ends = np.cumsum([0, *(cause.price for cause, _ in parts)])
        parts = [
            (cause, cause.moved(constants, step[begin:end]) if cause.price else constants)
            for (cause, constants), begin, end in zip(parts, ends[:-1], ends[1:], strict=True)
        ]
        if step @ normal @ step <= CONVERGED**2 * left + 1e-20:  # of a fit without an error
            break
    return list(parts)


def derivative(track: Matched, parts: Parts) -> tuple[Array, Array, Array]:
    """Derivative of the errors by the constants, (N, 3, n), errors on the body's axes, (N, 3), and true attitudes."""
    now = undone(track, parts)
    truth, rate = now.truth.states(now.stamps_ns)
    J = np.concatenate([cause.slopes(track, truth, rate) for cause, _ in parts], axis=-1)
    return J, relative_rotations(truth, now.attitude_xyzw), truth


def inflations(track: Matched, parts: Parts) -> list[float]:
    """Largest variance inflation factor of each cause's constants by fitting the others beside it; 1 without one.

    Where the body hardly moves, or turns about one axis, it is large: this motion does not tell the constants apart.
    """
    J = derivative(track, parts)[0]
    normal = np.einsum("nia,nib->ab", J, J)
    inverse = np.linalg.inv(normal + 1e-9 * np.trace(normal) * np.eye(len(normal)))
    ends = np.cumsum([cause.price for cause, _ in parts])
    own = [slice(end - cause.price, end) for (cause, _), end in zip(parts, ends, strict=True)]
    return [float(np.linalg.eigvals(normal[i, i] @ inverse[i, i]).real.max(initial=1.0)) for i in own]


def weights(norms: Array) -> Array:
    """Geman and McClure's weights, 1 / (1 + (r/s)²)², with a scale s of three medians."""
    scale = 3.0 * np.median(norms) if norms.size else 0.0
    return np.asarray(1.0 / (1.0 + (norms / scale) ** 2) ** 2 if scale else np.ones_like(norms))


def _left(turns_xyzw: Array) -> Array:
    """Matrices of the products with quaternions from the left: of shape (d, 4), matrices of shape (d, 4, 4)."""
    return np.swapaxes(quaternion.multiply(turns_xyzw[:, np.newaxis], np.eye(4)), 1, 2)


def _right(turns_xyzw: Array) -> Array:
    return np.swapaxes(quaternion.multiply(np.eye(4), turns_xyzw[:, np.newaxis]), 1, 2)


def _turned(track: Matched, left: Array = IDENTITY, right: Array = IDENTITY) -> Matched:
    return replace(track, attitude_xyzw=quaternion.multiply(quaternion.multiply(left, track.attitude_xyzw), right))


def _moved(track: Matched, lag_s: Array) -> Matched:
    return replace(track, stamps_ns=track.stamps_ns - np.int64(np.round(lag_s[0] * 1e9)))


def _by_clock(track: Matched, rate: Array) -> Matched:
    return replace(track, stamps_ns=track.origin + np.round(1e9 * track.since_s * rate[0]).astype(np.int64))


def _turn(maps: Array, constants: Callable[[Array], Array], tracks: MatchedRuns) -> Sequence[Array]:
    """Fit of the best turn of a kind, whose quaternion is an eigenvector."""
    each = [products(track, track.stamps_ns) @ maps.reshape(-1, 16).T for track in tracks]
    return [constants(np.linalg.eigh(sum(one.T @ one for one in each))[1][:, -1])]


def heading(c: Array) -> Array:
    """Heading, rad, shape (1,), of the numbers (w, z) of the turn that undoes it."""
    return np.array([np.remainder(np.pi - 2.0 * np.arctan2(c[1], c[0]), 2.0 * np.pi) - np.pi])


def vector(c: Array) -> Array:
    """Rotation vector, rad, of the numbers (w, x, y, z) of the turn that undoes it."""
    return -quaternion.log(np.roll(c, -1))


def _misses(track: Matched, undo: Callable[[Matched, Array], Matched], values: Array, covered: float) -> Array:
    """Mean squared half of the error, rad², that a constant of the stamps leaves, for each of some values.

    It is infinite where a smaller share of the samples than `covered` is within the truth's times.
    """
    stamps = np.stack([undo(track, np.array([value])).stamps_ns for value in values])
    known = track.truth.covers(stamps)
    truth = track.truth.at(np.clip(stamps, track.truth.first_ns, track.truth.last_ns))
    cosine = np.einsum("lni,ni->ln", truth, track.attitude_xyzw)
    squared = np.arccos(np.minimum(np.abs(cosine), 1.0)) ** 2
    misses = np.sum(squared, axis=1, where=known) / np.maximum(known.sum(axis=1), 1)
    return np.where(known.mean(axis=1) >= covered, misses, np.inf)


def fitted_in_time(
    cause: Cause, values: Array, tracks: MatchedRuns, starts: int = 1, covered: float = MIN_COVERED
) -> list[Array]:
    """A constant that changes stamps, in whose fit there are several valleys: fitted from the lowest of some values."""
    misses = np.asarray(sum(_misses(track.thinned(), cause.undo, values, covered) for track in tracks))
    few = [track.thinned(200) for track in tracks]
    return [_refined(cause, values[[k]], few) for k in valleys(misses)[:starts]]


def _refined(cause: Cause, found: Array, tracks: MatchedRuns) -> Array:
    """A constant that changes stamps, fitted from a start to the samples that it puts within the truth's times."""
    for _ in range(3):
        known = [track[track.truth.covers(cause.undo(track, found).stamps_ns)] for track in tracks]
        [(_, found)] = fit(known, [(cause, found)], steps=4)
    return found


def _lag(sign: float, tracks: MatchedRuns) -> Sequence[Array]:
    """A lag of that sign and of more than a sample, s; else 0."""
    [found] = fitted_in_time(BY_CODE["lagging"], _LAGS, tracks)
    steps = np.diff(tracks[0].stamps_ns)
    least = 1.001e-9 * np.median(steps) if len(steps) else np.inf  # no sample is later than the only one
    return [found if sign * found[0] > least else np.zeros(1)]


_INVERSE: Final = np.diag([-1.0, -1.0, -1.0, 1.0])
_SHIFT: Final = np.roll(np.eye(4), -1, axis=0)
_Z_UP: Final = _left(NED[np.newaxis])[0]
"""Exchange of x and y of the world, with z negated: half a turn about (1, 1, 0), its own inverse."""
_Z_UP_AND_FLU: Final = _Z_UP @ _right(np.eye(4)[:1])[0]
"""Exchange of the world beside half a turn about the body's x axis, its own inverse as well."""
_OF_WORLD: Final = _left(np.roll(np.eye(4), 1, axis=0))
_OF_BODY: Final = _right(np.roll(np.eye(4), 1, axis=0))
_ABOUT_UP: Final = _OF_WORLD[[0, 3]]
_LAGS: Final = np.linspace(-0.5, 0.5, 41)
"""Lags from which a fit begins, s."""
_RATES: Final = np.geomspace(0.5, 2.0, 141)
"""Rates of a clock from which a fit begins."""


CAUSES: Final = (
    by_maps(
        "inverted",
        (_INVERSE,),
        lambda c: (
            "The quaternion is the inverse, it takes world vectors to the body: publish its conjugate, -x -y -z w"
        ),
        lambda c: "Conjugated it leaves",
    ),
    by_maps(
        "scalar_first",
        (_SHIFT,),
        lambda c: "The quaternion comes scalar first, w x y z, where x y z w is read: move the first number to the end",
        lambda c: "With the scalar last it leaves",
    ),
    by_maps(
        "ned_world",
        (_Z_UP, _Z_UP_AND_FLU),
        lambda c: f"The world of the estimate is north-east-down{' and its body forward-right-down' if c[0] else ''}",
        lambda c: (
            f"With a world whose z is up{', and a body turned by half a turn about x' if c[0] else ''}, it leaves"
        ),
        remedy=lambda c: (
            f"multiply it on the left by (√½, √½, 0, 0){', and on the right by (1, 0, 0, 0)' if c[0] else ''}; "
            "if it should not be, see whether the sign of the accelerometer turns it upside down"
        ),
    ),
    Cause(
        "heading_offset",
        1,
        lambda track, angle: _turned(track, left=quaternion.exp(-angle[0] * UP)),
        partial(_turn, _ABOUT_UP, heading),
        lambda c: (
            f"The world of the estimate is turned by {np.degrees(c[0]):+.4g}° about the vertical: tell the filter its "
            "magnetic declination or what its x axis is"
        ),
        lambda c: f"Turned by {-np.degrees(c[0]):+.4g}° about the world's z axis the estimate leaves",
        (_ABOUT_UP,),
        lambda track, truth, rate: quaternion.rotate(quaternion.conjugate(truth), UP)[..., np.newaxis],
        remedy=lambda c: (
            f"turn the estimate by {-np.degrees(c[0]):+.6g}° about the world's z axis, or tell the filter its magnetic "
            f"declination or what its x axis is; hard iron and a bias of the gyro turn it too, and {FEIGNED}"
        ),
        unit="rad",
    ),
    Cause(
        "world_turned",
        3,
        lambda track, turn: _turned(track, left=quaternion.exp(-turn)),
        partial(_turn, _OF_WORLD, vector),
        lambda c: f"The world of the estimate is turned by {angle_and_axis(quaternion.exp(c))} of the world",
        lambda c: "Turned back about this axis the estimate leaves",
        (_OF_WORLD,),
        lambda track, truth, rate: np.swapaxes(quaternion.to_matrix(truth), 1, 2),
        lambda turn, step: quaternion.log(quaternion.multiply(quaternion.exp(turn), quaternion.exp(step))),
        lambda c: (
            "see whether nothing corrects a wrong first attitude, or the accelerometer, the magnetometer or what they "
            f"are held against has the wrong sign or other axes; {FEIGNED}"
        ),
        unit="rad",
    ),
    Cause(
        "lagging",
        1,
        _moved,
        partial(_lag, 1.0),
        lambda c: f"The estimate is late by {c[0]:.4g} s: stamp it with the time of the readings it is made of",
        lambda c: "With these stamps it leaves",
        slopes=lambda track, truth, rate: -rate[..., np.newaxis],
        remedy=lambda c: (
            "stamp it with the time of the readings it is made of, or correct the clock of the truth, where that is "
            "ahead of theirs"
        ),
        unit="s",
    ),
    Cause(
        "leading",
        1,
        _moved,
        partial(_lag, -1.0),
        lambda c: f"The estimate is ahead by {-c[0]:.4g} s: stamp it with the end of the last gyro step it contains",
        lambda c: "With these stamps it leaves",
        slopes=lambda track, truth, rate: -rate[..., np.newaxis],
        remedy=lambda c: (
            "correct the clock of the truth, where that is late, as by the delay of a motion capture system; or stamp "
            "the estimate with the end of the last gyro step it contains"
        ),
        unit="s",
    ),
    Cause(
        "clock_rate",
        1,
        _by_clock,
        lambda tracks: fitted_in_time(BY_CODE["clock_rate"], _RATES, tracks),
        lambda c: f"The clock of the estimate's stamps runs {times(1.0 / c[0], 5)} that of the readings",
        lambda c: "Stamped with the time of the readings it leaves",
        slopes=lambda track, truth, rate: (rate * track.since_s[:, np.newaxis])[..., np.newaxis],
        remedy=lambda c: (
            "stamp it with the time of the readings it is made of, in their unit and with their period, not by another "
            "clock beside a replay"
        ),
        unit="times the rate",
    ),
    Cause(
        "body_mounting",
        3,
        lambda track, turn: _turned(track, right=quaternion.exp(-turn)),
        partial(_turn, _OF_BODY, vector),
        lambda c: f"The body axes of the estimate are turned by {angle_and_axis(quaternion.exp(c))} of the body",
        lambda c: "Turned back about this axis the estimate leaves",
        (_OF_BODY,),
        lambda track, truth, rate: np.broadcast_to(np.eye(3), (len(truth), 3, 3)),
        lambda turn, step: quaternion.log(quaternion.multiply(quaternion.exp(step), quaternion.exp(turn))),
        lambda c: (
            "tell the filter how the sensor is mounted, or multiply the estimate on the right by "
            f"({components(quaternion.exp(-c), 6)}){places(quaternion.exp(c))}; biases of the sensors "
            f"turn them as well, and {FEIGNED}"
        ),
        unit="rad",
    ),
)
"""The causes, in the order in which they are named where several do as well and cost as much."""
BY_CODE: Final[dict[str, Cause]] = {cause.code: cause for cause in CAUSES}


def or_else(code: str, named: Collection[str], other: Collection[str]) -> str:
    """Code of another explanation that takes the place of one of the named codes while the rest stay; else empty."""
    rest = {*named} - {code}
    new = {*other} - rest
    return new.pop() if len(new) == 1 and code not in new and len(other) == len(rest) + 1 else ""


def late(lag_s: float) -> Part:
    """The cause of stamps that are late by a lag, s, or ahead where it is not above 0."""
    return BY_CODE["lagging" if lag_s > 0.0 else "leading"], np.array([lag_s])
