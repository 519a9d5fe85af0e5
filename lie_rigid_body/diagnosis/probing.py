"""Probing: a probe asks for the answers of a filter to some courses, and judges them; what is said of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lie_rigid_body.diagnosis.answers import Answer
from lie_rigid_body.diagnosis.course import Course
from lie_rigid_body.diagnosis.filter_runs import UNJUDGED
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.diagnosis.trials import NEAR
from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass

Courses = list[Course]
"""Courses of a probe, in the order in which their answers are judged."""
Answers = Sequence[Answer]
"""Answers of the filter to these courses."""
Judged = tuple[bool | None, str, float | None]
"""Whether a probe is passed, None where it is not judged; what is said of it, and the number that was judged."""
Probing = Generator[Courses, Answers, Judged]
"""A probe under way: it yields its courses, is sent the answers, and returns what is judged.

Without courses, as where an estimate has no covariance, it is not told.
"""


@short_dataclass
class Probe:
    """Whether a filter has an ability.

    Attributes
    ----------
    code : str
    passed : bool or None
        None where it is not judged.
    message : str
    value : float or None
        The number that was judged: an error in degrees, if the message tells nothing else.
    """

    code: str
    passed: bool | None
    message: str
    value: float | None = None


class ProbeRow(NamedTuple):
    """A probe in the table.

    Attributes
    ----------
    code : str
    begin : callable
    needs_error : bool
        Whether it is judged beside the error of the filter, and says nothing where that is above `UNJUDGED`.
    """

    code: str
    begin: Callable[[Search], Probing]
    needs_error: bool = True


def told(search: Search, rows: Sequence[ProbeRow]) -> Iterator[Probe]:
    """Results of probes."""
    chosen = search.chosen
    is_judged = chosen.error <= UNJUDGED
    begun = {row: row.begin(search) for row in rows if is_judged or not row.needs_error}
    courses = {row: next(probing) for row, probing in begun.items()}
    new = dict.fromkeys(course for each in courses.values() for course in each if course not in search.known)
    answers = zip(new, search.ask((course, chosen.repairs) for course in new), strict=False)
    for row in rows:
        asked = courses.get(row)
        if asked is None:
            yield Probe(row.code, None, f"not judged, as the error of the filter is {in_degrees(chosen.error)}")
        elif asked:
            while not search.known.keys() >= {*asked}:
                search.known.update([next(answers)])
            yield _ended(row.code, begun[row], [search.known[course] for course in asked])


def _ended(code: str, probing: Probing, answers: Sequence[Answer | FilterError]) -> Probe:
    """Result of a probe by the filter's answers; a filter that raises an error fails the probe."""
    judged: Judged = None, "", 0.0
    try:
        for each in answers:
            if isinstance(each, FilterError):
                raise each
        probing.send([each for each in answers if isinstance(each, Answer)])
    except StopIteration as end:
        judged = end.value
    except InputError as error:
        judged = False, str(error).removeprefix(f"{code}: "), None
    return Probe(code, *judged)


def with_unit(value: float, unit: str = "°") -> str:
    """A number with three digits and its unit; degrees below a thousandth are 0."""
    told = 0.0 if unit == "°" and value < 1e-3 else value
    return f"{told:.0f}{unit}" if told >= 100.0 else f"{told:.3g}{unit}"


def in_degrees(angle_rad: float) -> str:
    """An angle in degrees with three digits."""
    return with_unit(math.degrees(angle_rad))


def limited(said: str, value: float, most: float, beside: str = "", unit: str = "°") -> Judged:
    """Judge a value by the largest one that is allowed, both in rad where they are told in degrees."""
    told, limit = np.degrees(np.minimum([value, most], np.pi)).tolist() if unit == "°" else (float(value), most)
    return bool(value <= most), f"{said} {with_unit(told, unit)} (limit {with_unit(limit, unit)}){beside}", told


def worst(answers: Answers, begin: float = 1.0 / 3.0) -> float:
    """Largest RMS error of several runs after a share of their time, rad."""
    return max(answer.error(begin) for answer in answers)


def tolerated(search: Search, least: float = 0.0) -> float:
    """The error up to which a probe with something in the way is passed, rad, and at least so much."""
    return max(search.floor, least, NEAR * search.chosen.error)
