"""A bag as samples: poses and twists of one stamp together, numbered, segment by segment."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.stamped import Stamped
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.segments import (
    number_samples,
    segment_parts,
)
from lie_rigid_body.recording.topic_messages import TakeReadings, TopicMessages
from lie_rigid_body.simulation import SampleClock, Segment

Batches: TypeAlias = Iterable[tuple[TopicMessages, TopicMessages]]
"""Poses and twists in file order."""
Topics: TypeAlias = tuple[TopicMessages, ...]
"""Poses and twists with their stamps, or none of either."""
_HELD_BACK: Final = 1024
"""Number of samples that wait for others which stand behind them in the file, though they come first."""


@short_dataclass
class Block(Stamped):
    """Samples that have both pose and twist, in the order of their stamps.

    Parameters
    ----------
    samples : ndarray of int64, shape (N,)
        Their numbers; zeros until they are numbered.
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        Of shapes (N, 4) and (N, 3), not normalised.
    position, body_velocity : ndarray, shape (N, 3)
        Of the mass centre in the world, m, and along the body's axes, m/s.
    """

    samples: Integers
    stamps_ns: Integers
    states: State
    position: Array
    body_velocity: Array

    @classmethod
    def joined(cls, parts: Iterable[Block]) -> Block:
        """Samples of blocks that follow each other, or of none."""
        none = np.empty(0, dtype=np.int64)
        vectors = np.empty((0, 3))
        return super().joined([cls(none, none, State.trusted(np.empty((0, 4)), vectors), vectors, vectors), *parts])


def _ordered(topic: TopicMessages, until: int) -> TopicMessages:
    """Sort by stamps; of several with one stamp the first is kept, and what comes too late is not."""
    stamps = topic.stamps_ns
    if len(stamps) and not (stamps[0] > until and (np.diff(stamps) > 0).all()):
        distinct, first = np.unique(stamps, return_index=True)
        return topic[first[distinct > until]]
    return topic


def _together(pose: TopicMessages, twist: TopicMessages) -> Block:
    """Samples of ordered poses and twists: the stamps that both topics have."""
    if not np.array_equal(pose.stamps_ns, twist.stamps_ns):
        _, *both = np.intersect1d(pose.stamps_ns, twist.stamps_ns, assume_unique=True, return_indices=True)
        pose = pose[both[0]]
        twist = twist[both[1]]
    states = State.trusted(pose.values[:, 3:].copy(), twist.values[:, 3:].copy())
    numbers = np.zeros_like(pose.stamps_ns)
    return Block(numbers, pose.stamps_ns, states, pose.values[:, :3], twist.values[:, :3])


def stamped_topics(bag: Bag | Recording, batches: Batches, clock: SampleClock) -> Iterator[Topics]:
    """Poses and twists with their stamps, batch by batch.

    A bare twist has its log time, if that is to be on the grid, or its pose's stamp: the two are then in one order.

    Parameters
    ----------
    bag : Bag or Recording
    batches : iterable of (TopicMessages, TopicMessages)
        Poses and twists of the bag, in file order.
    clock : SampleClock
        Of the first segment.

    Raises
    ------
    BagError
        At the end, if bare twists in order are not as many as poses.
    """
    by_log: bool | None = True if bag.stamped or bag.is_original else None
    stamps = np.empty(0, dtype=np.int64)
    waiting = list[TopicMessages]()
    for poses, twists in batches:
        if by_log is None and len(twists):
            first_ns = twists.log_times_ns[:1]
            by_log = clock.stamp_ns(int(number_samples(clock, first_ns)[0])) == int(first_ns[0])
        if by_log:
            yield poses, twists
            continue
        stamps = np.concatenate([stamps, poses.stamps_ns])
        rest = TopicMessages.joined([*waiting, twists])
        both = min(len(stamps), len(rest))
        yield poses, replace(rest[:both], stamps_ns=stamps[:both])
        stamps = stamps[both:]
        waiting = [rest[both:]]
    if not by_log and (len(stamps) or any(map(len, waiting))):
        raise BagError(
            f"{bag.name}: {bag.twist_count} twists without stamps cannot be paired with {bag.pose_count} poses: "
            "run the node with stamped_twist true, or record with it"
        )


def paired(bag: Bag | Recording, segments: Sequence[Segment], batches: Batches) -> Iterator[tuple[Topics, Block]]:
    """Put poses and twists of one stamp together as they come; what is too late, alone or doubled is left out.

    Parameters
    ----------
    bag : Bag or Recording
    segments : sequence of Segment
        All that the bag declares, in the order of their starts.
    batches : iterable of (TopicMessages, TopicMessages)
        Poses and twists of the bag, in file order.

    Yields
    ------
    topics : Topics
        Poses and twists that were read; none behind the last ones.
    block : Block
        Samples that are complete by that, not numbered.
    """
    waiting: Topics = ()
    until = int(np.iinfo(np.int64).min)
    for topics in stamped_topics(bag, batches, segments[0].clock()):
        parts = zip(waiting, topics, strict=True) if waiting else zip(topics)
        waiting = tuple(_ordered(TopicMessages.joined(part), until) for part in parts)
        if all(len(topic) > _HELD_BACK for topic in waiting):  # none is expected any more that comes before these
            until = min(int(topic.stamps_ns[-1 - _HELD_BACK]) for topic in waiting)
        ends = [int(np.searchsorted(topic.stamps_ns, until, side="right")) for topic in waiting]
        yield topics, _together(*(topic[:end] for topic, end in zip(waiting, ends, strict=True)))
        waiting = tuple(topic[end:] for topic, end in zip(waiting, ends, strict=True))
    yield (), _together(*waiting)


def numbered(segments: Sequence[Segment], samples: Iterable[Block]) -> Iterator[tuple[int, Block]]:
    """Number samples, and cut blocks at the starts of segments; each comes with its segment's place."""
    for block in samples:
        for i, rows in segment_parts(segments, block.stamps_ns):
            part = block[rows]
            yield i, replace(part, samples=number_samples(segments[i].clock(), part.stamps_ns))


def numbered_blocks(
    bag: Bag | Recording,
    segments: Sequence[Segment],
    sensors: Collection[str] = (),
    take: TakeReadings = lambda readings: None,
) -> Iterator[tuple[int, Block]]:
    """Samples that have both pose and twist, in the order of their stamps, each block with its segment's place.

    Parameters
    ----------
    bag : Bag or Recording
    segments : sequence of Segment
    sensors, take : optional
        Topics that are read as well, and what takes their messages; see `Bag.batches`.
    """
    return numbered(segments, (block for _, block in paired(bag, segments, bag.batches(sensors, take))))


def require_samples(name: str, segments: Sequence[Segment], first_ns: int, count: int) -> None:
    """Refuse a bag without samples, or with some that no scenario explains.

    Parameters
    ----------
    name : str
        Name of the bag.
    segments : sequence of Segment
    first_ns : int
        Earliest stamp in a header, ns.
    count : int
        Number of samples with pose and twist in the segments.

    Raises
    ------
    BagError
    """
    if first_ns < segments[0].start_ns:
        raise BagError(
            f"{name}: a sample is stamped {first_ns} ns, before the first scenario message's start at "
            f"{segments[0].start_ns} ns: record the scenario topic from the start"
        )
    if not count:
        raise BagError(f"{name}: no sample has both a pose and a twist of the same stamp: record both topics together")
