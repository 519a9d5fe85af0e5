"""Transforms between frames, one a message."""

from __future__ import annotations

import struct
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.messages.layout import ENCAPSULATION, numbers_after, text
from lie_rigid_body.parameters import NS

_ONE: Final = struct.pack("<I", 1)
_TRANSLATION: Final = 3


class TransformEncoder:
    """Attitudes as tf2_msgs/TFMessage, each with one transform and no translation.

    Parameters
    ----------
    frame, child_frame : str
        A vector's components in ``child_frame`` become those in ``frame``.
    """

    def __init__(self, frame: str, child_frame: str) -> None:
        head = ENCAPSULATION + _ONE + bytes(8) + text(frame)
        head = head.ljust(-(-len(head) // 4) * 4, b"\x00") + text(child_frame)
        start = numbers_after(len(head))
        self._template = head.ljust(start + 8 * (_TRANSLATION + 4), b"\x00")
        self._fields = np.dtype(
            {
                "names": ["sec", "nanosec", "rotation"],
                "formats": ["<i4", "<u4", ("<f8", (4,))],
                "offsets": [8, 12, start + 8 * _TRANSLATION],
                "itemsize": len(self._template),
            }
        )

    def encode(self, stamps_ns: Integers, attitude_xyzw: Array) -> list[bytes]:
        """One message a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        attitude_xyzw : ndarray, shape (N, 4)

        Returns
        -------
        list of bytes
        """
        buffer = bytearray(self._template * len(stamps_ns))
        rows = np.frombuffer(buffer, dtype=self._fields)
        rows["sec"], rows["nanosec"] = np.divmod(stamps_ns, NS)
        rows["rotation"] = attitude_xyzw
        size = len(self._template)
        return [bytes(buffer[i : i + size]) for i in range(0, len(buffer), size)]
