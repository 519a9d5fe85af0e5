"""What a diagnosis found, for people and for programs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.showing import Shown
from lie_rigid_body.wording import counted, shortened


@short_dataclass(frozen=True)
class Mistake:
    """A mistake of a filter, named after the repair that undoes it.

    Attributes
    ----------
    code : str
    message : str
        What is wrong, and what the repair leaves.
    repair : str
        The repair in a few characters, such as ``y x -z``.
    rms_deg_before, rms_deg_after : float
        RMS of the total error before this repair, with those before it, and after, degrees.
    or_else : tuple of str
        Codes of mistakes whose repairs do as well on these runs.
    """

    code: str
    message: str
    repair: str
    rms_deg_before: float
    rms_deg_after: float
    or_else: tuple[str, ...] = ()


@short_dataclass(frozen=True)
class Probe:
    """Whether a filter has an ability.

    Attributes
    ----------
    code : str
    passed : bool
    message : str
    value : float or None
        The number that was judged: an error in degrees, if the message tells nothing else.
    """

    code: str
    passed: bool
    message: str
    value: float | None = None


@short_dataclass(frozen=True)
class Note:
    """Something about a filter that is no mistake.

    Attributes
    ----------
    code : str
    message : str
    value : float or str
    """

    code: str
    message: str
    value: float | str


@short_dataclass(frozen=True)
class ErrorOverTime:
    """The total error in the first course, after a repair and those before it.

    Attributes
    ----------
    code : str
        The mistake that is repaired last, or nothing.
    t_s, error_deg : ndarray, shape (N,)
        Times in s, errors in degrees.
    rms_deg : float
        RMS over the last two thirds of all courses, degrees.
    """

    code: str
    t_s: Array
    error_deg: Array
    rms_deg: float


@dataclass(frozen=True)
class FilterDiagnosis(Shown):
    """What is wrong with a filter, and what it can do.

    Attributes
    ----------
    mistakes : tuple of Mistake
    probes : tuple of Probe
    notes : tuple of Note
    filter_runs : int
        How often the filter was run.
    rms_deg, floor_deg : float
        RMS of the total error without a repair, and the one below which nothing is looked for, degrees.
    remarks : tuple of str
        About the diagnosis itself, in sentences.
    errors : tuple of ErrorOverTime
        Before and after each named repair.
    interrupted : bool
        Whether it was ended before its end.
    """

    mistakes: tuple[Mistake, ...]
    probes: tuple[Probe, ...]
    notes: tuple[Note, ...]
    filter_runs: int
    rms_deg: float
    floor_deg: float
    remarks: tuple[str, ...] = ()
    errors: tuple[ErrorOverTime, ...] = ()
    interrupted: bool = False

    def __repr__(self) -> str:
        """The verdict; no call, as only `diagnose` makes one."""
        return shortened(f"<FilterDiagnosis: {' '.join(self.sentences)}>")

    @property
    def passed(self) -> bool:
        """Whether there is neither a mistake nor a probe that failed."""
        return not self.mistakes and all(probe.passed for probe in self.probes)

    @property
    def sentences(self) -> list[str]:
        """What a person needs to know first."""
        failed = {probe.code: probe.message for probe in self.probes if not probe.passed}
        if self.mistakes:
            return [mistake.message for mistake in self.mistakes]
        said = f"No mistake: with perfect sensors the filter errs by {degrees(self.rms_deg)}."
        if self.rms_deg > self.floor_deg:
            tried = "so far" if self.interrupted else "that was tried"
            said = f"Nothing {tried} mends the error of {degrees(self.rms_deg)}."
        if not failed:
            return [said]
        first = "finite" if "finite" in failed else next(iter(failed))
        fails = f"The filter fails {counted(len(failed), 'probe')}: {', '.join(failed)}."
        return [fails, f"{first}: {failed[first]}.", said]

    def to_dict(self) -> dict[str, Any]:
        """The entries of ``diagnose --json``."""
        return {
            "mistakes": [{**asdict(mistake), "or_else": list(mistake.or_else)} for mistake in self.mistakes],
            "probes": [asdict(probe) for probe in self.probes],
            "notes": [asdict(note) for note in self.notes],
            "filter_runs": self.filter_runs,
            "passed": self.passed,
        }

    def __str__(self) -> str:
        """What a person needs to know first; `lie_rigid_body.report.filters` makes the tables."""
        return "\n".join(self.sentences)


def degrees(value: float) -> str:
    """An angle in degrees for the eye: what is less than 0.005 is 0.00."""
    return f"{value:.2f}°" if value < 10.0 or not np.isfinite(value) else f"{value:.1f}°"


def with_unit(value: float, unit: str = "°") -> str:
    """A number with three digits and its unit; degrees below a thousandth are 0."""
    told = 0.0 if unit == "°" and value < 1e-3 else value
    return f"{told:.0f}{unit}" if told >= 100.0 else f"{told:.3g}{unit}"
