"""The table of the league: rows of filters, how they are ranked, and the reference rows that the package ships."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.evaluation.differences import geometric_mean, of_runs
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import call_repr, counted, listed, shown
from lie_rigid_body.league.cases import CASES, GRADES, GROUPS, RANKED, SETTLED_S, WIRING, Case
from lie_rigid_body.scenario.parameter_file import CONFIG
from lie_rigid_body.system.bounded_input import load_json, read_text

EDITION: Final = "2026.2"
"""Edition of the cases and of the reference rows: rows of one edition can be compared."""
REFERENCE: Final = CONFIG / "league" / f"{EDITION}.json"

_ROWS_FILE: Final = "a file that 'league --json' writes"
_FOLLOWING: Final = ("name", "median_deg", "overall", "rank", "tied")
"""Names of the values in a file that follow from the others."""
_ALWAYS_KNOWN: Final = {"total_deg", "heading_deg", "inclination_deg"}
"""Errors that each case has; the others may be None."""
BOUND: Final = "Cramér–Rao bound"
"""Name of the row of the bound."""
LOST_DEG: Final = 180.0
"""Error of a filter that fails, degrees."""
MAX_WIRED_DEG: Final = 5.0
"""Largest error of a filter with perfect sensors whose wiring is not in doubt, degrees."""
MOST: Final = 0.5
"""Share of an error below which what is left without a constant shows that it explains most of it."""


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
    without_constant_deg : float or None
        RMS of the total error without the constant of the row, degrees; None of a row that has none.
    """

    total_deg: float
    heading_deg: float
    inclination_deg: float
    converged_s: float | None = None
    failure: str = ""
    gyro_bias_rms_rad_s: float | None = None
    without_constant_deg: float | None = None


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
    parameters : mapping of str to mapping of str to float
        By grades of sensors the parameters that differ from the defaults.
    sees_future : bool
        Whether an attitude rests on later readings too, as a smoother's does.
    constant : str
        Heading, mounting or clock that explains most of its error with perfect sensors, a sentence; '' where none does.
    other_readings : tuple of str
        Cases in which the machine made other readings than the reference has.
    """

    filter: str
    results: Mapping[str, CaseResult]
    version: str = ""
    setting: str = ""
    parameters: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    sees_future: bool = False
    constant: str = ""
    other_readings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return call_repr(self, {"filter": self.filter, "overall_deg": self.overall_deg})

    @property
    def name(self) -> str:
        """The filter with its setting, as tables show it."""
        return ", ".join(filter(None, (self.filter, self.setting)))

    @property
    def is_wired(self) -> bool:
        """Whether it follows perfect sensors; another one stands at the end."""
        return self.results[str(WIRING)].total_deg <= MAX_WIRED_DEG

    @property
    def lost(self) -> int:
        """Number of cases in which it failed."""
        return sum(bool(result.failure) for result in self.results.values())

    def of(self, cases: Iterable[Case], what: str = "total_deg") -> Array:
        """A number of its results in some cases, infinite where there is none."""
        values = [getattr(self.results[str(case)], what) for case in cases]
        return np.array([np.inf if value is None else value for value in values])

    def median(self, cases: Iterable[Case], what: str = "total_deg") -> float:
        """Median of a number of its results over some cases, infinite where most have none."""
        return float(np.median(self.of(cases, what)))

    def median_deg(self, group: str, grade: str, what: str = "total_deg") -> float:
        """Median of the errors in a group with sensors of a grade, degrees."""
        return self.median([case for case in RANKED if (case.group, case.grade) == (group, grade)], what)

    def group_deg(self, group: str, what: str = "total_deg") -> float:
        """Geometric mean over the grades of the medians in a group, degrees."""
        medians = [self.median_deg(group, grade, what) for grade in GRADES]
        return geometric_mean(np.array(medians))

    @cached_property
    def overall_deg(self) -> float:
        """Geometric mean over the groups, degrees: rows are ranked by it."""
        return self.overall("total_deg")

    def overall(self, what: str) -> float:
        """Geometric mean over the groups of a kind of error, degrees."""
        return geometric_mean(np.array([self.group_deg(group, what) for group in GROUPS]))

    @property
    def explained(self) -> bool:
        """Whether one constant explains most of its error."""
        return bool(self.constant) and self.overall("without_constant_deg") < MOST * self.overall_deg

    def to_json(self, table: LeagueTable | None = None) -> dict[str, Any]:
        """The row as JSON-serialisable data, in a table with what follows from it, which reading leaves out."""
        if table is None:
            return asdict(self)
        follows = {
            "name": self.name,
            "median_deg": {group: {grade: self.median_deg(group, grade) for grade in GRADES} for group in GROUPS},
            "overall": self.overall_deg,
            "rank": table.rank(self),
            "tied": [other.name for other in table.tied(self)],
        }
        return {**follows, **asdict(self)}

    @classmethod
    def from_json(cls, content: Any) -> FilterRow:
        """Read what `to_json` gave.

        Raises
        ------
        InputError
            If a field or a case is missing, or one is of another kind.
        """
        try:
            content = {name: value for name, value in content.items() if name not in _FOLLOWING}
            results = {str(name): CaseResult(**result) for name, result in content["results"].items()}
            row = cls(**{**content, "results": results, "other_readings": tuple(content.get("other_readings", ()))})
            of_cases = [vars(row.results[str(case)]) for case in CASES]
            texts = (row.filter, row.version, row.setting, row.constant, *(each["failure"] for each in of_cases))
            if not (
                row.filter
                and all(map(str.isprintable, texts))
                and len(results) == len(CASES)
                and all(
                    _is_size(size, LOST_DEG if name.endswith("_deg") else sys.float_info.max)
                    for each in of_cases
                    for name, size in each.items()
                    if name != "failure" and (size is not None or name in _ALWAYS_KNOWN)
                )
                and isinstance(row.sees_future, bool)
                and {*row.parameters} <= {*GRADES}
                and {*row.other_readings} <= {*map(str, CASES)}
            ):
                raise ValueError("no words, no size of an error, no flag or no case")
        except (TypeError, KeyError, AttributeError, ValueError, OverflowError) as error:
            what = f"{error} is missing" if isinstance(error, KeyError) else "a value is unknown, or of another kind"
            raise InputError(f"no row of the league ({what}): give what 'league --json' writes") from None
        return row


def _is_size(value: object, largest: float) -> bool:
    """Whether a value of JSON is a number from 0 to the largest one."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= largest


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
    real_deg : mapping of str to float
        Median of the RMS errors of rows on real recordings, degrees, by their names.
    """

    rows: tuple[FilterRow, ...]
    readings: Mapping[str, str]
    bound_deg: Mapping[str, float]
    real_deg: Mapping[str, float] = field(default_factory=dict)

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
        return replace(self, rows=tuple(sorted((*self.rows, *rows), key=_place)))

    def rank(self, row: FilterRow) -> int:
        """Place of a row, from 1 on; rows that are alike share the better place."""
        return 1 + sum(_place(other) < _place(row) for other in self.rows)

    def rank_in(self, row: FilterRow, group: str) -> int:
        """Place of a row in a group."""
        return 1 + sum(other.group_deg(group) < row.group_deg(group) for other in self.rows)

    def rank_without_constant(self, row: FilterRow) -> int:
        """Place that a row would have without its constant."""
        (wiring_deg,) = row.of([WIRING], "without_constant_deg")
        place = wiring_deg > MAX_WIRED_DEG, row.overall("without_constant_deg")
        return 1 + sum(_place(other) < place for other in self.rows if other is not row)

    def _neighbours(self, row: FilterRow) -> tuple[Sequence[FilterRow], Sequence[FilterRow]]:
        """Rows above, the nearest first, and below."""
        at = self.rows.index(row)
        return self.rows[:at][::-1], self.rows[at + 1 :]

    def tied(self, row: FilterRow) -> list[FilterRow]:
        """Neighbours of a row in rank, up and down, from which it is not shown to differ, best first.

        From the row up, and from the row down, they end where two of them are shown to differ at 5 %, by pairs of the
        ranked cases. So of two rows both are tied with the other, or none.
        """
        up, down = (_alike_from(row, others) for others in self._neighbours(row))
        return [*reversed(up), *down]

    def nearest_other(self, row: FilterRow) -> list[FilterRow]:
        """The first rows above and below that are shown to differ, where there are."""
        found = (next((other for other in rows if not _alike(row, other)), None) for rows in self._neighbours(row))
        return [other for other in found if other]


def _place(row: FilterRow) -> tuple[bool, float]:
    return not row.is_wired, row.overall_deg


def _alike(row: FilterRow, other: FilterRow) -> bool:
    """Whether no difference of two rows is shown."""
    return not of_runs(row.of(RANKED), other.of(RANKED)).is_shown


def _alike_from(row: FilterRow, others: Iterable[FilterRow]) -> list[FilterRow]:
    """The first of some rows, until two of these and a row are shown to differ."""
    alike = [row]
    for other in others:
        if not all(_alike(each, other) for each in alike):
            break
        alike.append(other)
    return alike[1:]


def require_names(names: Sequence[str]) -> None:
    """Refuse rows of which two have one name.

    Raises
    ------
    InputError
        If two have.
    """
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"two rows are called {shown(twice)}: give each once, or change 'filter' in the file of one")


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
    rows = map(FilterRow.from_json, content["rows"])
    return LeagueTable((), content["readings"], content["bound_deg"], content["real_deg"]).with_rows(rows)


def angle(error_deg: float) -> str:
    """An angle with two digits, as text; 0 below a ten-thousandth of a degree."""
    return "0" if error_deg < 5e-5 else f"{error_deg:.2g}" if error_deg < 99.5 else f"{error_deg:.0f}"


def rank_with_ties(table: LeagueTable, row: FilterRow) -> str:
    """Rank of a row, and in brackets those of the neighbours with which it is tied."""
    ranks = [table.rank(other) for other in (row, *table.tied(row))]
    return f"{ranks[0]}" + (f" ({min(ranks)} to {max(ranks)})" if min(ranks) < max(ranks) else "")


def standing(table: LeagueTable, row: FilterRow) -> str:
    """Sentences about the place of a row in a table that has it."""
    ranks = {group: table.rank_in(row, group) for group in GROUPS}
    best = min(ranks, key=ranks.__getitem__)
    worst = max(ranks, key=ranks.__getitem__)
    failed = [name for name, result in row.results.items() if result.failure]
    biases = row.of(RANKED, "gyro_bias_rms_rad_s")
    sentences = (
        f"{row.name} is number {rank_with_ties(table, row)} of {len(table.rows)}, with {angle(row.overall_deg)}° "
        f"overall, where the Cramér–Rao bound without dynamics is {angle(table.bound.overall_deg)}°.",
        f"By rank it is best at {best} (number {ranks[best]}) and worst at {worst} (number {ranks[worst]})."
        if ranks[best] < ranks[worst]
        else "",
        *(
            f"{of_runs(row.of(RANKED), other.of(RANKED)).sentence(row.name, other.name)}."
            for other in table.nearest_other(row)
        ),
        f"{row.constant}. Without this constant its error is {angle(row.overall('without_constant_deg'))}°, and it "
        f"would be number {table.rank_without_constant(row)}."
        if row.explained
        else "",
        f"With perfect sensors its error is {angle(row.results[str(WIRING)].total_deg)}°: its wiring is in doubt, "
        f"or it does not settle in {SETTLED_S:g} s, so it stands at the end."
        if not row.is_wired
        else "",
        f"Its gyro bias is {np.median(biases):.2g} rad/s off in the median case." if np.isfinite(biases).any() else "",
        f"It failed in {counted(len(failed), 'case')}, first in {failed[0]}: {row.results[failed[0]].failure}"
        if failed
        else "",
        f"This machine makes other readings than the reference in {listed(row.other_readings)}."
        if row.other_readings
        else "",
    )
    return " ".join(filter(None, sentences))
