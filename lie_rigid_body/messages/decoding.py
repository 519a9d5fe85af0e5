"""Decoding of messages of either byte order: into arrays all messages of a topic at once, or those of two frames.

nav_msgs/Odometry, geometry_msgs/TransformStamped and tf2_msgs/TFMessage have two frames, and so no fixed places of
fields.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Array, Integers, items
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages.layout import FRAME_OFFSET, POSE_NUMBERS, TWIST_NUMBERS, numbers_after

Bytes: TypeAlias = NDArray[np.uint8]
"""Rows of bytes, one payload in each, shape (N, size)."""
Frames: TypeAlias = tuple[str, str]
"""Frame of the header, and child frame."""

_BYTE_ORDERS: Final = {b"\x00\x00": ">", b"\x00\x01": "<"}
"""Byte order, as `struct` names it, by the first two bytes of plain CDR."""
_SPARE: Final = 8
"""Bytes by which a middleware may pad the end of a message, to a multiple of 4 or 8, and one more."""


@short_dataclass
class Decoded:
    """Messages of one type.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,), or None
        Stamps of the headers, ns; None for messages without a header.
    numbers : ndarray, shape (N, K)
        float64 fields of each message, in order.
    frame_ids : tuple of str
        The distinct frame names, in order of appearance.
    frames : ndarray of int64, shape (N,)
        Number of the frame name that each message has; zeros for messages without a header.
    """

    stamps_ns: Integers | None
    numbers: Array
    frame_ids: tuple[str, ...]
    frames: Integers


def decode_places(
    data: bytes | memoryview, starts: Integers, ends: Integers, numbers: int, *, stamped: bool, first: int = 0
) -> Decoded:
    """Read messages of float64 numbers, of either byte order, from the bytes that contain them.

    Parameters
    ----------
    data : bytes
    starts, ends : ndarray of int64, shape (N,)
        Bytes of ``data`` at which each payload begins and ends.
    numbers : int
        Number of float64 fields of a message.
    stamped : bool
        Whether a std_msgs/Header comes first.
    first : int, optional
        Number of the first message, for errors.

    Returns
    -------
    Decoded

    Raises
    ------
    BagError
        Naming a message that is not such a payload.
    """
    shortest = int(np.argmin(ends - starts)) if len(starts) else 0
    if len(starts) and ends[shortest] - starts[shortest] < 2:  # the encapsulation, which tells the layout
        byte_order(bytes(data[starts[shortest] : ends[shortest]]), first + shortest)  # which refuses it
    stamps = np.zeros(len(starts), dtype=np.int64)
    values = np.empty((len(starts), numbers))
    names = np.full(len(starts), "", dtype=np.object_)
    for indices, rows in _of_one_size(data, starts, ends - starts):
        for alike in _alike(rows, stamped=stamped):
            _decode_alike(rows[alike], indices[alike], first, stamped, stamps, values, names)
    if not stamped:
        return Decoded(None, values, (), np.zeros(len(starts), dtype=np.int64))
    numbers_of = {name: number for number, name in enumerate(dict.fromkeys(names.tolist()))}
    return Decoded(stamps, values, tuple(numbers_of), np.fromiter(map(numbers_of.__getitem__, names), dtype=np.int64))


def _of_one_size(data: bytes | memoryview, starts: Integers, sizes: Integers) -> Iterator[tuple[Integers, Bytes]]:
    """Group payloads by their sizes; those that follow each other are not copied."""
    indices = np.arange(len(starts))
    if len(starts) and (sizes == sizes[0]).all() and (np.diff(starts) == sizes[0]).all():
        size = int(sizes[0])
        yield indices, np.frombuffer(data, np.uint8, len(starts) * size, int(starts[0])).reshape(-1, size)
        return
    for size in np.unique(sizes).tolist():
        own = indices[sizes == size]
        yield own, items(data, starts[own], size).view(np.uint8).reshape(-1, size)


def _alike(rows: Bytes, *, stamped: bool) -> list[Integers | slice]:
    """Group rows of one size by what determines their layout: the encapsulation and the length of the frame name."""
    keys = _column(rows, 0, 2, "u2")[:, 0].astype(np.int64)
    if stamped and rows.shape[1] >= FRAME_OFFSET:
        keys += _column(rows, 12, 4, "u4")[:, 0].astype(np.int64) << 16
    if (keys == keys[0]).all():
        return [slice(None)]
    _, group = np.unique(keys, return_inverse=True)
    return [np.flatnonzero(group == i) for i in range(int(group.max()) + 1)]


def _decode_alike(
    rows: Bytes,
    indices: Integers,
    first: int,
    stamped: bool,
    stamps: Integers,
    values: Array,
    names: NDArray[np.object_],
) -> None:
    head = rows[0].tobytes()
    at = int(indices[0])
    order = byte_order(head, first + at)
    length = _word(head, 12, order, first + at) if stamped else 0
    start = numbers_after(FRAME_OFFSET + length) if stamped else 4
    count = values.shape[1]
    _require_size(head, start + 8 * count, first + at)
    values[indices] = _column(rows, start, 8 * count, f"{order}f8")
    if stamped:
        stamps[indices] = _stamps(rows, order, first + indices)
        texts = rows[:, FRAME_OFFSET : FRAME_OFFSET + length]
        distinct = texts[:1] if (texts == texts[:1]).all() else texts
        names[indices] = [
            text_of(each.tobytes(), first + i) for each, i in zip(distinct, indices.tolist(), strict=False)
        ]


def _column(rows: Bytes, start: int, size: int, kind: str) -> NDArray[np.generic]:
    return rows[:, start : start + size].view(kind)


def _stamps(rows: Bytes, order: str, indices: Integers) -> Integers:
    sec = _column(rows, 4, 4, f"{order}i4")[:, 0].astype(np.int64)
    nanosec = _column(rows, 8, 4, f"{order}u4")[:, 0].astype(np.int64)
    if (nanosec >= NS).any():
        worst = int(np.argmax(nanosec >= NS))
        raise BagError(f"message {indices[worst]} has a stamp of {nanosec[worst]} nanosec, not below 1e9")
    return sec * NS + nanosec


def decode_string(payload: bytes, index: int = 0) -> str:
    """Read a std_msgs/String.

    Parameters
    ----------
    payload : bytes
    index : int
        Number of the message, for the error.

    Raises
    ------
    BagError
        If the payload is not one.
    """
    length = _word(payload, 4, byte_order(payload, index), index)
    _require_size(payload, 8 + length, index)
    return text_of(payload[8 : 8 + length], index)


def byte_order(payload: bytes, index: int) -> str:
    """Byte order that the encapsulation of a message tells, as `struct` names it: ``<`` or ``>``."""
    order = _BYTE_ORDERS.get(payload[:2])
    if order is None:
        begin = payload[:4].hex(" ") or "nothing"
        raise BagError(f"message {index} begins with {begin}, which is not plain CDR (00 00 or 00 01)")
    return order


def _word(payload: bytes, at: int, order: str, index: int) -> int:
    if len(payload) < at + 4:
        raise BagError(f"message {index} ends after {len(payload)} bytes, before its text")
    return int(struct.unpack_from(f"{order}I", payload, at)[0])


def _require_size(payload: bytes, size: int, index: int) -> None:
    if not size <= len(payload) < size + _SPARE:
        raise BagError(f"message {index} has {len(payload)} bytes where its type and text lengths make {size}")


def text_of(data: bytes, index: int) -> str:
    """Decode the bytes of a string, which end with a zero byte."""
    if data and data[-1]:
        raise BagError(f"message {index} has a text that does not end with a zero byte")
    try:
        return data[:-1].decode()
    except UnicodeDecodeError:
        raise BagError(f"message {index} has a text that is not UTF-8") from None


@dataclass
class FramedNumbers:
    """The numbers of all messages of the same two frames.

    Attributes
    ----------
    stamps_ns : list of int
    messages : list of int
        Index of the message that each is from.
    numbers : list of tuple of float
        float64 fields of each message in order: position or translation x y z, attitude x y z w, and what follows.
    """

    stamps_ns: list[int] = field(default_factory=list)
    messages: list[int] = field(default_factory=list)
    numbers: list[Vector] = field(default_factory=list)


def _decoded(payloads: Sequence[bytes], numbers: int, *, counted: bool = False) -> dict[Frames, FramedNumbers]:
    """Read messages of a header, a child frame and so many numbers, or of a counted number of such parts.

    Raises
    ------
    BagError
        Naming the first message that is not such a payload.
    """
    found: dict[Frames, FramedNumbers] = {}
    for index, payload in enumerate(payloads):
        fields = _Fields(payload, index)
        for _ in range(fields.word() if counted else 1):
            fields.read(found, numbers)
        fields.end()
    return found


# pose and its covariance, twist and its covariance
decode_odometry: Final = partial(_decoded, numbers=POSE_NUMBERS + 36 + TWIST_NUMBERS + 36)
"""A function that reads nav_msgs/Odometry, by frame and child frame."""
decode_transform: Final = partial(_decoded, numbers=POSE_NUMBERS)
"""A function that reads geometry_msgs/TransformStamped, by frame and child frame."""
decode_transforms: Final = partial(_decoded, numbers=POSE_NUMBERS, counted=True)
"""A function that reads tf2_msgs/TFMessage, by frame and child frame."""


class _Fields:
    """The fields of one payload, read in order."""

    def __init__(self, payload: bytes, index: int) -> None:
        self._payload = payload
        self._index = index
        self._at = 4
        self._order = byte_order(payload, index)

    def read(self, found: dict[Frames, FramedNumbers], count: int) -> None:
        """Read a header, a child frame and so many numbers."""
        sec = self.word("i")
        nanosec = self.word()
        if nanosec >= NS:
            raise BagError(f"message {self._index} has a stamp of {nanosec} nanosec, not below 1e9")
        frames = (self._text(), self._text())
        of_frames = found.setdefault(frames, FramedNumbers())
        of_frames.stamps_ns.append(sec * NS + nanosec)
        of_frames.messages.append(self._index)
        self._at = numbers_after(self._at)
        of_frames.numbers.append(self._unpack(f"{count}d"))

    def word(self, kind: str = "I") -> int:
        self._at = -(-self._at // 4) * 4
        return int(self._unpack(kind)[0])

    def _text(self) -> str:
        return text_of(self._unpack(f"{self.word()}s")[0], self._index)

    def _unpack(self, what: str) -> tuple:  # type: ignore[type-arg]
        try:
            values = struct.unpack_from(f"{self._order}{what}", self._payload, self._at)
        except struct.error:
            raise BagError(f"message {self._index} ends after {len(self._payload)} bytes, before its fields") from None
        self._at += struct.calcsize(f"{self._order}{what}")
        return values

    def end(self) -> None:
        """Refuse bytes beyond the last field."""
        if len(self._payload) >= self._at + _SPARE:
            raise BagError(f"message {self._index} has {len(self._payload)} bytes where its fields end at {self._at}")
