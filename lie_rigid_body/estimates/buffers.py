"""Attitudes and biases of topics, kept whole as they come, and which of them a score can use."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.arguments import MIN_NORM
from lie_rigid_body.evaluation.attitudes import in_order, rising
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, linear
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.decoding import Frames
from lie_rigid_body.recording.topic_messages import AttitudeTrack, vectors_of

MAX_SAMPLES: Final = 20_000_000
"""Largest number of attitudes of a topic, 40 bytes each, that a live score takes: two days at 100 Hz."""
MAX_BLOCKS: Final = 2000
"""Largest number of arrays of attitudes before they are joined."""
MAX_FRAMES: Final = 20
"""Largest number of pairs of frames of one topic that are told apart, beside the one that is wanted."""
MIN_OF_FRAMES: Final = 3
"""Number of attitudes of a pair of frames from which on they are compared: fewer may be one wrong message."""

UNUSABLE: Final = "unusable"
DISORDERED: Final = "disordered"
OF_OTHERS: Final = "of_others"
_SENTENCES: Final = {
    UNUSABLE: "{which} are not finite, or zero{first}, and are left out: find out why they were given",
    DISORDERED: "{which} are out of the order of time{first}, and are left out: let one node publish them, whose time "
    "never jumps",
    OF_OTHERS: "{which} are of other frames{first}, and are left out: let one node publish one body",
}
"""Sentences, without a full stop, for each reason why attitudes are left out."""


def left_out_sentence(reason: str, which: str, stamps_ns: Sequence[int] | Integers = ()) -> str:
    """Sentence, without a full stop, that says why attitudes are left out.

    Parameters
    ----------
    reason : str
        `UNUSABLE`, `DISORDERED` or `OF_OTHERS`.
    which : str
        Their name, perhaps with their number.
    stamps_ns : sequence of int, optional
        Their stamps, ns.
    """
    first = f", the first stamped {stamps_ns[0] / NS:.13g} s" if len(stamps_ns) else ""
    return _SENTENCES[reason].format(which=which, first=first)


def usable(track: AttitudeTrack | Estimate) -> Booleans:
    """Mask of the attitudes that are finite and not zero."""
    finite = np.isfinite(track.attitude_xyzw).all(axis=1)
    norms = quaternion.norm(np.where(finite[:, np.newaxis], track.attitude_xyzw, 0.0))
    return np.asarray(finite & (norms >= MIN_NORM) & np.isfinite(norms))


def scorable(track: AttitudeTrack) -> tuple[AttitudeTrack, dict[str, Integers]]:
    """Attitudes that a score can use, in order of time, and the stamps of the others, ns, by the reason."""
    good = usable(track)
    found = track[good]
    ordered = rising(found.stamps_ns)
    return found[ordered], {UNUSABLE: track.stamps_ns[~good], DISORDERED: found.stamps_ns[~ordered]}


def notes_on_left_out(left_out: Mapping[str, Integers], kept: int, name: str) -> list[str]:
    """Sentences, without a full stop, for the reader of a score about the attitudes that are left out.

    Parameters
    ----------
    left_out : mapping of str to ndarray of int64
        Their stamps, ns, by the reason.
    kept : int
        Number of those that are not.
    name : str
        Their name, such as ``estimates``.
    """
    whole = kept + sum(map(len, left_out.values()))
    return [
        left_out_sentence(reason, f"{len(stamps)} of {whole} {name}", stamps)
        for reason, stamps in left_out.items()
        if len(stamps)
    ]


class AttitudeBuffer:
    """Attitudes of a topic as they come, of which those of one body are compared.

    It is the body of the frames that are wanted, or else of those that most attitudes have.

    Attributes
    ----------
    frames : Counter of tuple of str
        Numbers of attitudes by their frame and child frame.
    wanted : tuple of str or None
        Frame and child frame that are wanted, where they are known.
    first_ns, last_ns : int or None
        Smallest and largest stamp of those that were taken.
    faults : set of str
        Reasons why some are left out, so far.
    """

    def __init__(self) -> None:
        self.frames = Counter[Frames]()
        self.wanted: Frames | None = None
        self.first_ns: int | None = None
        self.last_ns: int | None = None
        self.faults: set[str] = set()
        self._new = defaultdict[Frames, list[AttitudeTrack]](list)
        self._taken = defaultdict[Frames, list[AttitudeTrack]](list)

    @property
    def followed(self) -> Frames | None:
        """Frame and child frame of the attitudes that are compared; None before any came."""
        return self.wanted or max(self.frames, key=self.frames.__getitem__, default=None)

    @property
    def count(self) -> int:
        """Number of attitudes of these frames."""
        return self.frames[self.followed] if self.followed else 0

    def add(self, found: Mapping[Frames, AttitudeTrack]) -> None:
        """Keep attitudes that have come, by frame and child frame."""
        for frames, track in found.items():
            if frames in self.frames or frames == self.wanted or len(self.frames) < MAX_FRAMES:
                self.frames[frames] += len(track)
                self._new[frames].append(track)

    def take(self) -> list[AttitudeTrack]:
        """Return the attitudes of the body that were not taken before."""
        frames = self.followed
        if frames is None or (self.wanted is None and self.frames[frames] < MIN_OF_FRAMES):
            return []
        new = [track for track in self._new.pop(frames, []) if len(track)]
        for track in new:
            if not in_order(track.stamps_ns, self.last_ns).all():
                self.faults.add(DISORDERED)
            if not usable(track).all():
                self.faults.add(UNUSABLE)
            stamps = [each for each in (self.first_ns, self.last_ns) if each is not None] + track.stamps_ns.tolist()
            self.first_ns = min(stamps)
            self.last_ns = max(stamps)
        if self.wanted is None and len(self.frames) > 1:
            self.faults.add(OF_OTHERS)
        kept = self._taken[frames]
        kept += new
        if len(kept) > MAX_BLOCKS:
            self._taken[frames] = [AttitudeTrack.joined(kept)]
        return new

    def scorable(self) -> tuple[AttitudeTrack, dict[str, Integers]]:
        """Attitudes of the body that a score can use, and the stamps of the others; of at least one that came."""
        of_frames = {frames: [*self._taken[frames], *self._new[frames]] for frames in self.frames}
        own = self.followed or ("", "")
        found, left_out = scorable(AttitudeTrack.joined(of_frames[own]))
        if self.wanted is None:
            others = [track.stamps_ns for frames, tracks in of_frames.items() if frames != own for track in tracks]
            left_out[OF_OTHERS] = np.concatenate([found.stamps_ns[:0], *others])
        self.faults |= {reason for reason, stamps in left_out.items() if len(stamps)}
        return found, left_out


class BiasBuffer:
    """Biases of a gyro as they come.

    Attributes
    ----------
    topic : str
        Empty until a message came.
    """

    def __init__(self) -> None:
        self.topic = ""
        self._stamps_ns: list[Integers] = [np.empty(0, dtype=np.int64)]
        self._values: list[Array] = [np.empty((0, 3))]

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
        self._stamps_ns.append(stamps_ns)
        self._values.append(values)
        if len(self._values) > MAX_BLOCKS:
            self._stamps_ns = [np.concatenate(self._stamps_ns)]
            self._values = [np.concatenate(self._values)]

    def finite(self) -> tuple[Integers, Array]:
        """Stamps, ns, and biases, rad/s, that are finite, in order of time."""
        stamps_ns = np.concatenate(self._stamps_ns)
        values = np.concatenate(self._values)
        order = np.argsort(stamps_ns, kind="stable")
        order = order[np.isfinite(values[order]).all(axis=1)]
        return stamps_ns[order], values[order]

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader of a score."""
        count = sum(map(len, self._values))
        lost = count - len(self.finite()[0])
        told = (
            f"{lost} of {count} biases on {self.topic} are not finite, and are left out: find out why they were given."
        )
        return [told] if lost else []

    def between(self, first_ns: int, last_ns: int) -> tuple[Integers, Array]:
        """Stamps and biases from one stamp to another, ns."""
        stamps_ns, values = self.finite()
        rows = slice(*np.searchsorted(stamps_ns, [first_ns, last_ns + 1]))
        return stamps_ns[rows], values[rows]

    def beside(self, truth: BiasBuffer, first_ns: int, last_ns: int) -> BiasEstimate | None:
        """Biases from one stamp to another, ns, where the true ones are known; None where there are none.

        The true ones are linear between those that were heard, and constant for a second before and after them.
        """
        known_ns, known = truth.between(first_ns - NS, last_ns + NS)
        if not len(known):
            return None
        stamps_ns, values = self.between(max(first_ns, int(known_ns[0]) - NS), min(last_ns, int(known_ns[-1]) + NS))
        return BiasEstimate(stamps_ns, values, linear(stamps_ns, known_ns, known)) if len(values) else None
