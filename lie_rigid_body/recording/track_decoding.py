"""Decoding of the messages of a bag's topic, with errors that name bag and topic."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body import messages
from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE, ZSTD_MAGIC
from lie_rigid_body.recording.mcap_contents import RawMessages, RawTrack
from lie_rigid_body.wording import short_repr

_AT_ONCE: Final = 8192
"""Number of messages that are decoded at once: with all their fields they take many times what is kept of them."""
Kind: TypeAlias = tuple[str, bytes]
"""Parts that most messages of a topic share: the frame's name, empty without a header, and the bits of the float64
fields that are no values."""


@dataclass(frozen=True)
class TopicMessages:
    """Messages of a topic of float64 fields, in file order, with every field.

    Attributes
    ----------
    log_times_ns, stamps_ns : ndarray of int64, shape (N,)
    values : ndarray, shape (N, K)
        The fields that differ from message to message, one after the other.
    kinds : tuple of Kind
        What most messages have alike, once for each kind: name of the frame, and all other float64 fields in order.
    kind : ndarray of int64, shape (N,)
        Which of them each message has.
    """

    log_times_ns: Integers
    stamps_ns: Integers
    values: Array
    kinds: tuple[Kind, ...]
    kind: Integers

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.stamps_ns)

    @property
    def frame_ids(self) -> tuple[str, ...]:
        """The distinct names of frames, in order of appearance."""
        return tuple(dict.fromkeys(frame for frame, _ in self.kinds))

    def __getitem__(self, rows: slice | Integers | Booleans) -> TopicMessages:
        return TopicMessages(
            self.log_times_ns[rows], self.stamps_ns[rows], self.values[rows], self.kinds, self.kind[rows]
        )

    @classmethod
    def joined(cls, parts: Sequence[TopicMessages]) -> TopicMessages:
        """Messages that continue each other as one."""
        kinds = {kind: i for i, kind in enumerate(dict.fromkeys(kind for part in parts for kind in part.kinds))}
        own = [np.array([kinds[kind] for kind in part.kinds], dtype=np.int64) for part in parts]
        return cls(
            np.concatenate([part.log_times_ns for part in parts]),
            np.concatenate([part.stamps_ns for part in parts]),
            np.concatenate([part.values for part in parts]),
            tuple(kinds),
            np.concatenate([numbers[part.kind] for numbers, part in zip(own, parts, strict=True)]),
        )


@contextmanager
def named(path: Path, topic: str) -> Iterator[None]:
    """Context whose errors name the bag and the topic."""
    try:
        yield
    except BagError as error:
        raise BagError(f"{path}: topic {topic}: {error}: record the bag again") from None


def require_cdr(path: Path, track: RawTrack) -> None:
    """Refuse a topic whose messages are encoded otherwise."""
    if track.encoding != "cdr":
        raise BagError(f"{path}: topic {track.topic} is encoded as {track.encoding!r}: give one in cdr")


def taken(path: Path, track: RawTrack) -> RawMessages:
    """Messages of a topic, which the track then forgets.

    Raises
    ------
    BagError
        If they are not in CDR, or compressed one by one.
    """
    require_cdr(path, track)
    found = track.take()
    _require_unpacked(path, found)
    return found


def _require_unpacked(path: Path, found: RawMessages) -> None:
    if bytes(found.data[: len(ZSTD_MAGIC)]) == ZSTD_MAGIC:
        raise BagError(f"{path}: {COMPRESSED_ONE_BY_ONE}")


def texts(path: Path, topic: str, pieces: Iterable[RawMessages]) -> Iterator[tuple[int, str]]:
    """Log time, ns, and text of each std_msgs/String of a topic, as they come."""
    numbers = count()
    for piece in pieces:
        _require_unpacked(path, piece)
        with named(path, topic):
            found = [(time, messages.decode_string(payload, next(numbers))) for time, payload in piece.payloads()]
        yield from found


def columns(found: RawMessages, numbers: int, *, stamped: bool, first: int = 0) -> Decoded:
    """Contents of messages, the first of which has a number; see `messages.decode_places`."""
    ends = np.cumsum(found.sizes)
    return messages.decode_places(found.data, ends - found.sizes, ends, numbers, stamped=stamped, first=first)


def topic_messages(
    path: Path, topic: str, found: RawMessages, varying: Booleans, stamped: bool, first: int
) -> TopicMessages:
    """Decode messages of a topic, the first of which has a number.

    Parameters
    ----------
    path, topic : Path and str
        Names for errors.
    found : RawMessages
    varying : ndarray of bool, shape (numbers,)
        Which of the float64 fields of a message are its values; the others are part of its kind.
    stamped : bool
        Whether a std_msgs/Header comes first.
    first : int
    """
    _require_unpacked(path, found)
    parts = []
    for some in found.pieces(_AT_ONCE):
        parts.append(_topic_messages(path, topic, some, varying, stamped, first))
        first += len(some)
    return parts[0] if len(parts) == 1 else TopicMessages.joined(parts)


def _topic_messages(
    path: Path, topic: str, found: RawMessages, varying: Booleans, stamped: bool, first: int
) -> TopicMessages:
    with named(path, topic):
        decoded = columns(found, len(varying), stamped=stamped, first=first)
    log_times = found.log_times_ns
    stamps = np.zeros(len(log_times), dtype=np.int64) if decoded.stamps_ns is None else decoded.stamps_ns
    if varying.all():
        kinds = tuple((frame, b"") for frame in (decoded.frame_ids if stamped else ("",)))
        return TopicMessages(log_times, stamps, decoded.numbers, kinds, decoded.frames)
    values, rest = (np.compress(fields, decoded.numbers, axis=1) for fields in (varying, ~varying))
    return TopicMessages(log_times, stamps, values, *_kinds(decoded, rest))


def _kinds(decoded: Decoded, rest: Array) -> tuple[tuple[Kind, ...], Integers]:
    """Kinds of messages, by frame and the fields that are no values, and which of them each message is."""
    keys = np.column_stack([decoded.frames, rest.view(np.int64)])
    if not len(keys) or (keys == keys[0]).all():
        distinct, kind = keys[:1], np.zeros(len(keys), dtype=np.int64)
    else:
        whole = np.ascontiguousarray(keys).view(f"V{keys.itemsize * keys.shape[1]}")[:, 0]
        _, first, kind = np.unique(whole, return_index=True, return_inverse=True)
        distinct = keys[first]
    return tuple((decoded.frame_ids[int(key[0])], key[1:].tobytes()) for key in distinct), kind
