"""What an inspection says: mistakes, what is undecided, and notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from lie_rigid_body.foundation.short_dataclass import short_dataclass

HOW: Final = "turn it slowly once about each axis, then let it rest for ten seconds"
"""How to record a log that decides."""


@short_dataclass(frozen=True)
class Mistake:
    """A mistake in the readings, named after the repair that undoes it.

    Attributes
    ----------
    code : str
    sensor : str
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


@short_dataclass(frozen=True)
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


@short_dataclass(frozen=True)
class Note:
    """Something about the readings that is no mistake.

    Attributes
    ----------
    code : str
    message : str
    value : float, str, or sequence of float
    """

    code: str
    message: str
    value: float | str | Sequence[float]


@short_dataclass(frozen=True)
class Estimated:
    """A number with its standard error.

    Attributes
    ----------
    value : float or tuple of float
    standard_error : float or tuple of float
    """

    value: float | tuple[float, ...]
    standard_error: float | tuple[float, ...]


@dataclass
class Findings:
    """What was found up to now."""

    mistakes: list[Mistake] = field(default_factory=list)
    undecided: dict[str, Undecided] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)
    sensors: dict[str, Estimated] = field(default_factory=dict)

    def ask(self, code: str, why: str) -> None:
        """Add what is undecided; of each code the first."""
        self.undecided.setdefault(code, Undecided(code, f"{why}: {HOW}"))

    def note(self, code: str, message: str, value: float | str | Sequence[float]) -> None:
        """Add a note."""
        self.notes.append(Note(code, message, value))

    def estimate(self, name: str, value: float | tuple[float, ...], error: float | tuple[float, ...] = 0.0) -> None:
        """Add a parameter of the simulator's sensors."""
        self.sensors[name] = Estimated(value, error)

    def has(self, code: str, sensor: str) -> bool:
        """Whether a mistake of a sensor was found."""
        return any(mistake.code == code and mistake.sensor == sensor for mistake in self.mistakes)
