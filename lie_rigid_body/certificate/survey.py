"""Survey of a bag: its segments, their samples, and how complete they are, found while the messages pass."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.stamps import StampTally, stamp_law
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.bag_reader import AnyBag
from lie_rigid_body.recording.samples import Batches, Block, numbered, paired, require_samples
from lie_rigid_body.recording.segments import (
    declared_segments,
    number_samples,
    segment_parts,
    segments_with_samples,
)
from lie_rigid_body.recording.topic_messages import TakeReadings
from lie_rigid_body.simulation import Segment


@short_dataclass
class SurveyedSegment:
    """A segment and how complete it is.

    Parameters
    ----------
    place : int
        Its place among the segments that the bag declares.
    segment : Segment
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
    """

    place: int
    segment: Segment
    count: int
    first: int | None
    last_ns: int | None
    stamps: LawResult
    begins_late: bool


class SegmentTally:
    """The stamps of a segment as they come.

    Parameters
    ----------
    place : int
        Place of the segment among those that the bag declares.
    segment : Segment

    Attributes
    ----------
    stamps : dict of str to StampTally
        Those of pose and twist.
    """

    def __init__(self, place: int, segment: Segment) -> None:
        self._place = place
        self.segment = segment
        self.stamps = {topic: StampTally(segment.clock()) for topic in ("pose", "twist")}
        self._count = 0
        self._first: int | None = None
        self._last_ns: int | None = None

    @property
    def is_empty(self) -> bool:
        """Whether neither topic has a sample."""
        return not any(tally.count for tally in self.stamps.values())

    def pair(self, stamps_ns: Integers) -> None:
        """Take the next stamps that both topics have."""
        if self._first is None:
            self._first = int(number_samples(self.segment.clock(), stamps_ns[:1])[0])
        self._count += len(stamps_ns)
        self._last_ns = int(stamps_ns[-1])

    def result(self, following: int | None, *, late_start: bool, open_end: bool, cut_off: bool) -> SurveyedSegment:
        """The segment, before one that starts at ``following``, ns."""
        segment = self.segment
        is_last = following is None
        law = stamp_law(
            segment,
            following,
            self.stamps,
            late_start=late_start,
            open_end=open_end and is_last,
            cut_off=cut_off and is_last,
        )
        return SurveyedSegment(self._place, segment, self._count, self._first, self._last_ns, law, late_start)


class Counts:
    """Counts of all poses and twists, made as they pass.

    Attributes
    ----------
    messages : list of int
        Poses and twists.
    foreign_frames : set of str
        Frames that poses and twists name, and that the scenario of their segment does not.
    log_time_mismatches : int
        Messages that were not logged at their stamps, scenarios at their starts.
    first_ns : int
        The least stamp, ns.
    """

    def __init__(self) -> None:
        self.messages = [0, 0]
        self.foreign_frames = set[str]()
        self.log_time_mismatches = 0
        self.first_ns = int(np.iinfo(np.int64).max)

    def counted(self, batches: Batches, *, stamped: bool) -> Batches:
        """Give the batches on, and count what is in them."""
        for poses, twists in batches:
            for i, topic in enumerate((poses, twists)):
                self.messages[i] += len(topic)
                if i == 0 or stamped:
                    self.first_ns = int(topic.stamps_ns.min(initial=self.first_ns))
                self.log_time_mismatches += int(np.count_nonzero(topic.log_times_ns != topic.stamps_ns))
            yield poses, twists


@short_dataclass
class Survey:
    """Result of a first pass through a bag.

    Parameters
    ----------
    segments : tuple of SurveyedSegment
        Segments without a sample, which a reset followed at once, are left out.
    declared : tuple of Segment
        All that the bag declares, in the order of their starts.
    is_original : bool
        See `BagFacts.is_original`.
    counts : Counts
    """

    segments: tuple[SurveyedSegment, ...]
    declared: tuple[Segment, ...]
    is_original: bool
    counts: Counts


def survey(bag: AnyBag) -> Survey:
    """Read a bag once, and find its segments, at least one of which has a sample with pose and twist.

    Raises
    ------
    BagError
        If a scenario message cannot be read, samples precede the first segment, or no pose has a twist.
    ParameterError
        If a declared scenario is impossible.
    """
    surveyor = Surveyor(bag)
    for _ in surveyor.samples():
        pass
    return surveyor.result()


class Surveyor:
    """A survey of a bag that is made while the samples pass. See `survey` for errors.

    Parameters
    ----------
    bag : Bag or Recording
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².

    Attributes
    ----------
    segments : tuple of Segment
        All that the bag declares, in the order of their starts.
    """

    def __init__(self, bag: AnyBag, inertia: Sequence[float] | None = None) -> None:
        declared = declared_segments((text for _, text in bag.scenario_texts), bag.name)
        self._bag = bag
        self._own = bag.is_original
        self._counts = Counts()
        self._counts.log_time_mismatches = sum(time != declared[text].start_ns for time, text in bag.scenario_texts)
        self.segments = tuple(_with_inertia(segment, inertia) for segment in declared.values())
        self._tallies = [SegmentTally(place, segment) for place, segment in enumerate(self.segments)]

    def blocks(self, sensors: Collection[str], take: TakeReadings) -> Iterator[tuple[int, Block]]:
        """Read the bag, and give its samples as `numbered_blocks` does, for all segments that it declares."""
        return numbered(self.segments, self.samples(sensors, take))

    def samples(self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None) -> Iterator[Block]:
        """Read the bag, and give its samples as they are counted, without numbers."""
        batches = self._counts.counted(self._bag.batches(sensors, take), stamped=self._bag.stamped)
        for topics, block in paired(self._bag, self.segments, batches):
            for name, topic in zip(self._tallies[0].stamps, topics, strict=False):
                for i, rows in segment_parts(self.segments, topic.stamps_ns):
                    self._tallies[i].stamps[name].add(topic.stamps_ns[rows])
                    scenario = self.segments[i].scenario
                    declared = scenario.world_frame if name == "pose" else scenario.body_frame
                    self._counts.foreign_frames.update(topic[rows].frame_ids - {declared})
            for i, rows in segment_parts(self.segments, block.stamps_ns):
                self._tallies[i].pair(block.stamps_ns[rows])
            yield block

    def result(self) -> Survey:
        """Survey of the bag, after all samples."""
        found = tuple(self._surveyed())
        require_samples(self._bag.name, self.segments, self._counts.first_ns, sum(segment.count for segment in found))
        return Survey(found, self.segments, self._own, self._counts)

    def _surveyed(self) -> Iterator[SurveyedSegment]:
        own = self._own
        late_start = not own
        cut_off = self._bag.lacks_end
        seen = {i for i, tally in enumerate(self._tallies) if not tally.is_empty}
        for i, following in segments_with_samples(self.segments, seen, whole=own):
            yield self._tallies[i].result(following, late_start=late_start, open_end=not own, cut_off=cut_off)
            late_start = False


def _with_inertia(segment: Segment, inertia: Sequence[float] | None) -> Segment:
    """Replace the inertia of a segment's body, kg m², if another one is given."""
    if inertia is None:
        return segment
    if segment.scenario.motion == "path":
        raise InputError("the motion is prescribed by a path, to which no inertia belongs: leave the inertia out")
    parameters = {**segment.scenario.parameters(), "inertia": list(inertia)}
    return replace(segment, scenario=type(segment.scenario).from_parameters(parameters))
