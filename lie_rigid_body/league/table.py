"""The table of the league: rows of filters, how they are ranked, and the reference rows that the package ships."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.evaluation.differences import of_runs
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import call_repr, counted, listed, shown
from lie_rigid_body.league.cases import CASES, MOTIONS, REAL, Case
from lie_rigid_body.scenario.parameter_file import CONFIG
from lie_rigid_body.system.bounded_input import load_json, read_text

EDITION: Final = "2026.1"
"""Edition of the cases and of the reference rows: rows of one edition can be compared."""
REFERENCE: Final = CONFIG / "league" / f"{EDITION}.json"

_ROWS_FILE: Final = "a file that 'league --json' writes"
_ALWAYS_KNOWN: Final = {"total_deg", "heading_deg", "inclination_deg"}
"""Errors that each case has; the others may be None."""
BOUND: Final = "Cramér–Rao bound"
"""Name of the row of the bound."""
LOST_DEG: Final = 180.0
"""Error of a filter that fails, degrees."""
MIN_DEG: Final = 1e-9
"""Least error that counts in a geometric mean, degrees."""


@dataclass(frozen=True)
class CaseResult:
    """Errors of a filter in one case.

    Attributes
    ----------
    total_deg, heading_deg, inclination_deg : float
        RMS from `SETTLED_S` on, degrees; `LOST_DEG` of a filter that failed.
    converged_s : float or None
        Time to converge, s; None where it never does.
    failure : str
        What the filter failed of; '' if it did not.
    gyro_bias_rms_rad_s : float or None
        RMS error of the gyro's bias from `SETTLED_S` on, rad/s, of a filter that gives it.
    """

    total_deg: float
    heading_deg: float
    inclination_deg: float
    converged_s: float | None = None
    failure: str = ""
    gyro_bias_rms_rad_s: float | None = None


@dataclass(frozen=True)
class FilterRow:
    """A filter in all cases.

    Attributes
    ----------
    filter : str
        Its name.
    results : mapping of str to CaseResult
        By the names of the cases.
    version : str
        Of its library.
    setting : str
        How its parameters were chosen; '' for the defaults of its library.
    sees_future : bool
        Whether an attitude rests on later readings too, as a smoother's does.
    other_readings : tuple of str
        Cases in which the machine made other readings than the reference has.
    """

    filter: str
    results: Mapping[str, CaseResult]
    version: str = ""
    setting: str = ""
    sees_future: bool = False
    other_readings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return call_repr(self, {"filter": self.filter, "overall_deg": self.overall_deg})

    @property
    def name(self) -> str:
        """The filter with its setting, as tables show it."""
        return ", ".join(filter(None, (self.filter, self.setting)))

    def typical_deg(self, grade: str, *, faults: bool = False) -> float:
        """Median of the total errors over the cases of a grade, without faults or with, degrees."""
        return float(np.median([self.results[str(c)].total_deg for c in CASES if is_of(c, grade, faults=faults)]))

    @cached_property
    def of_motions_deg(self) -> Array:
        """Geometric mean of the total errors over the grades of real sensors, in each motion, degrees."""
        errors = [[self.results[str(Case(motion, grade))].total_deg for grade in REAL] for motion in MOTIONS]
        return np.asarray(np.exp(np.log(np.maximum(errors, MIN_DEG)).mean(axis=1)))

    @property
    def overall_deg(self) -> float:
        """Geometric mean of the typical errors with the grades of real sensors, degrees: rows are ranked by it."""
        return float(np.exp(np.mean([np.log(max(self.typical_deg(grade), MIN_DEG)) for grade in REAL])))

    def to_json(self, table: LeagueTable | None = None) -> dict[str, Any]:
        """The row as JSON-serialisable data, with its rank and its ties in a table, which reading leaves out."""
        if table is None:
            return asdict(self)
        return {**asdict(self), "rank": table.rank(self), "tied": [other.name for other in table.tied(self)]}

    @classmethod
    def from_json(cls, content: Any) -> FilterRow:
        """Read what `to_json` gave.

        Raises
        ------
        InputError
            If a field or a case is missing, or one is of another kind.
        """
        try:
            content = {name: value for name, value in content.items() if name not in ("rank", "tied")}
            results = {str(name): CaseResult(**result) for name, result in content["results"].items()}
            row = cls(**{**content, "results": results, "other_readings": tuple(content.get("other_readings", ()))})
            of_cases = [vars(row.results[str(case)]) for case in CASES]
            texts = (row.filter, row.version, row.setting, *(each["failure"] for each in of_cases))
            if not (
                row.filter
                and all(map(str.isprintable, texts))
                and len(results) == len(CASES)
                and all(
                    _is_size(size)
                    for each in of_cases
                    for name, size in each.items()
                    if name != "failure" and (size is not None or name in _ALWAYS_KNOWN)
                )
                and isinstance(row.sees_future, bool)
                and {*row.other_readings} <= {*map(str, CASES)}
            ):
                raise ValueError("no words, no size of an error, no flag or no case")
        except (TypeError, KeyError, AttributeError, ValueError, OverflowError) as error:
            what = f"{error} is missing" if isinstance(error, KeyError) else "a value is unknown, or of another kind"
            raise InputError(f"no row of the league ({what}): give what 'league --json' writes") from None
        return row


def _is_size(value: object) -> bool:
    """Whether a value of JSON is a finite number that is not below 0."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= sys.float_info.max


def is_of(case: Case, grade: str, *, faults: bool = False) -> bool:
    """Whether a case is of a grade, without a fault or with one."""
    return case.grade == grade and bool(case.fault) == faults


@dataclass(frozen=True)
class LeagueTable:
    """Rows of one edition.

    Attributes
    ----------
    rows : tuple of FilterRow
        The best first.
    readings : mapping of str to str
        Hash of the readings of each case.
    bound_deg : mapping of str to float
        Cramér–Rao bound of the RMS error of filters that do not know the dynamics, in each case with errors, degrees.
    """

    rows: tuple[FilterRow, ...]
    readings: Mapping[str, str]
    bound_deg: Mapping[str, float]

    @property
    def bound(self) -> FilterRow:
        """The row of `bound_deg`, which is no filter's."""
        return FilterRow(
            BOUND,
            {str(case): CaseResult(self.bound_deg.get(str(case), 0.0), 0.0, 0.0) for case in CASES},
        )

    def __repr__(self) -> str:
        return call_repr(self, {"rows": len(self.rows)})

    def with_rows(self, rows: Iterable[FilterRow]) -> LeagueTable:
        """The table with more rows."""
        return replace(self, rows=tuple(sorted((*self.rows, *rows), key=lambda row: row.overall_deg)))

    def rank(self, row: FilterRow, of: Callable[[FilterRow], float] = lambda row: row.overall_deg) -> int:
        """Place of a row, from 1 on, by a number of each row; rows that are alike share the better place."""
        return 1 + sum(of(other) < of(row) for other in self.rows)

    def tied(self, row: FilterRow) -> list[FilterRow]:
        """Neighbours of a row in rank, up and down, from which it is not shown to differ, best first.

        By pairs of the motions: the geometric means of the errors over the grades of real sensors, at 5 % each.
        """
        at = self.rows.index(row)
        up, down = (
            [*takewhile(lambda other: not of_runs(row.of_motions_deg, other.of_motions_deg).is_shown, rows)]
            for rows in (reversed(self.rows[:at]), self.rows[at + 1 :])
        )
        return [*reversed(up), *down]

    def place(self, row: FilterRow, case: Case) -> int:
        """Place of a row in one case."""
        return self.rank(row, lambda each: each.results[str(case)].total_deg)

    def best_and_worst(self, row: FilterRow) -> tuple[Case, Case]:
        """Cases in which a row has the best and the worst place of all its places."""
        places = [self.place(row, case) for case in CASES]
        return CASES[int(np.argmin(places))], CASES[int(np.argmax(places))]


def rows_of(path: str | Path) -> list[FilterRow]:
    """Rows of a file that ``league --json`` wrote.

    Raises
    ------
    InputError
        If it is no such file, or of another edition.
    """
    # the reference has a tenth of so many bytes
    content = load_json(read_text(path, 2**22, kind=_ROWS_FILE), str(path), _ROWS_FILE)
    edition = content.get("edition") if isinstance(content, dict) else None
    if edition not in (None, EDITION):
        raise InputError(
            f"{path}: edition {shown(str(edition))} is not {EDITION}, whose cases differ: run the filter again"
        )
    rows = None if edition is None else content.get("rows")
    if not (isinstance(rows, list) and rows):
        raise InputError(f"{path}: it has no rows: give what 'league --json' writes")
    try:
        return [FilterRow.from_json(row) for row in rows]
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@lru_cache
def reference() -> LeagueTable:
    """The reference set: filters of other libraries at their defaults, and at the best of a grid for each grade."""
    content = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return LeagueTable((), content["readings"], content["bound_deg"]).with_rows(
        map(FilterRow.from_json, content["rows"])
    )


def angle(error_deg: float) -> str:
    """An angle with two digits, as text; 0 below a ten-thousandth of a degree."""
    return "0" if error_deg < 5e-5 else f"{error_deg:.2g}" if error_deg < 99.5 else f"{error_deg:.0f}"


def rank_with_ties(table: LeagueTable, row: FilterRow) -> str:
    """Rank of a row, and in brackets the ranks between which no difference is shown."""
    ranks = [table.rank(other) for other in (row, *table.tied(row))]
    return f"{ranks[0]}" + (f" ({min(ranks)} to {max(ranks)})" if min(ranks) < max(ranks) else "")


def standing(table: LeagueTable, row: FilterRow) -> str:
    """Sentences about the place of a row in a table that has it."""
    best, worst = table.best_and_worst(row)
    failed = [name for name, result in row.results.items() if result.failure]
    biases = [result.gyro_bias_rms_rad_s for result in row.results.values() if result.gyro_bias_rms_rad_s is not None]
    rank = rank_with_ties(table, row)
    sentences = (
        f"{row.name} is number {rank} of {len(table.rows)}: {angle(row.typical_deg('mems'))}° with MEMS sensors, "
        f"where the Cramér–Rao bound without dynamics is {angle(table.bound.typical_deg('mems'))}°.",
        f"It is best at {best} (number {table.place(row, best)}) and worst at {worst} "
        f"(number {table.place(row, worst)}).",
        f"Its gyro bias is {np.median(biases):.2g} rad/s off in the median case." if biases else "",
        f"It failed in {counted(len(failed), 'case')}, first in {failed[0]}: {row.results[failed[0]].failure}"
        if failed
        else "",
        f"This machine makes other readings than the reference in {listed(row.other_readings)}."
        if row.other_readings
        else "",
    )
    return " ".join(filter(None, sentences))
