"""A recorded motion as it is drawn: thinned to samples and residuals that look as all, and the geometry of pictures.

All pictures share times, resets, curves, and the ellipsoid of the energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.certificate.certification import Certificate
from lie_rigid_body.certificate.law_result import Watch
from lie_rigid_body.certificate.survey import survey
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.samples import Block, numbered_blocks
from lie_rigid_body.simulation import Segment

FEW_SAMPLES: Final = 3
"""Largest number of samples that a line alone would hardly show."""
MANY_SAMPLES: Final = 20_000
"""Number of samples above which the curves of a fast motion fill whole areas; points of a polhode."""
DOTS: Final[dict[str, Any]] = {"marker": "o", "ms": 4.0}
"""Look of few samples in a picture."""

MOST_RESETS: Final = 12
"""Largest number of resets that are drawn as lines through the curves."""
COLUMNS: Final = 1000
"""Number of intervals of time of a curve, each of which is drawn by its smallest and its largest value."""

_STEP: Final = 0.05
"""Turn from one point of a path to the next, rad, where the samples are as near."""
_FAR: Final = 1e3
"""Largest body rate that is drawn, as a multiple of the fastest of the motion: a larger one was damaged."""
_SEEN_POINTS: Final = 400
"""Number of points of the polhode by which a view is judged."""
_FROM_BELOW: Final = 0.8
"""Merit of a view from below, which is less usual, as a share of that from above."""

_ALL_OF: Final = 20_000
"""Number of samples that are drawn of a curve, from the first one on; a segment of no more is drawn as it is."""
_BUCKETS: Final = 2000
"""Number of pieces of a long bag of which the extreme samples are drawn: a picture has as many columns."""
_CLOSE: Final = 0.05
"""Largest turn, rad, that a line may stand for."""
RESIDUAL_INTERVALS: Final = 400
"""Most intervals of time of which the largest residual is kept."""


@short_dataclass(frozen=True)
class RecordedSegment(Block):
    """Samples of one segment, as recorded. See `Block` for the other parameters.

    Parameters
    ----------
    segment : Segment
        As the bag declares it.
    count : int
        Number of samples that the bag has of it: more than N where they were thinned.
    close : int
        Number of samples, from the first one on, that follow each other so closely that a line between them is a curve.
    """

    segment: Segment
    count: int
    close: int


def thinned_segments(bag: Bag | Recording, certificate: Certificate | None = None) -> list[RecordedSegment]:
    """Segments of a bag with so few of their samples that they can be drawn, and look as all would.

    Of many samples only those are kept that are extreme among their neighbours, in a component of body rate or world
    momentum or in energy. A curve through them has the envelope of all.

    Parameters
    ----------
    bag : Bag or Recording
    certificate : Certificate, optional
        Of the bag, with at least one segment; without it the bag is read once more to find its segments.

    Raises
    ------
    BagError, ParameterError
        See `survey`.
    """
    found = (
        [(each.segment, each.count) for each in survey(bag).segments]
        if certificate is None
        else [(each.segment, each.samples) for each in certificate.segments]
    )
    size = -(-sum(count for _, count in found) // _BUCKETS)
    thinning = [_Thinning(segment, count, size) for segment, count in found]
    for i, block in numbered_blocks(bag, [segment for segment, _ in found]):
        thinning[i].add(block)
    return [each.result() for each in thinning]


class _Thinning:
    """Samples of a segment as they come: of the first ones enough for a curve, of all the extreme ones."""

    def __init__(self, segment: Segment, count: int, size: int) -> None:
        scenario = segment.scenario
        turn = scenario.rate_bound() / scenario.rate
        self._segment, self._count, self._size, self._body = segment, count, size, scenario.body()
        self._stride = 1 if count <= _ALL_OF else max(1, int(min(_CLOSE, count * turn) / (turn or 1.0)))
        self._resolved = _ALL_OF * self._stride
        self._kept: list[Block] = []
        self._taken = self._close = 0

    def add(self, block: Block) -> None:
        """Take the samples that come next."""
        for i in range(0, len(block.samples), self._size):
            bucket = block[i : i + self._size]
            places = self._taken + np.arange(len(bucket.samples))
            of_curve = np.flatnonzero((places % self._stride == 0) & (places < self._resolved))
            chosen = np.union1d(self._extreme(bucket), of_curve)
            self._close += int(np.count_nonzero(places[chosen] < self._resolved))
            self._kept.append(bucket[chosen])
            self._taken += len(places)

    def _extreme(self, bucket: Block) -> Integers:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # recorded numbers may be anything
            energy = self._body.kinetic_energy(bucket.states)
            momentum = self._body.angular_momentum(bucket.states)
        columns = np.column_stack([bucket.states.body_rate, energy, momentum])
        return np.unique([columns.argmin(axis=0), columns.argmax(axis=0)])

    def result(self) -> RecordedSegment:
        """Return the segment with what was kept."""
        kept = Block.joined(self._kept)
        return RecordedSegment(**vars(kept), segment=self._segment, count=self._count, close=self._close)


class ResidualsOverTime(Watch):
    """The largest residual of each law in each interval of time; a `Watch` for `certify`."""

    def __init__(self) -> None:
        self.laws: dict[str, LawOverTime] = {}

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next."""
        if len(stamps_ns):
            self.laws.setdefault(name, LawOverTime(unit, int(stamps_ns[0]))).add(residuals, limits, stamps_ns)


class LawOverTime:
    """The largest residual and the largest limit of one law in each of `RESIDUAL_INTERVALS` equal intervals at most.

    An interval is twice as long as before when the time that all cover is over.

    Parameters
    ----------
    unit : str
    start_ns : int
        Stamp at which the first interval begins.
    """

    def __init__(self, unit: str, start_ns: int) -> None:
        self.unit, self._start_ns, self._length_ns = unit, start_ns, 1
        # residuals, limits, and 1 where a residual is beyond its limit
        self._largest = np.full((3, RESIDUAL_INTERVALS), -np.inf)

    def add(self, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take residuals, not negative, NaN for broken; those before the first interval count as its own."""
        while (int(stamps_ns.max()) - self._start_ns) // self._length_ns >= RESIDUAL_INTERVALS:
            self._double()
        at = np.maximum(0, (stamps_ns - self._start_ns) // self._length_ns)
        weights = np.where(np.isnan(residuals), np.inf, residuals)
        of_each = np.stack(np.broadcast_arrays(weights, limits, ~(residuals <= limits)))
        for largest, new in zip(self._largest, of_each, strict=True):
            np.maximum.at(largest, at, new)

    def _double(self) -> None:
        self._length_ns *= 2
        half = self._largest.reshape(3, -1, 2).max(axis=2)
        self._largest = np.hstack([half, np.full_like(half, -np.inf)])

    def series(self, origin_ns: int) -> tuple[Array, Array, Array, Booleans]:
        """Middles of the intervals that have a residual, s since a stamp, residuals, limits, and which are broken."""
        found = np.flatnonzero(self._largest[0] >= 0.0)
        middles = np.asarray((self._start_ns - origin_ns + (found + 0.5) * self._length_ns) * 1e-9, dtype=np.float64)
        residuals, limits, broken = self._largest[:, found]
        return middles, residuals, limits, broken > 0.0


def times(stamps_ns: Integers, pieces: Sequence[RecordedSegment]) -> Array:
    """Times since the first sample of a recording, s."""
    return np.asarray((stamps_ns - pieces[0].stamps_ns[0]) * 1e-9, dtype=np.float64)


def reset_times(pieces: Sequence[RecordedSegment]) -> Array:
    """Times of the resets since the first sample of a recording, s."""
    return times(np.array([piece.segment.start_ns for piece in pieces[1:]], dtype=np.int64), pieces)


def extremes(t: Array, values: Array, columns: int = COLUMNS) -> Integers:
    """Places of the smallest and the largest value in each of some intervals of time; all places where there are few.

    Parameters
    ----------
    t, values : ndarray, shape (N,)
        Rising times, and finite values.
    columns : int, optional
        Number of the intervals, all of one length.

    Returns
    -------
    ndarray of int64, shape (M,)
        Rising; at most two for each interval.
    """
    if len(t) <= 2 * columns:
        return np.arange(len(t))
    column = ((t - t[0]) * (columns / (t[-1] - t[0]))).astype(np.int64)
    order = np.lexsort((values, column))
    first = np.flatnonzero(np.diff(column[order], prepend=-1))
    return np.union1d(order[first], order[np.append(first[1:], len(t)) - 1])


def curve_style(count: int, width: float) -> dict[str, Any]:
    """Style of the curves of so many samples in a picture: few as dots, many so that no curve hides the others."""
    if count <= FEW_SAMPLES:
        return {**DOTS, "lw": width}
    return {"lw": 0.5 * width, "alpha": 0.6} if count > MANY_SAMPLES else {"lw": width}


@np.errstate(invalid="ignore", over="ignore")  # recorded numbers may be anything
def usable(piece: RecordedSegment, places: Integers | slice) -> tuple[State, Booleans]:
    """States at some places of a segment, of unit quaternions, and which places have one that can be drawn.

    Left out are attitudes that are zero or not finite, and rates far beyond those of the motion.
    """
    attitude, rate = piece.states.attitude_xyzw[places], piece.states.body_rate[places]
    norms, largest = np.linalg.norm(attitude, axis=1), np.abs(rate).max(axis=1)
    sane = np.isfinite(norms) & (norms > 0.0) & (largest <= _FAR * piece.segment.scenario.rate_bound())
    return State.trusted(attitude[sane] / norms[sane, np.newaxis], rate[sane]), np.asarray(sane)


def path(piece: RecordedSegment, most: int) -> State:
    """States of the first part of a segment that a path is drawn through, at most so many, as dense as it needs."""
    scenario, last = piece.segment.scenario, min(piece.close, len(piece.stamps_ns)) - 1
    turn = scenario.rate_bound() * float(piece.stamps_ns[last] - piece.stamps_ns[0]) * 1e-9 / max(last, 1)
    step = max(1, int(_STEP / turn)) if turn > 0.0 else 1
    states, _ = usable(piece, slice(0, piece.close, step))
    return states[:most]


View: TypeAlias = tuple[float, float]
"""Direction from which something is seen in space: elevation and azimuth, degrees."""


def screen(view: View) -> tuple[Array, Array, Array]:
    """Unit vectors towards the eye, to the right and up."""
    e, a = np.radians(view)
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return eye, right, np.cross(eye, right)


VIEWS: Final = tuple(
    (elevation, quarter + azimuth)
    for elevation in (24.0, 45.0, -24.0)
    for quarter in (0.0, 90.0, 180.0, 270.0)
    for azimuth in (35.0, 20.0, 55.0, 70.0)
)
"""Views that a polhode may be seen from: off the axes, so that all three are seen."""


@short_dataclass(frozen=True)
class Ellipsoid:
    """Ellipsoid ½ Σ Iᵢωᵢ² = H of the kinetic energy, on which the body rate runs in the principal frame.

    Parameters
    ----------
    radii : ndarray, shape (3,)
        Semi-axes √(2H/Iᵢ), rad/s.
    polhode : ndarray, shape (N, 3)
        Recorded body rates on the principal axes, rad/s.
    """

    radii: Array
    polhode: Array

    @classmethod
    def of(cls, piece: RecordedSegment, most: int) -> Ellipsoid | None:
        """Ellipsoid and polhode of the first part of a segment, of so many points at most; none of a body at rest."""
        body = piece.segment.scenario.body()
        energy = float(body.kinetic_energy(piece.segment.scenario.start()))
        rates = path(piece, most).body_rate
        if energy == 0.0 or not len(rates):
            return None
        return cls(np.sqrt(2.0 * energy / body.principal_moments), rates @ body.principal_axes)

    def surface(self, scale: float = 1.0) -> Array:
        """Points of the surface, or of one within it, on a grid of parallels and meridians, shape (3, 31, 61)."""
        u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 61), np.linspace(0, np.pi, 31))
        sphere = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
        return np.asarray(scale * self.radii[:, np.newaxis, np.newaxis] * sphere)

    def principal_circles(self) -> Array:
        """Sections with the three principal planes, shape (3, 181, 3)."""
        angle = np.linspace(0, 2 * np.pi, 181)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.asarray(self.radii * np.stack([np.insert(ring, plane, 0.0, axis=-1) for plane in range(3)]))

    def faces(self, points: Array, view: View) -> Booleans:
        """Whether the surface at each of its points, shape (N, 3), faces the eye."""
        return np.asarray((points / self.radii**2) @ screen(view)[0] >= 0.0)

    def best_view(self) -> View:
        """View from which most of the polhode is in front, and widest."""
        points = self.polhode[:: len(self.polhode) // _SEEN_POINTS + 1]

        def merit(view: View) -> tuple[float, float]:
            in_front = float(np.mean(self.faces(points, view)))
            seen = (points / self.radii.max()) @ np.stack(screen(view)[1:], axis=-1)
            # the lesser of the two widths of the curve on the screen: 0 if it is seen as a chord
            width = float(np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)[-1]) / len(seen) ** 0.5
            usual = 1.0 if view[0] > 0.0 else _FROM_BELOW
            return round(usual * in_front * width, 9), usual * in_front

        return max(VIEWS, key=merit)
