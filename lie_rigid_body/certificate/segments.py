"""A recording cut at its resets into segments, the samples of each numbered, and pose and twist paired."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.stamps import number_samples, stamp_law
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.simulation import Segment


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
    """

    segment: Segment
    samples: Integers
    stamps_ns: Integers
    states: State
    stamps: LawResult


@dataclass(frozen=True)
class _StampedValues:
    """Stamps and values of one topic, in file order."""

    name: str
    stamps_ns: Integers
    values: Array

    def between(self, begin: int, end: int | None) -> _StampedValues:
        """Those stamped from ``begin`` on and before ``end``, ns, if it is given."""
        inside = self.stamps_ns >= begin
        if end is not None:
            inside &= self.stamps_ns < end
        return replace(self, stamps_ns=self.stamps_ns[inside], values=self.values[inside])


def declared_segments(scenario_texts: Iterable[str]) -> list[Segment]:
    """The segments that scenario messages declare, in the order of their starts; repeats of a message count once.

    Raises
    ------
    BagError
        If a scenario message cannot be read.
    ParameterError
        If one declares what cannot be, such as an impossible inertia.
    """
    try:
        segments = [Segment.from_json(text) for text in dict.fromkeys(scenario_texts)]
    except ParameterError:
        raise
    except InputError as error:
        raise BagError(f"the bag does not explain itself: {error}") from None
    return sorted(segments, key=lambda segment: segment.start_ns)


def logged_at_stamps(recording: Recording) -> bool:
    """Whether the first scenario message was logged at its segment's start, as by `BagWriter`, not by a recorder."""
    log_time, text = recording.scenario_texts[0]
    return log_time == Segment.from_json(text).start_ns


def recorded_segments(recording: Recording, inertia: Sequence[float] | None = None) -> list[RecordedSegment]:
    """The segments of a recording with their samples, at least one of which has a sample with pose and twist.

    Parameters
    ----------
    recording : Recording
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².

    Returns
    -------
    list of RecordedSegment
        Segments without a sample, which a reset followed at once, are left out.

    Raises
    ------
    BagError
        If a scenario message cannot be read, samples precede the first segment, or no pose has a twist.
    ParameterError
        If a declared scenario or the given inertia is impossible.
    """
    declared = declared_segments(text for _, text in recording.scenario_texts)
    segments = [_with_inertia(segment, inertia) for segment in declared]
    pose = _StampedValues("pose", recording.poses.stamps_ns, recording.poses.attitudes_xyzw)
    twist = _StampedValues("twist", _twist_stamps(recording, segments), recording.twists.body_rates)
    first = min(int(pose.stamps_ns.min()), int(twist.stamps_ns.min()))
    if first < segments[0].start_ns:
        raise BagError(
            f"a sample is stamped {first} ns, before the first scenario message's start at {segments[0].start_ns} ns: "
            "record the scenario topic from the start"
        )
    own = logged_at_stamps(recording)
    found: list[RecordedSegment] = []
    for i, segment in enumerate(segments):
        following = segments[i + 1].start_ns if i + 1 < len(segments) else None
        topics = [topic.between(segment.start_ns, following) for topic in (pose, twist)]
        if any(topic.stamps_ns.size for topic in topics):
            found.append(
                _recorded_segment(segment, following, topics, late_start=not own and not found, open_end=not own)
            )
    if not any(len(recorded.samples) for recorded in found):
        raise BagError("no sample has both a pose and a twist of the same stamp: record both topics together")
    return found


def _with_inertia(segment: Segment, inertia: Sequence[float] | None) -> Segment:
    """The segment with the body of another inertia, kg m², if one is given."""
    if inertia is None:
        return segment
    parameters: dict[str, object] = {**segment.scenario.parameters(), "inertia": list(inertia)}
    return replace(segment, scenario=type(segment.scenario).from_parameters(parameters))


def _twist_stamps(recording: Recording, segments: list[Segment]) -> Integers:
    """The twists' own stamps; a bare twist has its log time, if that is on the grid, or its pose's stamp."""
    twists = recording.twists
    if twists.stamps_ns is not None:
        return twists.stamps_ns
    clock = segments[0].clock()
    logged = twists.log_times_ns
    if np.array_equal(clock.stamps_ns(int(number_samples(clock, logged[:1])[0]), 1), logged[:1]):
        return logged
    if len(logged) != len(recording.poses.stamps_ns):
        raise BagError(
            f"{len(logged)} twists without stamps cannot be paired with {len(recording.poses.stamps_ns)} poses: "
            "run the node with stamped_twist true, or record with it"
        )
    return recording.poses.stamps_ns


def _recorded_segment(
    segment: Segment, following: int | None, topics: list[_StampedValues], *, late_start: bool, open_end: bool
) -> RecordedSegment:
    law = stamp_law(
        segment,
        following,
        {topic.name: topic.stamps_ns for topic in topics},
        late_start=late_start,
        open_end=open_end and following is None,
    )
    pose, twist = (_unique(topic) for topic in topics)
    common, at_pose, at_twist = np.intersect1d(pose.stamps_ns, twist.stamps_ns, return_indices=True)
    numbers = number_samples(segment.clock(), common)
    states = State.trusted(pose.values[at_pose], twist.values[at_twist])
    return RecordedSegment(segment, numbers, common, states, law)


def _unique(topic: _StampedValues) -> _StampedValues:
    """The first of the values of each stamp, in the order of the stamps."""
    stamps, first = np.unique(topic.stamps_ns, return_index=True)
    return replace(topic, stamps_ns=stamps, values=topic.values[first])


def seconds_since_start(segment: Segment, stamps_ns: Integers) -> Array:
    """Times since the segment's start, s."""
    return np.asarray((stamps_ns - segment.start_ns) * 1e-9, dtype=np.float64)
