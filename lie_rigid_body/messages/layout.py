"""The layout of messages in CDR: the fields that all share, and the bytes of messages of one type."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, overload

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.parameters import NS
from lie_rigid_body.wording import short_repr

ENCAPSULATION: Final = b"\x00\x01\x00\x00"
FRAME: Final = 16
"""Byte of a payload where the frame name of its header begins: after the encapsulation, the stamp and its length."""

POSE_NUMBERS: Final = 7
"""float64 fields of a pose: position x y z, orientation x y z w."""
TWIST_NUMBERS: Final = 6
"""float64 fields of a twist: linear x y z, angular x y z."""


def numbers_after(end: int) -> int:
    """Where float64 numbers begin in a payload whose fields before them end at byte ``end``."""
    return 4 + -(-(end - 4) // 8) * 8


def text(value: str) -> bytes:
    """A string: its length with the closing zero byte, and its bytes."""
    data = value.encode()
    return struct.pack("<I", len(data) + 1) + data + b"\x00"


@dataclass(frozen=True, eq=False)
class Payloads(Sequence[bytes]):
    """Messages of one size, which lie side by side.

    Parameters
    ----------
    rows : ndarray of uint8, shape (N, size)
    """

    rows: NDArray[np.uint8]

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> bytes: ...

    @overload
    def __getitem__(self, index: slice) -> Payloads: ...

    def __getitem__(self, index: int | slice) -> bytes | Payloads:
        return Payloads(self.rows[index]) if isinstance(index, slice) else self.rows[index].tobytes()

    def __iter__(self) -> Iterator[bytes]:
        data, size = self.rows.tobytes(), self.rows.shape[1]
        return (data[i : i + size] for i in range(0, len(data), size))


class Layout:
    """The bytes of a message type: a template, and the places of the fields that samples set.

    Parameters
    ----------
    frame : str or None
        Frame name of its header; None: it has no header.
    numbers : sequence of float
        Its float64 fields in order.
    places : sequence of (int, int)
        Which of them each sample sets: where a vector begins among the numbers, and its length.
    """

    def __init__(self, frame: str | None, numbers: Sequence[float], places: Sequence[tuple[int, int]]) -> None:
        head = ENCAPSULATION if frame is None else ENCAPSULATION + bytes(8) + text(frame)
        start = numbers_after(len(head))
        template = head.ljust(start, b"\x00") + struct.pack(f"<{len(numbers)}d", *numbers)
        self._template = np.frombuffer(template, dtype=np.uint8)
        self._size = len(template)
        self._stamped = frame is not None
        self._vectors = [f"vector_{i}" for i in range(len(places))]
        # without a header the stamp's bytes are numbers, and are left alone
        self._fields = np.dtype(
            {
                "names": ["sec", "nanosec", *self._vectors],
                "formats": ["<i4", "<u4", *(("<f8", (length,)) for _, length in places)],
                "offsets": [4, 8, *(start + 8 * first for first, _ in places)],
                "itemsize": self._size,
            }
        )

    def encode(self, stamps_ns: Integers, *vectors: Array) -> Payloads:
        """One payload a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        *vectors : ndarray, shape (N, length)
            One for each of the places.

        Returns
        -------
        Payloads
        """
        data = np.empty((len(stamps_ns), self._size), dtype=np.uint8)
        data[:] = self._template
        rows = data.view(self._fields)[:, 0]
        if self._stamped:
            rows["sec"], rows["nanosec"] = np.divmod(stamps_ns, NS)
        for name, values in zip(self._vectors, vectors, strict=True):
            rows[name] = values
        return Payloads(data)
