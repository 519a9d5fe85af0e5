"""What a bag has of its segments, found as its samples pass."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.certificate.pairing import Block, Pairing, StampedValues, stamped_values
from lie_rigid_body.certificate.stamps import number_samples
from lie_rigid_body.certificate.surveyed_segment import SegmentTally, SurveyedSegment, segment_parts, tally_pairs
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.recording.bag_reader import MOST_SEGMENTS, Bag
from lie_rigid_body.recording.bag_writer import REWRITTEN
from lie_rigid_body.recording.tracks import UNNAMED, PoseTrack, Recording, TakeReadings, TwistTrack
from lie_rigid_body.simulation import SOFTWARE, Segment

_RECORDER: Final = "libmcap "
"""How the library name of a file by `ros2 bag record` begins."""


def declared_segments(scenario_texts: Iterable[str], bag: str = UNNAMED) -> dict[str, Segment]:
    """The segments by the texts that declare them, in the order of their starts; repeats of a text count once.

    Errors call the bag by the name that is given.

    Raises
    ------
    BagError
        If a scenario message cannot be read.
    ParameterError
        If one declares what cannot be, such as an impossible inertia.
    """
    texts = dict.fromkeys(scenario_texts)
    if len(texts) > MOST_SEGMENTS:
        raise BagError(f"{bag} declares {len(texts)} segments: at most {MOST_SEGMENTS} are read, record fewer resets")
    try:
        segments = {text: Segment.from_json(text) for text in texts}
    except ParameterError:
        raise
    except InputError as error:
        raise BagError(f"{bag} does not explain itself: {error}: record it anew") from None
    return dict(sorted(segments.items(), key=lambda item: item[1].start_ns))


def as_written(recording: Bag | Recording) -> bool:
    """Whether the bag is to be whole from its run's first sample on, and logged at its stamps, as by `BagWriter`.

    It is if it says so, by its library or by the record at its end, or if its first scenario is logged at its start.
    What `ros2 bag record` made of a running node begins in the midst, and is logged when it was received; what
    `Run.to_bag` made of such a bag begins there as well.
    """
    if REWRITTEN in recording.library:
        return False
    if recording.library.startswith(f"{SOFTWARE} ") or recording.expected_samples is not None:
        return True
    log_time, text = recording.scenario_texts[0]
    return log_time == Segment.from_json(text).start_ns and not recording.library.startswith(_RECORDER)


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
        See `as_written`.
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
        self._bag, self._own, self._facts = bag, as_written(bag), _Facts()
        self._facts.logged_otherwise = sum(time != declared[text].start_ns for time, text in bag.scenario_texts)
        self._segments = [_with_inertia(segment, inertia) for segment in declared.values()]
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
        return _numbered(self._segments, self.samples(sensors, take))

    def samples(self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None) -> Iterator[Block]:
        """Read the bag, and give its samples as they are counted, without numbers."""
        pairing, batches = Pairing(), self._facts.counted(self._bag.batches(sensors, take))
        for topics in stamped_values(batches, self._segments[0].clock(), self._bag.name, logged_at_stamps=self._own):
            self._count(topics)
            yield self._paired(pairing.add(*topics), pairing)
        yield self._paired(pairing.finish(), pairing)

    def _count(self, topics: tuple[StampedValues, StampedValues]) -> None:
        for name, topic in zip(self._tallies[0].stamps, topics, strict=True):
            for i, rows in segment_parts(self._segments, topic.stamps_ns):
                self._tallies[i].stamps[name].add(topic.stamps_ns[rows])

    def _paired(self, block: Block, pairing: Pairing) -> Block:
        tally_pairs(self._tallies, block.stamps_ns, pairing.alone)
        return block

    def result(self) -> Survey:
        """What was found, after all samples."""
        segments, first_ns = self._segments, self._facts.first_ns
        if first_ns < segments[0].start_ns:
            raise BagError(
                f"{self._bag.name}: a sample is stamped {first_ns} ns, before the first scenario message's start at "
                f"{segments[0].start_ns} ns: record the scenario topic from the start"
            )
        found = list(self._surveyed())
        if not any(segment.count for segment in found):
            raise BagError(
                f"{self._bag.name}: no sample has both a pose and a twist of the same stamp: "
                "record both topics together"
            )
        return self._facts.survey(found, segments, as_written=self._own)

    def _surveyed(self) -> Iterator[SurveyedSegment]:
        bag, own, begun = self._bag, self._own, False
        cut_off = bag.was_cut_off and bag.expected_samples is None  # else the cut was behind the last sample
        for tally, later in itertools.zip_longest(self._tallies, self._segments[1:]):
            following = None if later is None else later.start_ns
            if not tally.is_empty or _should_have_samples(tally.segment, following, own or begun):
                late_start = not own and not begun
                yield tally.result(following, late_start=late_start, open_end=not own, cut_off=cut_off)
                begun = True


class _Facts:
    """What is counted of all messages as they pass."""

    def __init__(self) -> None:
        self.first_ns = int(np.iinfo(np.int64).max)
        self._counts = [0, 0]
        self._frames: tuple[set[str], set[str]] = set(), set()
        self._moved = self.logged_otherwise = 0

    def counted(self, batches: Iterable[tuple[PoseTrack, TwistTrack]]) -> Iterator[tuple[PoseTrack, TwistTrack]]:
        """The same batches, counted."""
        for poses, twists in batches:
            tracks: tuple[PoseTrack | TwistTrack, ...] = poses, twists
            for i, track in enumerate(tracks):
                self._frames[i].update(track.frame_ids)
                self._counts[i] += len(track.log_times_ns)
                if track.stamps_ns is not None and len(track.stamps_ns):
                    self.first_ns = min(self.first_ns, int(track.stamps_ns.min()))
                    self.logged_otherwise += int(np.count_nonzero(track.log_times_ns != track.stamps_ns))
            self._moved += sum(int(np.count_nonzero(column)) for column in (*poses.positions.T, *twists.linear.T))
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


def numbered_blocks(
    bag: Bag | Recording,
    segments: Sequence[Segment],
    sensors: Collection[str] = (),
    take: TakeReadings = lambda readings: None,
) -> Iterator[tuple[int, Block]]:
    """The samples that have both pose and twist, in the order of their stamps, each block with its segment's place.

    Sensors' messages are read with them, and taken as in `Bag.batches`.
    """
    pairing = Pairing()
    batches = bag.batches(sensors, take)
    topics = stamped_values(batches, segments[0].clock(), bag.name, logged_at_stamps=as_written(bag))
    samples = (pairing.add(*values) for values in topics)
    return _numbered(segments, itertools.chain(samples, (pairing.finish() for _ in range(1))))


def _numbered(segments: Sequence[Segment], samples: Iterable[Block]) -> Iterator[tuple[int, Block]]:
    for block in samples:
        for i, rows in segment_parts(segments, block.stamps_ns):
            part = block[rows]
            yield i, replace(part, samples=number_samples(segments[i].clock(), part.stamps_ns))


def _should_have_samples(segment: Segment, following: int | None, begun: bool) -> bool:
    """Whether a segment without a sample lacks some: where recording had begun, and the next did not follow at once."""
    return begun and following is not None and following > segment.start_ns


def _with_inertia(segment: Segment, inertia: Sequence[float] | None) -> Segment:
    """The segment with the body of another inertia, kg m², if one is given."""
    if inertia is None:
        return segment
    parameters: dict[str, object] = {**segment.scenario.parameters(), "inertia": list(inertia)}
    return replace(segment, scenario=type(segment.scenario).from_parameters(parameters))
