"""A bag cut at its resets into segments, with all their samples or so many as can be drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.pairing import Block
from lie_rigid_body.certificate.survey import numbered_blocks, survey
from lie_rigid_body.certificate.surveyed_segment import SurveyedSegment
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import short_repr

_ALL_OF: Final = 20_000
"""Samples that are drawn of a curve, from the first one on; a segment of no more is drawn as it is."""
_BUCKETS: Final = 2000
"""Pieces of a long bag of which the extreme samples are drawn: as many as a picture has columns."""
_CLOSE: Final = 0.05
"""Largest turn, rad, that a line may stand for."""


@dataclass(frozen=True)
class RecordedSegment:
    """The samples of one segment, as recorded.

    Parameters
    ----------
    segment : Segment
        The segment that the bag declares.
    samples : ndarray of int64, shape (N,)
        Numbers of the samples that have both pose and twist, rising.
    stamps_ns : ndarray of int64, shape (N,)
        Their stamps.
    states : State
        Their states, of shapes (N, 4) and (N, 3), not normalised.
    stamps : LawResult
        Whether the stamps of pose and twist are complete, even and in order.
    count : int
        How many samples the bag has of it: more than N where they were thinned.
    close : int
        How many of the N, from the first one on, follow each other so closely that a line between them is a curve.
    """

    segment: Segment
    samples: Integers
    stamps_ns: Integers
    states: State
    stamps: LawResult
    count: int
    close: int

    __repr__ = short_repr


def recorded_segments(bag: Bag | Recording, inertia: Sequence[float] | None = None) -> list[RecordedSegment]:
    """The segments of a bag with all their samples, in memory. See `survey`."""
    surveyed = survey(bag, inertia).segments
    blocks: list[list[Block]] = [[Block.empty()] for _ in surveyed]
    for i, block in numbered_blocks(bag, [found.segment for found in surveyed]):
        blocks[i].append(block)
    joined = [parts[0].joined(*parts[1:]) for parts in blocks]
    return [_recorded(found, whole, found.count) for found, whole in zip(surveyed, joined, strict=True)]


def thinned_segments(bag: Bag | Recording, inertia: Sequence[float] | None = None) -> list[RecordedSegment]:
    """The segments of a bag with so few of their samples that they can be drawn, and look as all would. See `survey`.

    Of many samples only those are kept that are extreme among their neighbours, in a component of body rate or world
    momentum or in energy: a curve through them has the envelope of all.
    """
    surveyed = survey(bag, inertia).segments
    size = -(-sum(found.count for found in surveyed) // _BUCKETS)
    thinning = [_Thinning(found, size) for found in surveyed]
    for i, block in numbered_blocks(bag, [found.segment for found in surveyed]):
        thinning[i].add(block)
    return [thinned.result() for thinned in thinning]


class _Thinning:
    """The samples of a segment as they come: of the first ones enough for a curve, of all the extreme ones."""

    def __init__(self, found: SurveyedSegment, size: int) -> None:
        scenario = found.segment.scenario
        turn = scenario.rate_bound() / scenario.rate
        self._found, self._size, self._body = found, size, scenario.body()
        self._stride = 1 if found.count <= _ALL_OF else max(1, int(min(_CLOSE, found.count * turn) / (turn or 1.0)))
        self._resolved = _ALL_OF * self._stride
        self._kept = [Block.empty()]
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
        """The segment with what was kept."""
        return _recorded(self._found, self._kept[0].joined(*self._kept[1:]), self._close)


def _recorded(found: SurveyedSegment, block: Block, close: int) -> RecordedSegment:
    return RecordedSegment(
        found.segment, block.samples, block.stamps_ns, block.states, found.stamps, found.count, close
    )


def seconds_since_start(segment: Segment, stamps_ns: Integers) -> Array:
    """Times since the segment's start, s."""
    return np.asarray((stamps_ns - segment.start_ns) * 1e-9, dtype=np.float64)
