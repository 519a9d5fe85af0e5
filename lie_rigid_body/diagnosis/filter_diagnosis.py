"""The result of a diagnosis: mistakes, probes, notes and situations, and the sentences that say them first."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lie_rigid_body.diagnosis.probing import Probe
from lie_rigid_body.diagnosis.situations import Situation
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.showing import Shown
from lie_rigid_body.foundation.wording import MAX_LINE, counted, shortened


@short_dataclass
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


@short_dataclass
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


@short_dataclass(eq=False)
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
    """Diagnosis of a filter: its mistakes, and the probes of what it can do.

    Attributes
    ----------
    mistakes : tuple of Mistake
    probes : tuple of Probe
    notes : tuple of Note
    filter_runs : int
        How often the filter was run.
    rms_deg, floor_deg : float
        RMS of the total error without a repair, and the one below which nothing is looked for, degrees.
    first : tuple of str
        What is said before all else: that the filter is unstable, or does not hear a sensor.
    situations : tuple of Situation
        Where the filter is right and where not, if no repair explains its error.
    remarks : tuple of str
        About the diagnosis itself, in sentences.
    errors : tuple of ErrorOverTime
        Before and after each named repair.
    interrupted : bool
        Whether it was ended before its end.
    updates : int
        How many readings of the gyro the filter was given in all runs.
    """

    mistakes: tuple[Mistake, ...]
    probes: tuple[Probe, ...]
    notes: tuple[Note, ...]
    filter_runs: int
    rms_deg: float
    floor_deg: float
    first: tuple[str, ...] = ()
    situations: tuple[Situation, ...] = ()
    remarks: tuple[str, ...] = ()
    errors: tuple[ErrorOverTime, ...] = ()
    interrupted: bool = False
    updates: int = 0

    def __repr__(self) -> str:
        """The verdict; no call, as only `diagnose` makes one."""
        return shortened(f"<FilterDiagnosis: {' '.join(self.sentences)}>", MAX_LINE)

    @property
    def passed(self) -> bool:
        """Whether there is neither a mistake nor a probe that failed."""
        return not self.mistakes and not self.failed

    @property
    def failed(self) -> list[Probe]:
        """Probes that failed."""
        return [probe for probe in self.probes if probe.passed is False]

    @property
    def sentences(self) -> list[str]:
        """Headline for a person: the mistakes, or that none is named, and each probe that failed."""
        judged = counted(sum(probe.passed is not None for probe in self.probes), "probe")
        failed = ", ".join(probe.code for probe in self.failed)
        fails = f"but fails {len(self.failed)} of {judged}: {failed}" if failed else f"and passes {judged}"
        tried = "so far" if self.interrupted else "that was tried"
        none = f"Nothing {tried} removes the error of {degrees(self.rms_deg)}."
        if any(probe.code == "follows" and probe.passed for probe in self.probes):
            none = f"Follows perfect sensors ({degrees(self.rms_deg)}), {fails}."
        said = [mistake.message for mistake in self.mistakes] or [none]
        return [*self.first, *said, *(f"{probe.code}: {probe.message}." for probe in self.failed)]

    def to_dict(self) -> dict[str, Any]:
        """The entries of ``diagnose --json``."""
        return {
            "mistakes": [{**asdict(mistake), "or_else": list(mistake.or_else)} for mistake in self.mistakes],
            "probes": [asdict(probe) for probe in self.probes],
            "notes": [asdict(note) for note in self.notes],
            "situations": [{"name": each.name, "rms_deg": each.rms_deg} for each in self.situations],
            "filter_runs": self.filter_runs,
            "passed": self.passed,
        }

    def __str__(self) -> str:
        """Headline for a person; `lie_rigid_body.report.filters` makes the tables."""
        return "\n".join(self.sentences)


def degrees(value: float) -> str:
    """An angle in degrees for the eye: what is less than 0.005 is 0.00."""
    return f"{value:.2f}°" if value < 10.0 or not np.isfinite(value) else f"{value:.1f}°"
