"""A recording thinned to what is drawn of it: samples of its segments, and residuals of its laws over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.certificate.certification import Certificate
from lie_rigid_body.certificate.law_result import Watch
from lie_rigid_body.certificate.survey import survey
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.samples import Block, numbered_blocks
from lie_rigid_body.simulation import Segment

_ALL_OF: Final = 20_000
"""Number of samples that are drawn of a curve, from the first one on; a segment of no more is drawn as it is."""
_BUCKETS: Final = 2000
"""Number of pieces of a long bag of which the extreme samples are drawn: a picture has as many columns."""
_CLOSE: Final = 0.05
"""Largest turn, rad, that a line may stand for."""
INTERVALS: Final = 400
"""Most intervals of time of which the largest residual is kept."""


@dataclass(frozen=True)
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
        kept = vars(Block.joined(self._kept))
        return RecordedSegment(**kept, segment=self._segment, count=self._count, close=self._close)


class ResidualsOverTime(Watch):
    """The largest residual of each law in each interval of time; a `Watch` for `certify`."""

    def __init__(self) -> None:
        self.laws: dict[str, LawOverTime] = {}

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next."""
        if len(stamps_ns):
            self.laws.setdefault(name, LawOverTime(unit, int(stamps_ns[0]))).add(residuals, limits, stamps_ns)


class LawOverTime:
    """The largest residual and the largest limit of one law in each of `INTERVALS` equal intervals of time at most.

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
        self._largest = np.full((3, INTERVALS), -np.inf)

    def add(self, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take residuals, not negative, NaN for broken; those before the first interval count as its own."""
        while (int(stamps_ns.max()) - self._start_ns) // self._length_ns >= INTERVALS:
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
