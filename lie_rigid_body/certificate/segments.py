"""A bag cut at its resets into segments, the samples of each numbered, and pose and twist paired."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.pairing import Block, Pairing, stamped_values
from lie_rigid_body.certificate.stamps import number_samples
from lie_rigid_body.certificate.surveyed_segment import SegmentTally, SurveyedSegment, segment_parts, tally_pairs
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import MOST_SEGMENTS, Bag, PoseTrack, Recording, TakeReadings, TwistTrack
from lie_rigid_body.simulation import SOFTWARE, Segment
from lie_rigid_body.wording import short_repr

_RECORDER: Final = "libmcap "
"""How the library name of a file by `ros2 bag record` begins."""
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


def declared_segments(scenario_texts: Iterable[str]) -> dict[str, Segment]:
    """The segments by the texts that declare them, in the order of their starts; repeats of a text count once.

    Raises
    ------
    BagError
        If a scenario message cannot be read.
    ParameterError
        If one declares what cannot be, such as an impossible inertia.
    """
    texts = dict.fromkeys(scenario_texts)
    if len(texts) > MOST_SEGMENTS:
        raise BagError(f"the bag declares {len(texts)} segments: at most {MOST_SEGMENTS} are read, record fewer resets")
    try:
        segments = {text: Segment.from_json(text) for text in texts}
    except ParameterError:
        raise
    except InputError as error:
        raise BagError(f"the bag does not explain itself: {error}: record it anew") from None
    return dict(sorted(segments.items(), key=lambda item: item[1].start_ns))


def as_written(recording: Bag | Recording) -> bool:
    """Whether the bag is to be whole from its run's first sample on, and logged at its stamps, as by `BagWriter`.

    It is if it says so, by its library or by the record at its end, or if its first scenario is logged at its start.
    What `ros2 bag record` made of a running node begins in the midst, and is logged when it was received.
    """
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
    declared = declared_segments(text for _, text in bag.scenario_texts)
    segments = [_with_inertia(segment, inertia) for segment in declared.values()]
    facts, own = _Facts(), as_written(bag)
    cut_off = bag.was_cut_off and bag.expected_samples is None  # else the cut was behind the last sample
    facts.logged_otherwise = sum(time != declared[text].start_ns for time, text in bag.scenario_texts)
    tallies = [SegmentTally(segment) for segment in segments]
    pairing = Pairing()
    for topics in stamped_values(facts.counted(bag.batches()), segments[0].clock(), logged_at_stamps=own):
        for name, topic in zip(tallies[0].stamps, topics, strict=True):
            for i, rows in segment_parts(segments, topic.stamps_ns):
                tallies[i].stamps[name].add(topic.stamps_ns[rows])
        tally_pairs(tallies, pairing.add(*topics).stamps_ns, pairing.alone)
    tally_pairs(tallies, pairing.finish().stamps_ns, pairing.alone)
    if facts.first_ns < segments[0].start_ns:
        raise BagError(
            f"a sample is stamped {facts.first_ns} ns, before the first scenario message's start at "
            f"{segments[0].start_ns} ns: record the scenario topic from the start"
        )
    found: list[SurveyedSegment] = []
    for i, tally in enumerate(tallies):
        following = segments[i + 1].start_ns if i + 1 < len(segments) else None
        if not tally.is_empty or _should_have_samples(tally.segment, following, own or found):
            found.append(tally.result(following, late_start=not own and not found, open_end=not own, cut_off=cut_off))
    if not any(segment.count for segment in found):
        raise BagError("no sample has both a pose and a twist of the same stamp: record both topics together")
    return facts.survey(found, segments, as_written=own)


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
            self._moved += int(np.count_nonzero(poses.positions) + np.count_nonzero(twists.linear))
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
    topics = stamped_values(bag.batches(sensors, take), segments[0].clock(), logged_at_stamps=as_written(bag))
    for block in itertools.chain((pairing.add(*values) for values in topics), (pairing.finish() for _ in range(1))):
        for i, rows in segment_parts(segments, block.stamps_ns):
            part = block[rows]
            yield i, replace(part, samples=number_samples(segments[i].clock(), part.stamps_ns))


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


def _should_have_samples(segment: Segment, following: int | None, begun: object) -> bool:
    """Whether a segment without a sample lacks some: where recording had begun, and the next did not follow at once."""
    return bool(begun) and following is not None and following > segment.start_ns


def _with_inertia(segment: Segment, inertia: Sequence[float] | None) -> Segment:
    """The segment with the body of another inertia, kg m², if one is given."""
    if inertia is None:
        return segment
    parameters: dict[str, object] = {**segment.scenario.parameters(), "inertia": list(inertia)}
    return replace(segment, scenario=type(segment.scenario).from_parameters(parameters))


def seconds_since_start(segment: Segment, stamps_ns: Integers) -> Array:
    """Times since the segment's start, s."""
    return np.asarray((stamps_ns - segment.start_ns) * 1e-9, dtype=np.float64)
