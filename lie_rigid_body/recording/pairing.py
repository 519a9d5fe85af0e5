"""Poses and twists of the same stamps put together, as a bag gives them: in file order, batch by batch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.segments import number_samples
from lie_rigid_body.recording.tracks import PoseTrack, TwistTrack
from lie_rigid_body.simulation import SampleClock

_HELD_BACK: Final = 1024
"""Number of samples that wait for others which stand behind them in the file, though they come first."""


@dataclass(frozen=True)
class Block:
    """Samples that have both pose and twist, in the order of their stamps.

    Parameters
    ----------
    samples : ndarray of int64, shape (N,)
        Their numbers; zeros until they are numbered.
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        Of shapes (N, 4) and (N, 3), not normalised.
    """

    samples: Integers
    stamps_ns: Integers
    states: State

    @classmethod
    def empty(cls) -> Block:
        """No sample."""
        none = np.empty(0, dtype=np.int64)
        return cls(none, none, State.trusted(np.empty((0, 4)), np.empty((0, 3))))

    def __getitem__(self, rows: slice | Integers | Booleans) -> Block:
        states = State.trusted(self.states.attitude_xyzw[rows], self.states.body_rate[rows])
        return Block(self.samples[rows], self.stamps_ns[rows], states)

    def joined(self, *later: Block) -> Block:
        """Samples followed by later ones."""
        blocks = (self, *later)
        return Block(
            np.concatenate([b.samples for b in blocks]),
            np.concatenate([b.stamps_ns for b in blocks]),
            State.trusted(
                np.concatenate([b.states.attitude_xyzw for b in blocks]),
                np.concatenate([b.states.body_rate for b in blocks]),
            ),
        )


@dataclass(frozen=True)
class StampedValues:
    """Stamps and values of one topic, in file order."""

    stamps_ns: Integers
    values: Array

    def followed_by(self, later: StampedValues) -> StampedValues:
        """Stamps and values followed by later ones."""
        return StampedValues(
            np.concatenate([self.stamps_ns, later.stamps_ns]), np.concatenate([self.values, later.values])
        )

    def __getitem__(self, rows: slice | Integers | Booleans) -> StampedValues:
        return StampedValues(self.stamps_ns[rows], self.values[rows])


class Pairing:
    """Pairs of poses and twists of one stamp, made as they come; what is too late, alone or doubled is left out."""

    def __init__(self) -> None:
        none = np.empty(0, dtype=np.int64)
        self._waiting = StampedValues(none, np.empty((0, 4))), StampedValues(none, np.empty((0, 3)))
        self._until = np.iinfo(np.int64).min
        self.alone = none
        """Stamps of what was released last that only one of the topics has."""

    def add(self, *new: StampedValues) -> Block:
        """Take poses and twists, and return the samples behind which none is expected any more."""
        ordered = [self._ordered(old.followed_by(later)) for old, later in zip(self._waiting, new, strict=True)]
        if any(len(topic.stamps_ns) <= _HELD_BACK for topic in ordered):
            self._waiting = ordered[0], ordered[1]
            return self._released(*(topic[:0] for topic in ordered))
        return self._release(ordered, min(int(topic.stamps_ns[-1 - _HELD_BACK]) for topic in ordered))

    def finish(self) -> Block:
        """Return all samples that are left."""
        return self._release(list(self._waiting), np.iinfo(np.int64).max)

    def _ordered(self, topic: StampedValues) -> StampedValues:
        """Sort by stamps; of several with one stamp the first is kept, and what comes too late is not."""
        stamps = topic.stamps_ns
        if len(stamps) and not (stamps[0] > self._until and (np.diff(stamps) > 0).all()):
            distinct, first = np.unique(stamps, return_index=True)
            return topic[first[distinct > self._until]]
        return topic

    def _release(self, topics: list[StampedValues], until: int) -> Block:
        at = [int(np.searchsorted(topic.stamps_ns, until, side="right")) for topic in topics]
        pose, twist = (topic[:i] for topic, i in zip(topics, at, strict=True))
        self._waiting = topics[0][at[0] :], topics[1][at[1] :]
        self._until = until
        return self._released(pose, twist)

    def _released(self, pose: StampedValues, twist: StampedValues) -> Block:
        if not np.array_equal(pose.stamps_ns, twist.stamps_ns):
            self.alone = np.setxor1d(pose.stamps_ns, twist.stamps_ns, assume_unique=True)
            _, in_pose, in_twist = np.intersect1d(
                pose.stamps_ns, twist.stamps_ns, assume_unique=True, return_indices=True
            )
            pose, twist = pose[in_pose], twist[in_twist]
        else:
            self.alone = np.empty(0, dtype=np.int64)
        return Block(np.zeros_like(pose.stamps_ns), pose.stamps_ns, State.trusted(pose.values, twist.values))


def stamped_values(
    batches: Iterable[tuple[PoseTrack, TwistTrack]], clock: SampleClock, bag: str, *, logged_at_stamps: bool
) -> Iterator[tuple[StampedValues, StampedValues]]:
    """Poses and twists with their stamps, batch by batch.

    A bare twist has its log time, if that is to be on the grid, or its pose's stamp: the two are then in one order.

    Parameters
    ----------
    batches : iterable of (PoseTrack, TwistTrack)
        Of a bag.
    clock : SampleClock
        Of the first segment.
    bag : str
        Its name, for errors.
    logged_at_stamps : bool
        Whether every message is to be logged at its stamp.

    Raises
    ------
    BagError
        At the end, if bare twists in order are not as many as poses.
    """
    by_log: bool | None = True if logged_at_stamps else None
    stamps, rates, counts = np.empty(0, dtype=np.int64), np.empty((0, 3)), [0, 0]
    for poses, twists in batches:
        pose = StampedValues(poses.stamps_ns, poses.attitudes_xyzw)
        if twists.stamps_ns is not None:
            yield pose, StampedValues(twists.stamps_ns, twists.body_rates)
            continue
        if by_log is None and len(twists.log_times_ns):
            by_log = _is_on_grid(clock, twists.log_times_ns[:1])
        if by_log:
            yield pose, StampedValues(twists.log_times_ns, twists.body_rates)
            continue
        counts = [counts[0] + len(poses.stamps_ns), counts[1] + len(twists.body_rates)]
        stamps, rates = np.concatenate([stamps, poses.stamps_ns]), np.concatenate([rates, twists.body_rates])
        both = min(len(stamps), len(rates))
        yield pose, StampedValues(stamps[:both], rates[:both])
        stamps, rates = stamps[both:], rates[both:]
    if len(stamps) or len(rates):
        raise BagError(
            f"{bag}: {counts[1]} twists without stamps cannot be paired with {counts[0]} poses: "
            "run the node with stamped_twist true, or record with it"
        )


def _is_on_grid(clock: SampleClock, stamps_ns: Integers) -> bool:
    return clock.stamp_ns(int(number_samples(clock, stamps_ns)[0])) == int(stamps_ns[0])
