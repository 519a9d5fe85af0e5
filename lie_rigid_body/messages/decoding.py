"""Decoding of messages of either byte order: into arrays all messages of a topic at once, or those of two frames.

nav_msgs/Odometry, geometry_msgs/TransformStamped and tf2_msgs/TFMessage have two frames, and so no fixed places of
fields.
"""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Array, Integers, items
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages.layout import FRAME_OFFSET, numbers_after

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
    worst = int(np.argmax(nanosec >= NS))
    _require_nanosec(int(nanosec[worst]), int(indices[worst]))
    return sec * NS + nanosec


def _require_nanosec(nanosec: int, index: int) -> None:
    if nanosec >= NS:
        raise BagError(f"message {index} has a stamp of {nanosec} nanosec, not below 1e9")


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


def decode_framed(payloads: Iterable[bytes], numbers: int, *, counted: bool) -> dict[Frames, FramedNumbers]:
    """Read messages of a header, a child frame and so many numbers, or of a counted number of such parts.

    They are nav_msgs/Odometry and geometry_msgs/TransformStamped; or tf2_msgs/TFMessage.

    Raises
    ------
    BagError
        Naming the first message that is not such a payload.
    """
    found = defaultdict[Frames, FramedNumbers](FramedNumbers)
    for index, payload in enumerate(payloads):
        order = byte_order(payload, index)
        at = 8 if counted else 4
        for _ in range(_word(payload, 4, order, index) if counted else 1):
            frame, child_at = _framed_text(payload, at + 8, order, index)
            child, end = _framed_text(payload, child_at, order, index)
            of_frames = found[frame, child]
            sec, nanosec = struct.unpack_from(f"{order}iI", payload, at)
            _require_nanosec(nanosec, index)
            of_frames.stamps_ns.append(sec * NS + nanosec)
            of_frames.messages.append(index)
            begin = numbers_after(end)
            at = begin + 8 * numbers
            if at > len(payload):
                raise BagError(f"message {index} ends after {len(payload)} bytes, before its fields")
            of_frames.numbers.append(struct.unpack_from(f"{order}{numbers}d", payload, begin))
        _require_size(payload, at, index)
    return found


def _framed_text(payload: bytes, at: int, order: str, index: int) -> tuple[str, int]:
    """A text whose length stands at a byte, or behind the padding there, and the byte where it ends."""
    begin = -(-at // 4) * 4 + 4
    end = begin + _word(payload, begin - 4, order, index)
    return text_of(payload[begin:end], index), end
