"""What counts of a topic of attitudes or biases, of an estimate or of its truth, in memory that does not grow."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.arguments import SMALLEST_NORM
from lie_rigid_body.evaluation.attitudes import in_order, period_ns
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS, exact_duration
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.decoding import Frames
from lie_rigid_body.recording.topic_messages import AttitudeTrack, vectors_of
from lie_rigid_body.runs.readings import linear

MOST_KEPT: Final = 100_000
"""Largest number of attitudes that are kept: a quarter of an hour at 100 Hz.

Of more every second is kept, then every fourth, and so on. Their score takes about 3 s; launch kills what does not end
within 10 s."""
MOST_ARRAYS: Final = 2000
"""Largest number of arrays of kept attitudes before they are joined."""
LENIENCE_NS: Final = NS
"""Largest time between neighbours, ns, that counts as no leap of the stamps. The last estimate and the last pose heard
may differ by as much, as each has its own way. The scenario tells the truth so far beyond the poses."""
AGREEING: Final = 3
"""Number of attitudes after which a leap of stamps, or the name of a frame, is no mistake of one message."""
LONE: Final = 9
"""Number of waiting attitudes after which a topic counts as slow, if no `AGREEING` of them are near each other."""
STEPS: Final = 4
"""Largest step of a stamp on a slow topic that is no leap, as a multiple of the topic's latest period."""

MOST_FRAMES: Final = 20
"""Largest number of pairs of frames of one topic that are told apart, beside the one that is wanted."""

STRAY, DISORDERED, UNUSABLE_ATTITUDES, OF_OTHERS = "stray", "disordered", "unusable", "of_others"
_SENTENCES: Final = {
    STRAY: "{count} of {whole} are left out, whose stamps leap from those beside them, the first to {first} s: find "
    "out what stamped them",
    DISORDERED: "{count} of {whole} were stamped before one that had come, the first {first} s, and are left out: let "
    "one node publish them, whose time never jumps back",
    UNUSABLE_ATTITUDES: "{count} of {whole} are not finite, or zero, the first stamped {first} s: they are left out; "
    "find out why they were given",
    OF_OTHERS: "{count} of {whole} are of other frames, the first stamped {first} s, and are left out: let one node "
    "publish one body",
}
"""Sentences for the reader of a score, one for each kind of attitudes that are left out."""


class KeptAttitudes:
    """Usable attitudes in order of time, evenly thinned so that memory does not grow.

    One bad message costs itself alone. A stamp that leaps ahead waits until it is one of `AGREEING` in a row, as one
    wrong stamp would put all later ones out of order. Attitudes of another frame count from as many on.

    Parameters
    ----------
    most : int, optional
        Largest number that are kept.
    duration_s : float, optional
        Time, s, by stamps, in which attitudes count, from the first one on; by default whenever they are stamped.

    Raises
    ------
    InputError
        If it is not a time.

    Attributes
    ----------
    count : int
        Number of attitudes that count.
    first_ns : int or None
        Stamp of the first attitude.
    last_ns : int or None
        Stamp of the last attitude whose stamp is believed, ns, usable or not.
    complete : bool
        Whether an attitude came that is stamped at the end of the duration, or later.
    stride : int
        One in so many is kept.
    frames : Counter of tuple of str
        Numbers of attitudes by their frame and child frame.
    followed : tuple of str or None
        Frame and child frame of those that count, once that is known.
    """

    def __init__(self, most: int = MOST_KEPT, duration_s: float | None = None) -> None:
        self._most = most
        self._length_ns = None if duration_s is None else round(exact_duration(duration_s, "duration", "60.0") * NS)
        self.count, self.stride = 0, 1
        self.complete = self._has_begun = False
        self.first_ns: int | None = None
        self.last_ns: int | None = None
        self.followed: Frames | None = None
        self.frames = Counter[Frames]()
        self._undecided: list[tuple[Frames, AttitudeTrack]] = []
        self._left_out: dict[str, tuple[int, int]] = {}
        self._waiting: list[AttitudeTrack] = []
        self._blocks: list[AttitudeTrack] = []
        self._last: list[AttitudeTrack] = []
        self._period_ns = 0

    @property
    def due_ns(self) -> int | None:
        """Stamp of the end of the duration, ns; None without one, or before the first attitude."""
        return None if self._length_ns is None or self.first_ns is None else self.first_ns + self._length_ns

    @property
    def span_s(self) -> float:
        """Time from the first attitude to the last, by their stamps, s."""
        return 0.0 if self.first_ns is None or self.last_ns is None else (self.last_ns - self.first_ns) / NS

    def number_of(self, *kinds: str) -> int:
        """Number of attitudes of some kinds that were left out."""
        return sum(self._left_out.get(kind, (0, 0))[0] for kind in kinds)

    def leave_out(self, kind: str, stamps_ns: Integers) -> None:
        """Count attitudes that are left out."""
        if len(stamps_ns):
            count, first_ns = self._left_out.get(kind, (0, int(stamps_ns[0])))
            self._left_out[kind] = count + len(stamps_ns), first_ns

    def of_one_body(self, found: Mapping[Frames, AttitudeTrack], wanted: Frames | None = None) -> list[AttitudeTrack]:
        """Choose from attitudes by their frames those of the body that is followed.

        Parameters
        ----------
        found : mapping of tuple of str to AttitudeTrack
            Attitudes by frame and child frame.
        wanted : tuple of str, optional
            Names of the frames that are followed; by default those of which the first `AGREEING` come.
        """
        for frames, track in found.items():
            if frames in self.frames or len(self.frames) < MOST_FRAMES or frames == wanted:
                self.frames[frames] += len(track)
                self._undecided.append((frames, track))
        agreed = (frames for frames, count in self.frames.items() if count >= AGREEING)
        self.followed = wanted or self.followed or next(agreed, None)
        if self.followed is None:
            return []
        decided, self._undecided = self._undecided, []
        for frames, track in decided if wanted is None else ():
            if frames != self.followed:
                self.leave_out(OF_OTHERS, track.stamps_ns)
        return [track for frames, track in decided if frames == self.followed and len(track)]

    def add(self, track: AttitudeTrack, truth_ns: int = 0) -> AttitudeTrack:
        """Take attitudes, and return what counts of them and of those that waited.

        Parameters
        ----------
        track : AttitudeTrack
        truth_ns : int, optional
            Begin of the truth, ns.
        """
        leaps = np.flatnonzero(np.abs(np.diff(track.stamps_ns)) > LENIENCE_NS) + 1
        pieces = [track[rows] for rows in np.split(np.arange(len(track)), leaps) if len(rows)]
        return self._counted(AttitudeTrack.joined([track[:0], *map(self._believed, pieces)]), truth_ns)

    def end(self, truth_ns: int = 0, until_ns: int | None = None) -> None:
        """Take the waiting attitudes if nothing else has come, or the truth goes on so far, and else leave them out.

        Parameters
        ----------
        truth_ns, until_ns : int, optional
            Begin and end of the truth, ns.
        """
        if self.followed is None and self.frames:
            for track in self.of_one_body({}, max(self.frames, key=lambda frames: self.frames[frames])):
                self.add(track, truth_ns)
        if self._waiting and self.last_ns is None:
            self._counted(self._agreeing(slow=True), truth_ns)
        for track in self._waiting:
            inside = track.stamps_ns <= (-np.inf if until_ns is None else until_ns + LENIENCE_NS)
            self._counted(self._ordered(track[inside]), truth_ns)
            self.leave_out(STRAY, track.stamps_ns[~inside])
        self._waiting = []

    def track(self) -> AttitudeTrack:
        """The attitudes that are kept, and the last; of at least one that came."""
        return AttitudeTrack.joined([*self._blocks, *(self._last if (self.count - 1) % self.stride else [])])

    def notes(self, name: str) -> dict[str, str]:
        """Sentences, without a full stop, for the reader of the score by the kind of attitudes that are left out.

        Parameters
        ----------
        name : str
            What the attitudes are called, as ``estimates``.
        """
        whole = f"{self.count + sum(count for count, _ in self._left_out.values())} {name}"
        return {
            kind: _SENTENCES[kind].format(count=count, whole=whole, first=f"{first_ns / NS:.13g}")
            for kind, (count, first_ns) in self._left_out.items()
        }

    def _believed(self, piece: AttitudeTrack) -> AttitudeTrack:
        """Attitudes that are believed when a piece without a leap comes: its own, or waiting ones that agree."""
        ahead_ns = np.inf if self.last_ns is None else int(piece.stamps_ns[0]) - self.last_ns
        if ahead_ns > max(LENIENCE_NS, STEPS * self._period_ns):
            self._waiting.append(piece)
            return self._agreeing(sum(map(len, self._waiting[:-1])) + AGREEING)
        if ahead_ns >= -LENIENCE_NS:
            for track in self._waiting:  # what had leapt ahead of this did so by mistake
                self.leave_out(STRAY, track.stamps_ns)
            self._waiting = []
        return self._ordered(piece)

    def _agreeing(self, most: int = LONE, *, slow: bool = False) -> AttitudeTrack:
        """Take the waiting attitudes whose stamps agree, if they are enough; on a slow topic these are farther apart.

        Parameters
        ----------
        most : int, optional
            Number of the first that decide; those behind have no leap before them.
        slow : bool, optional
            Whether nothing more is waited for.
        """
        waiting = AttitudeTrack.joined(self._waiting)
        head = waiting.stamps_ns[:most]
        beside = np.abs(head[:, np.newaxis] - head) <= AGREEING * LENIENCE_NS
        agree = beside[np.argmax(beside.sum(axis=1))]
        if np.count_nonzero(agree) < AGREEING:
            if len(head) < LONE and not slow:
                return waiting[:0]
            agree = head <= np.minimum.accumulate(head[::-1])[::-1] + LENIENCE_NS
        self._waiting = []
        self.leave_out(STRAY, head[~agree])
        return self._ordered(waiting[np.r_[np.flatnonzero(agree), len(head) : len(waiting)]])

    def _ordered(self, track: AttitudeTrack) -> AttitudeTrack:
        """Attitudes of a track without those stamped before an earlier one."""
        ordered = in_order(track.stamps_ns, self.last_ns)
        self.leave_out(DISORDERED, track.stamps_ns[~ordered])
        known = [] if self.last_ns is None else [self.last_ns]
        stamps = np.array([*known, *track.stamps_ns[ordered][-2:]], dtype=np.int64)
        self._period_ns, self.last_ns = period_ns(stamps[-2:]), int(stamps[-1])
        return track[ordered]

    def _counted(self, track: AttitudeTrack, truth_ns: int) -> AttitudeTrack:
        """Keep the attitudes that can be used, within the duration, and return them."""
        stamps, finite = track.stamps_ns, np.isfinite(track.attitude_xyzw).all(axis=1)
        norms = quaternion.norm(np.where(finite[:, np.newaxis], track.attitude_xyzw, 0.0))
        usable = finite & (norms >= SMALLEST_NORM) & np.isfinite(norms)
        known = stamps[usable & (stamps >= truth_ns - LENIENCE_NS)]
        if usable.any() and not self._has_begun and (len(known) or self.first_ns is None):
            self.first_ns, self._has_begun = int((known if len(known) else stamps[usable])[0]), len(known) > 0
        due_ns = np.inf if self.due_ns is None else self.due_ns
        inside = stamps <= due_ns
        self.complete |= bool(np.any(stamps >= due_ns))
        self.leave_out(UNUSABLE_ATTITUDES, stamps[inside & ~usable])
        counted = track[inside & usable]
        self._blocks.append(counted[-self.count % self.stride :: self.stride])
        self._last = [counted[-1:]] if len(counted) else self._last
        self.count += len(counted)
        if sum(map(len, self._blocks)) > self._most or len(self._blocks) > MOST_ARRAYS:
            kept = AttitudeTrack.joined(self._blocks)
            while len(kept) > self._most:
                kept, self.stride = kept[np.arange(0, len(kept), 2)], 2 * self.stride
            self._blocks = [kept]
        return counted


class KeptBiases:
    """Finite biases of a gyro, evenly thinned so that memory does not grow.

    Parameters
    ----------
    most : int
        Largest number that are kept.

    Attributes
    ----------
    topic : str
        Empty until a message came.
    stamps_ns : ndarray of int64, shape (N,)
        As they came: perhaps not in order.
    values : ndarray, shape (N, 3)
        Biases, rad/s.
    """

    def __init__(self, most: int) -> None:
        self._most, self._count, self._left_out, self._stride = most, 0, 0, 1
        self.topic, self.stamps_ns, self.values = "", np.empty(0, dtype=np.int64), np.empty((0, 3))

    def hear(self, topic: str, message_type: str, payloads: Sequence[bytes]) -> None:
        """Take messages.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        self.take(topic, *vectors_of(message_type, payloads))

    def take(self, topic: str, stamps_ns: Integers, values: Array) -> None:
        """Take biases, rad/s, shape (N, 3), with their stamps."""
        self.topic = topic
        finite = np.flatnonzero(np.isfinite(values).all(axis=1))
        kept = finite[-self._count % self._stride :: self._stride]
        self._count += len(finite)
        self._left_out += len(values) - len(finite)
        self.stamps_ns = np.concatenate([self.stamps_ns, stamps_ns[kept]])
        self.values = np.concatenate([self.values, values[kept]])
        while len(self.values) > self._most:
            self.stamps_ns, self.values, self._stride = self.stamps_ns[::2], self.values[::2], 2 * self._stride

    @property
    def notes(self) -> list[str]:
        """What the reader of a score should know of them, one sentence each."""
        count = self._left_out
        told = f"{count} of {count + self._count} biases on {self.topic} are not finite, and are left out"
        return [f"{told}; find out why they were given."] * (count > 0)

    def between(self, first_ns: int, last_ns: int) -> tuple[Integers, Array]:
        """Stamps and biases from one stamp to another, ns, in their order."""
        order = np.argsort(self.stamps_ns, kind="stable")
        stamps_ns = self.stamps_ns[order]
        rows = slice(*np.searchsorted(stamps_ns, [first_ns, last_ns + 1]))
        return stamps_ns[rows], self.values[order][rows]

    def beside(self, truth: KeptBiases, first_ns: int, last_ns: int) -> BiasEstimate | None:
        """Biases from one stamp to another, ns, where the true ones are known; None where there are none.

        The true ones are linear between those that were heard, and constant for a second before and after them.
        """
        known_ns, known = truth.between(first_ns - LENIENCE_NS, last_ns + LENIENCE_NS)
        if not len(known):
            return None
        span = max(first_ns, int(known_ns[0]) - LENIENCE_NS), min(last_ns, int(known_ns[-1]) + LENIENCE_NS)
        stamps_ns, values = self.between(*span)
        return BiasEstimate(stamps_ns, values, linear(stamps_ns, known_ns, known)) if len(values) else None
