"""What a bag has of its segments, found as its samples pass."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.certificate.surveyed_segment import SegmentTally, SurveyedSegment, tally_pairs
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.samples import Batches, Block, numbered, paired, require_samples
from lie_rigid_body.recording.segments import declared_segments, segment_parts, segments_with_samples, with_inertia
from lie_rigid_body.recording.topic_messages import TakeReadings
from lie_rigid_body.simulation import Segment


@dataclass(frozen=True)
class Survey:
    """What a first pass through a bag finds.

    Parameters
    ----------
    segments : tuple of SurveyedSegment
        Segments without a sample, which a reset followed at once, are left out.
    declared : tuple of Segment
        All that the bag declares, in the order of their starts.
    as_written : bool
        See `BagFacts.as_written`.
    poses, twists : int
        Messages.
    world_frames, body_frames : frozenset of str
        Frames that poses and twists name.
    moved : int
        Components of position and linear velocity that are not 0.
    logged_otherwise : int
        Messages that were not logged at their stamps, scenarios at their starts.
    """

    segments: tuple[SurveyedSegment, ...]
    declared: tuple[Segment, ...]
    as_written: bool
    poses: int
    twists: int
    world_frames: frozenset[str]
    body_frames: frozenset[str]
    moved: int
    logged_otherwise: int

    def is_as(self, foreseen: Survey) -> bool:
        """Whether laws that were held as for another survey, of the same bag, are as they are to be for this one."""
        own, others = self.segments, foreseen.segments
        return len(own) == len(others) and all(map(SurveyedSegment.is_held_as, own, others))


def survey(bag: Bag | Recording, inertia: Sequence[float] | None = None) -> Survey:
    """Read a bag once, and find its segments, at least one of which has a sample with pose and twist.

    Parameters
    ----------
    bag : Bag or Recording
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².

    Raises
    ------
    BagError
        If a scenario message cannot be read, samples precede the first segment, or no pose has a twist.
    ParameterError
        If a declared scenario or the given inertia is impossible.
    """
    surveyor = Surveyor(bag, inertia)
    for _ in surveyor.samples():
        pass
    return surveyor.result()


class Surveyor:
    """A survey of a bag that is made while the samples pass. See `survey` for parameters and errors."""

    def __init__(self, bag: Bag | Recording, inertia: Sequence[float] | None = None) -> None:
        declared = declared_segments((text for _, text in bag.scenario_texts), bag.name)
        self._bag, self._own, self._facts = bag, bag.as_written, _Facts()
        self._facts.logged_otherwise = sum(time != declared[text].start_ns for time, text in bag.scenario_texts)
        self._segments = [with_inertia(segment, inertia) for segment in declared.values()]
        self._tallies = [SegmentTally(segment) for segment in self._segments]

    def foreseen(self) -> Survey | None:
        """What will be found of a bag that is to be whole, if its samples are all there; None where they cannot be.

        With it laws are held while the bag is surveyed. Where `result` is not as it, they have to be held anew.
        """
        bag, rest, found = self._bag, self._bag.pose_count, list[SurveyedSegment]()
        if not self._own or rest != bag.twist_count:
            return None
        for segment, later in itertools.zip_longest(self._segments, self._segments[1:]):
            until = MAX_EPOCH_NS if later is None else later.start_ns - 1
            count = min(rest, segment.clock().count_until(until) - segment.first_sample)
            if count < 1:
                return None
            found.append(SurveyedSegment.whole(segment, count))
            rest -= count
        return None if rest else self._facts.survey(found, self._segments, as_written=True)

    def blocks(self, sensors: Collection[str], take: TakeReadings) -> Iterator[tuple[int, Block]]:
        """Read the bag, and give its samples as `numbered_blocks` does, for all segments that it declares."""
        return numbered(self._segments, self.samples(sensors, take))

    def samples(self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None) -> Iterator[Block]:
        """Read the bag, and give its samples as they are counted, without numbers."""
        batches = self._facts.counted(self._bag.batches(sensors, take), stamped=self._bag.stamped)
        for topics, block, alone in paired(self._bag, self._segments, batches):
            for name, topic in zip(self._tallies[0].stamps, topics, strict=False):
                for i, rows in segment_parts(self._segments, topic.stamps_ns):
                    self._tallies[i].stamps[name].add(topic.stamps_ns[rows])
            tally_pairs(self._tallies, block.stamps_ns, alone)
            yield block

    def result(self) -> Survey:
        """What was found, after all samples."""
        found = list(self._surveyed())
        require_samples(self._bag.name, self._segments, self._facts.first_ns, sum(segment.count for segment in found))
        return self._facts.survey(found, self._segments, as_written=self._own)

    def _surveyed(self) -> Iterator[SurveyedSegment]:
        bag, own, late_start = self._bag, self._own, not self._own
        cut_off = bag.was_cut_off and bag.expected_samples is None  # else the cut was behind the last sample
        seen = {i for i, tally in enumerate(self._tallies) if not tally.is_empty}
        for i, following in segments_with_samples(self._segments, seen, whole=own):
            yield self._tallies[i].result(following, late_start=late_start, open_end=not own, cut_off=cut_off)
            late_start = False


class _Facts:
    """What is counted of all messages as they pass."""

    def __init__(self) -> None:
        self.first_ns = int(np.iinfo(np.int64).max)
        self._counts = [0, 0]
        self._frames: tuple[set[str], set[str]] = set(), set()
        self._moved = self.logged_otherwise = 0

    def counted(self, batches: Batches, *, stamped: bool) -> Batches:
        """Give the batches on, and count what is in them."""
        for poses, twists in batches:
            for i, topic in enumerate((poses, twists)):
                self._frames[i].update(topic.frame_ids)
                self._counts[i] += len(topic)
                if i == 0 or stamped:
                    self.first_ns = min(self.first_ns, int(topic.stamps_ns.min(initial=self.first_ns)))
                self.logged_otherwise += int(np.count_nonzero(topic.log_times_ns != topic.stamps_ns))
                self._moved += sum(int(np.count_nonzero(column)) for column in topic.values[:, :3].T)
            yield poses, twists

    def survey(self, segments: list[SurveyedSegment], declared: list[Segment], *, as_written: bool) -> Survey:
        """Together with these segments."""
        (poses, twists), (worlds, bodies) = self._counts, map(frozenset, self._frames)
        return Survey(
            tuple(segments),
            tuple(declared),
            as_written,
            poses,
            twists,
            worlds,
            bodies,
            self._moved,
            self.logged_otherwise,
        )
