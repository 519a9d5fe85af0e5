"""Faults of sensors as they happened, and their text."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Final, Protocol

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import short_repr, shown

KINDS: Final = (
    *("dropout", "outage", "latency", "latency_jitter", "clock_offset", "clock_skew"),
    *("spike", "noise_burst", "stuck", "saturation", "temperature_drift", "magnetic_disturbance"),
)
"""The kinds of faults. The order is part of the keys of the random numbers."""
AXES: Final = ("x", "y", "z")
"""Names of the axes in the text of a fault."""
PARTS: Final[list[str]] = []
"""Names of the sensors, and of parts of sensors, that can have faults, as the table of sensors puts them here. Their
order is part of the keys of the random numbers."""
LONGEST_TEXT: Final = 192
"""Largest length of the text of a fault, characters."""


@dataclass(frozen=True)
class Fault:
    """One fault of a sensor, from its begin to its end.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    sensor : str
        The sensor, or the part of it, that has the fault: one of `PARTS`.
    axis : str
        ``x``, ``y`` or ``z``; empty where a fault is not of one axis.
    begin_ns : int
        Simulated time at which it begins, ns; for a fault of one reading the time of the measurement.
    end_ns : int or None
        First time after it, ns; for a fault of one reading the time of the measurement; None: it lasts until a reset.
    size : float or None
        Size in the unit of the parameter that sets it; None where the fault has none.
    """

    kind: str
    sensor: str
    axis: str
    begin_ns: int
    end_ns: int | None
    size: float | None = None

    __repr__ = short_repr

    def later(self, by_ns: int) -> Fault:
        """Move the fault to a later time, by so many ns."""
        return replace(
            self, begin_ns=self.begin_ns + by_ns, end_ns=None if self.end_ns is None else self.end_ns + by_ns
        )

    def to_json(self) -> str:
        """The text of the fault, as the topic of faults has it."""
        return json.dumps(vars(self))

    def _is_one(self) -> bool:
        """Whether the fields have values that a fault can have."""
        times = (self.begin_ns, 0 if self.end_ns is None else self.end_ns)
        size = 0.0 if self.size is None else self.size
        names = self.kind in KINDS and self.sensor in PARTS and self.axis in (*AXES, "")
        return names and all(type(time) is int for time in times) and type(size) in (int, float)

    @classmethod
    def from_json(cls, text: str) -> Fault:
        """The fault that a text tells.

        Raises
        ------
        InputError
            If the text tells of no fault.
        """
        try:
            fault = cls(**json.loads(text[: 2 * LONGEST_TEXT]))
            if fault._is_one():
                return fault
        except (ValueError, TypeError, RecursionError):
            pass
        raise InputError(f"{shown(text)} tells of no fault of lie_rigid_body: give the topic ~/faults")


class Faulty(Protocol):
    """A part of a sensor's model that can have faults, and tells them."""

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> list[Fault]:
        """Faults that begin in a stretch of time since the segment's start.

        Parameters
        ----------
        begin_ns, end_ns : int
            Begin and end of the stretch, ns; the end is not part of it.
        first : int
            Number of the sensor's first reading in it, counted from 0 in the segment.
        times_ns : ndarray of int64, shape (N,)
            Times of the readings in it, ns.
        """
        ...


def stream(sensor: str, kind: str, part: int = 0) -> int:
    """Source of the random numbers of one kind of fault; ``part`` is 1 for a second source of the kind."""
    return 256 * (1 + PARTS.index(sensor)) + 2 * KINDS.index(kind) + part
