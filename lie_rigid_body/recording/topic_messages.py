"""Messages of a bag's topics as arrays: one decoder for those of float64 fields, one for texts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body import messages
from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.definitions import POSE_STAMPED, TWIST, TWIST_STAMPED, places
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE, ZSTD_MAGIC
from lie_rigid_body.recording.mcap_contents import RawMessages, RawTrack, TrackKey
from lie_rigid_body.sensors import SENSORS, Field, Topic
from lie_rigid_body.wording import short_repr

TRUE_TYPES: Final = (POSE_STAMPED, TWIST_STAMPED, TWIST)
"""Types of the poses and twists of a body: three numbers of its translation, and then those of its rotation."""
_AT_ONCE: Final = 8192
"""Number of messages that are decoded at once: with all their fields they take many times what is kept of them."""
Kind: TypeAlias = tuple[str | None, bytes]
"""Parts that most messages of a topic share: the frame's name, None without a header, and the bits of the float64
fields that are no values."""


@dataclass(frozen=True)
class TopicMessages:
    """Messages of a topic of float64 fields, in file order, with every field.

    Attributes
    ----------
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,)
        Stamps of the headers; of messages without one the log times.
    values : ndarray, shape (N, K)
        The fields that differ from message to message, one after the other; see `varying_fields`. As recorded: perhaps
        not finite.
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
        """The distinct names of frames."""
        return tuple(dict.fromkeys(frame for frame, _ in self.kinds if frame is not None))

    def __getitem__(self, rows: slice | Integers | Booleans) -> TopicMessages:
        return TopicMessages(
            self.log_times_ns[rows], self.stamps_ns[rows], self.values[rows], self.kinds, self.kind[rows]
        )

    @classmethod
    def joined(cls, parts: Sequence[TopicMessages]) -> TopicMessages:
        """Messages that continue each other as one."""
        if len(parts) == 1:
            return parts[0]
        kinds = {kind: i for i, kind in enumerate(dict.fromkeys(kind for part in parts for kind in part.kinds))}
        own = [np.array([kinds[kind] for kind in part.kinds], dtype=np.int64) for part in parts]
        return cls(
            np.concatenate([part.log_times_ns for part in parts]),
            np.concatenate([part.stamps_ns for part in parts]),
            np.concatenate([part.values for part in parts]),
            tuple(kinds),
            np.concatenate([numbers[part.kind] for numbers, part in zip(own, parts, strict=True)]),
        )

    @classmethod
    def none_of(cls, message_type: str) -> TopicMessages:
        """Messages of a topic of which there is none."""
        none, width = np.empty(0, dtype=np.int64), np.count_nonzero(varying_fields(message_type))
        return cls(none, none, np.empty((0, width)), (), none)


@dataclass(frozen=True)
class FaultMessages:
    """Messages of the topic of faults, in file order.

    Attributes
    ----------
    log_times_ns : ndarray of int64, shape (N,)
    texts : tuple of str
    """

    log_times_ns: Integers
    texts: tuple[str, ...]

    __repr__ = short_repr

    @classmethod
    def of(cls, found: Sequence[tuple[int, str]]) -> FaultMessages:
        """Make them of pairs of log time, ns, and text."""
        return cls(np.array([time for time, _ in found], dtype=np.int64), tuple(text for _, text in found))


OfSensor: TypeAlias = TopicMessages | FaultMessages
TakeReadings: TypeAlias = Callable[[Mapping[str, OfSensor]], object]
"""Function that takes messages of sensors, and about their faults, by relative topic names."""


@contextmanager
def decoding(path: Path, topic: str, found: RawMessages) -> Iterator[None]:
    """Context in which messages are decoded, whose errors name the bag and the topic.

    Raises
    ------
    BagError
        If one cannot be decoded, or they are compressed one by one.
    """
    if bytes(found.data[: len(ZSTD_MAGIC)]) == ZSTD_MAGIC:
        raise BagError(f"{path}: {COMPRESSED_ONE_BY_ONE}")
    try:
        yield
    except BagError as error:
        raise BagError(f"{path}: topic {topic}: {error}: record the bag again") from None


def require_cdr(path: Path, track: RawTrack) -> None:
    """Refuse a topic whose messages are encoded otherwise."""
    if track.encoding != "cdr":
        raise BagError(f"{path}: topic {track.topic} is encoded as {track.encoding!r}: give one in cdr")


def texts(path: Path, topic: str, pieces: Iterable[RawMessages]) -> Iterator[tuple[int, str]]:
    """Log time, ns, and text of each std_msgs/String of a topic, as they come."""
    numbers = count()
    for piece in pieces:
        with decoding(path, topic, piece):
            found = [(time, messages.decode_string(payload, next(numbers))) for time, payload in piece.payloads()]
        yield from found


def topic_messages(path: Path, key: TrackKey, found: RawMessages, first: int = 0) -> TopicMessages:
    """Decode messages of a topic, the first of which has a number, for errors."""
    parts = []
    for some in found.pieces(_AT_ONCE):
        parts.append(_decoded(path, *key, some, first))
        first += len(some)
    return TopicMessages.joined(parts)


def _decoded(path: Path, topic: str, message_type: str, found: RawMessages, first: int) -> TopicMessages:
    varying, ends = varying_fields(message_type), np.cumsum(found.sizes)
    with decoding(path, topic, found):
        decoded = messages.decode_places(
            found.data, ends - found.sizes, ends, len(varying), stamped=message_type != TWIST, first=first
        )
    stamps, frame_ids = decoded.stamps_ns, decoded.frame_ids or (None,)
    values, rest = (np.compress(fields, decoded.numbers, axis=1) for fields in (varying, ~varying))
    keys = np.column_stack([decoded.frames, rest.view(np.int64)])
    distinct, kind = keys[:1], np.zeros(len(keys), dtype=np.int64)
    if (keys != distinct).any():
        whole = np.ascontiguousarray(keys).view(f"V{keys.itemsize * keys.shape[1]}")[:, 0]
        _, at, kind = np.unique(whole, return_index=True, return_inverse=True)
        distinct = keys[at]
    kinds = tuple((frame_ids[int(row[0])], row[1:].tobytes()) for row in distinct)
    return TopicMessages(found.log_times_ns, found.log_times_ns if stamps is None else stamps, values, kinds, kind)


def varying_fields(message_type: str) -> Booleans:
    """Mask of the float64 numbers of a type that are values of its messages, shape (K,).

    They are those that differ between messages on any topic of a sensor; of the types of the truth they are all.
    """
    numbers = np.full(len(places(message_type)[""]), message_type in TRUE_TYPES)
    for sensor in SENSORS.values():
        for topic in sensor.topics:
            for field in topic.fields if topic.message_type == message_type else ():
                numbers[list(messages.numbers_of(topic, field))] = True
    return numbers


def value_columns(topic: Topic, field: Field) -> Integers:
    """Columns of a field among the values of the `TopicMessages` of a topic."""
    varying = np.flatnonzero(varying_fields(topic.message_type))
    return np.asarray(np.searchsorted(varying, messages.numbers_of(topic, field)), dtype=np.int64)


def fixed_number(found: TopicMessages, message_type: str, number: int) -> Array:
    """Float64 number of each message that is no value of it, shape (N,)."""
    place = int(np.count_nonzero(~varying_fields(message_type)[:number]))
    fixed = np.array([np.frombuffer(bits)[place] for _, bits in found.kinds], dtype=np.float64)
    return np.asarray(fixed[found.kind])
