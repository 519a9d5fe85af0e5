"""Findings of an inspection: mistakes, what is undecided, and notes."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import SI

HOW: Final = "turn it slowly once about each axis, then let it rest for ten seconds"
"""How to record a log that decides."""
COMPARED: Final = {
    "gyro": ("gyro_axes", "gyro_units", "time_step"),
    "accelerometer": ("accelerometer_axes", "accelerometer_late", "accelerometer_units", "gravity_removed"),
    "magnetometer": ("magnetometer_axes", "magnetometer_late"),
    "truth": ("truth_late", "truth_mounting"),
}
"""Codes of all that a comparison decides of each sensor."""

Numbers: TypeAlias = "float | tuple[float, ...]"


@short_dataclass
class LogMistake:
    """A mistake in the readings, named after the repair that undoes it.

    Attributes
    ----------
    code : str
    sensor : str
        A sensor, ``imu``, ``log`` for all, or ``truth``.
    message : str
    repair : str
        The repair in a few characters, such as ``y x -z``; empty where nothing repairs it.
    before, after : float or None
        Misfit without the repairs and with them, as a share of the vector; None where no model is needed.
    or_else : tuple of str
        Codes of mistakes whose repairs do as well.
    """

    code: str
    sensor: str
    message: str
    repair: str = ""
    before: float | None = None
    after: float | None = None
    or_else: tuple[str, ...] = ()


@short_dataclass
class Undecided:
    """A mistake between which and none the log does not decide.

    Attributes
    ----------
    code : str
    message : str
        Why, and how to record a log that decides.
    """

    code: str
    message: str


@short_dataclass
class LogNote:
    """Something about the readings that is no mistake.

    Attributes
    ----------
    code : str
    message : str
    value : float or tuple of float
    """

    code: str
    message: str
    value: Numbers


@short_dataclass
class Estimated:
    """A number with its standard error.

    Attributes
    ----------
    value : float or tuple of float
    standard_error : float or tuple of float
    """

    value: Numbers
    standard_error: Numbers


@short_dataclass
class Mark:
    """Stretch of time of a sensor, or of all.

    Attributes
    ----------
    sensor : str
        A sensor, ``imu``, or ``log`` for all.
    text : str
        ``rest``, ``compared``, or what is broken.
    begin_ns, end_ns : int
    """

    sensor: str
    text: str
    begin_ns: int
    end_ns: int


@dataclass
class Change:
    """Change of the readings of a sensor that undoes its mistakes.

    Attributes
    ----------
    matrix : ndarray, shape (3, 3)
        From the readings less the offset.
    offset : ndarray, shape (3,), or float
    delay_s : float
        Time from when they were true to their stamps, s.
    """

    matrix: Array = field(default_factory=lambda: np.eye(3))
    offset: Array | float = 0.0
    delay_s: float = 0.0

    def applied(self, readings: Array) -> Array:
        """Readings, shape (N, 3), with the change."""
        return (readings - self.offset) @ self.matrix.T


class Findings:
    """Findings up to now."""

    def __init__(self) -> None:
        self.mistakes: list[LogMistake] = []
        self.undecided: dict[str, Undecided] = {}
        self.notes: list[LogNote] = []
        self.sensors: dict[str, Estimated] = {}
        self.marks: list[Mark] = []
        self.changes: defaultdict[str, Change] = defaultdict(Change)

    def name(
        self, code: str, sensor: str, message: str, repair: str = "", undone: Array | float = 1.0, **more: Any
    ) -> None:
        """Add a mistake, and the factor or the matrix by which it is undone; ``more`` are fields of `LogMistake`."""
        self.mistakes.append(LogMistake(code, sensor, message, repair, **more))
        change = self.changes[sensor]
        change.matrix = np.dot(undone, change.matrix)

    def ask(self, code: str, why: str) -> None:
        """Add what is undecided; of each code the first."""
        self.undecided.setdefault(code, Undecided(code, f"{why}: {HOW}"))

    def ask_all(self, why: str, *sensors: str) -> None:
        """Add all that a comparison decides of some sensors."""
        for sensor in sensors:
            for code in COMPARED[sensor]:
                self.ask(code, why)

    def note(self, code: str, message: str, value: ArrayLike) -> None:
        """Add a note with a number, or several."""
        self.notes.append(LogNote(code, message, _numbers(value)))

    def estimate(self, name: str, value: ArrayLike, error: ArrayLike = 0.0) -> None:
        """Add a parameter of the simulator's sensors with its standard error, or several numbers with theirs."""
        self.sensors[name] = Estimated(_numbers(value), _numbers(error))

    def has(self, code: str, sensor: str) -> bool:
        """Whether a mistake of a sensor was found."""
        return (code, sensor) in {(each.code, each.sensor) for each in self.mistakes}

    def unit(self, sensor: str) -> str:
        """Unit of the repaired readings of a sensor."""
        is_unknown = any(each.code == f"{sensor}_units" and not each.repair for each in self.mistakes)
        return "of the readings" if is_unknown else SI[sensor]


def _numbers(value: ArrayLike) -> Numbers:
    """Numbers of Python, in a row."""
    array = np.asarray(value, dtype=np.float64)
    return tuple(array.ravel().tolist()) if array.ndim else float(array)
