"""Decoding of nav_msgs/Odometry and tf2_msgs/TFMessage, which have two frames and so no fixed places of fields."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from lie_rigid_body.bounded_input import LONGEST_NAME
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.decoding import byte_order, text_of
from lie_rigid_body.messages.layout import numbers_after
from lie_rigid_body.parameters import NS

_ODOMETRY_NUMBERS: Final = 7 + 36 + 6 + 36
"""float64 fields of an Odometry: pose and its covariance, twist and its covariance."""
_TRANSFORM_NUMBERS: Final = 7
"""float64 fields of a transform: translation x y z, rotation x y z w."""
_SPARE: Final = 8
"""Bytes by which a middleware may pad the end of a message, and one more."""

Frames = tuple[str, str]
"""Frame of the header, and child frame."""


@dataclass
class FramedNumbers:
    """The numbers of all messages of the same two frames.

    Attributes
    ----------
    stamps_ns : list of int
    numbers : list of tuple of float
        float64 fields of each message in order: position or translation x y z, attitude x y z w, and what follows.
    """

    stamps_ns: list[int] = field(default_factory=list)
    numbers: list[tuple[float, ...]] = field(default_factory=list)


def decode_odometry(payloads: Sequence[bytes]) -> dict[Frames, FramedNumbers]:
    """Read nav_msgs/Odometry, by frame and child frame.

    Raises
    ------
    BagError
        Naming the first message that is not such a payload.
    """
    return _decoded(payloads, lambda fields: 1, _ODOMETRY_NUMBERS)


def decode_transforms(payloads: Sequence[bytes]) -> dict[Frames, FramedNumbers]:
    """Read tf2_msgs/TFMessage, by frame and child frame; see `decode_odometry`."""
    return _decoded(payloads, _Fields.word, _TRANSFORM_NUMBERS)


def _decoded(payloads: Sequence[bytes], count: Callable[[_Fields], int], numbers: int) -> dict[Frames, FramedNumbers]:
    """Read messages of ``count(fields)`` parts, each of a header, a child frame and so many numbers."""
    found: dict[Frames, FramedNumbers] = {}
    for index, payload in enumerate(payloads):
        fields = _Fields(payload, index)
        for _ in range(count(fields)):
            fields.read(found, numbers)
        fields.end()
    return found


class _Fields:
    """The fields of one payload, read in order."""

    def __init__(self, payload: bytes, index: int) -> None:
        self._payload, self._index, self._at = payload, index, 4
        self._order = byte_order(payload, index)

    def read(self, found: dict[Frames, FramedNumbers], count: int) -> None:
        """Read a header, a child frame and so many numbers."""
        sec, nanosec = self.word("i"), self.word()
        if nanosec >= NS:
            raise BagError(f"message {self._index} has a stamp of {nanosec} nanosec, not below 1e9")
        frames = (self._text(), self._text())
        of_frames = found.setdefault(frames, FramedNumbers())
        of_frames.stamps_ns.append(sec * NS + nanosec)
        self._at = numbers_after(self._at)
        of_frames.numbers.append(self._unpack(f"{count}d"))

    def word(self, kind: str = "I") -> int:
        self._at = -(-self._at // 4) * 4
        value: int = self._unpack(kind)[0]
        return value

    def _text(self) -> str:
        length = self.word()
        if length > LONGEST_NAME:
            raise BagError(f"message {self._index} has a frame of {length} bytes: at most {LONGEST_NAME} are read")
        return text_of(self._unpack(f"{length}s")[0], self._index)

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
