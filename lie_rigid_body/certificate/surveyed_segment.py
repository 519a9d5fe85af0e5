"""A segment of a bag, and what is found of the stamps of its poses and twists as they come."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.stamps import StampTally, stamp_law, stamp_result
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN, substeps_and_terms
from lie_rigid_body.recording.segments import number_samples, segment_parts
from lie_rigid_body.simulation import Segment


@dataclass(frozen=True)
class SurveyedSegment:
    """A segment and how complete it is.

    Parameters
    ----------
    segment : Segment
        The segment that the bag declares.
    count : int
        Samples that have both pose and twist.
    first : int or None
        Number of the first of them.
    last_ns : int or None
        Stamp of the last one.
    stamps : LawResult
        Whether the stamps of pose and twist are complete, even and in order.
    begins_late : bool
        Whether it may begin after the segment's start, as a recorder that subscribed to a running node does.
    unpaired : int
        Stamps between the first and the last sample that only one of the two topics has.
    longest_span : float
        Longest time between neighbours, s.
    followed_span : float
        The longest over which the flow is followed, s.
    """

    segment: Segment
    count: int
    first: int | None
    last_ns: int | None
    stamps: LawResult
    begins_late: bool
    unpaired: int
    longest_span: float = 0.0
    followed_span: float = 0.0

    @property
    def duration(self) -> float:
        """Time of the last sample since the segment's start, s."""
        return 0.0 if self.last_ns is None else (self.last_ns - self.segment.start_ns) * 1e-9

    @classmethod
    def whole(cls, segment: Segment, count: int) -> SurveyedSegment:
        """A segment that has its first samples, so many, and no other."""
        clock, first = segment.clock(), segment.first_sample
        span = (count > 1) * math.ceil(clock.period_ns) * 1e-9
        followed = span if span * segment.scenario.rate_bound() <= LONGEST_TURN else 0.0
        stamps = stamp_result("stamps", clock, [], 2 * count)
        last_ns = clock.stamp_ns(first + count - 1)
        return cls(
            segment,
            count,
            first,
            last_ns,
            stamps,
            begins_late=False,
            unpaired=0,
            longest_span=span,
            followed_span=followed,
        )

    def is_held_as(self, other: SurveyedSegment) -> bool:
        """Whether laws of its samples have the same limits, and follow their flow in the same steps, as of another."""
        return self.segment is other.segment and self.last_ns == other.last_ns and self._flow == other._flow

    @property
    def _flow(self) -> tuple[int, int]:
        return substeps_and_terms(self.segment.scenario.rate_bound() * self.followed_span)


class SegmentTally:
    """The stamps of a segment as they come.

    Parameters
    ----------
    segment : Segment

    Attributes
    ----------
    stamps : dict of str to StampTally
        Those of pose and twist.
    """

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        self.stamps = {topic: StampTally(segment.clock()) for topic in ("pose", "twist")}
        self._count = self._unpaired = self._alone_since = 0
        self._first_ns = self._last_ns = 0
        self._fastest = segment.scenario.rate_bound()
        self._longest = self._followed = 0.0

    @property
    def is_empty(self) -> bool:
        """Whether neither topic has a sample."""
        return not any(tally.count for tally in self.stamps.values())

    def pair(self, common: Integers, alone: Integers) -> None:
        """Take the stamps that come next, of both topics and of one alone."""
        if not len(common):
            self._alone_since += len(alone) if self._count else 0
            return
        self._span(np.diff(common, prepend=self._last_ns if self._count else common[0]) * 1e-9)
        if self._count:
            self._unpaired += self._alone_since + int(np.count_nonzero(alone < common[0]))
        else:
            self._first_ns = int(common[0])
        self._unpaired += int(np.count_nonzero((alone > common[0]) & (alone < common[-1])))
        self._alone_since = int(np.count_nonzero(alone > common[-1]))
        self._count += len(common)
        self._last_ns = int(common[-1])

    def _span(self, spans: Array) -> None:
        self._longest = max(self._longest, float(spans.max()))
        self._followed = max(self._followed, float(np.max(spans[spans * self._fastest <= LONGEST_TURN], initial=0.0)))

    def result(self, following: int | None, *, late_start: bool, open_end: bool, cut_off: bool) -> SurveyedSegment:
        """The segment, before one that starts at ``following``, ns."""
        segment, is_last = self.segment, following is None
        law = stamp_law(
            segment,
            following,
            self.stamps,
            late_start=late_start,
            open_end=open_end and is_last,
            cut_off=cut_off and is_last,
        )
        if not self._count:
            return SurveyedSegment(segment, 0, None, None, law, late_start, 0)
        first = int(number_samples(segment.clock(), np.array([self._first_ns]))[0])
        return SurveyedSegment(
            segment,
            self._count,
            first,
            self._last_ns,
            law,
            late_start,
            self._unpaired,
            self._longest,
            self._followed,
        )


def tally_pairs(tallies: list[SegmentTally], common: Integers, alone: Integers) -> None:
    """Give each segment its part of the stamps that come next, of both topics and of one alone."""
    segments = [tally.segment for tally in tallies]
    in_common, in_alone = dict(segment_parts(segments, common)), dict(segment_parts(segments, alone))
    for i in sorted(in_common.keys() | in_alone.keys()):
        none = slice(0, 0)
        tallies[i].pair(common[in_common.get(i, none)], alone[in_alone.get(i, none)])
