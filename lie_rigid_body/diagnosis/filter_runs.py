"""Runs of a filter with repairs, within a budget: trials on courses with the rest that the filter needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice, product
from typing import Any, Final

import numpy as np

from lie_rigid_body.diagnosis.answers import CALM, Answer, Job
from lie_rigid_body.diagnosis.course import GYRO_KINDS, MOVING, Course
from lie_rigid_body.diagnosis.outputs import without
from lie_rigid_body.diagnosis.repairs import JOINT, Repair, Repairs
from lie_rigid_body.diagnosis.trials import MENDED, Trial, choose, plain
from lie_rigid_body.evaluation.causes import Cause
from lie_rigid_body.evaluation.matched import error_of
from lie_rigid_body.foundation.errors import FilterError

FLOOR: Final = 0.1
"""Share of the turn between two readings below which errors count as equal, and nothing is looked for."""
FIRST_REST: Final = 8.0
"""Rest that a filter is given at first to settle, s."""
MAX_REST: Final = 300.0
"""Longest rest that it is given, s."""
SCREENED_REST: Final = 10.0
"""Longest rest before the short motion on which repairs are compared at first, s."""
MAX_UPDATES: Final = 410_000
"""Readings of the gyro after which no more pairs are tried; situations and probes take up to 190 000 more."""
UNPROBED: Final = 50_000
"""Readings that may be more where the error is above `UNJUDGED`, so that most probes are not judged."""
MAX_UPDATES_SETTLING: Final = 1_600_000
"""Readings after which no more are tried of a filter that needs more than `CALM` seconds to settle."""
UNJUDGED: Final = math.radians(20.0)
"""Error of the filter, rad, above which a factor of the gyro near 1 explains nothing, and probes say nothing."""
SCREENED_S: Final = 4.0
"""Length of the motion on which repairs are compared at first, s."""
SCREENED: Final = 100
"""Number of samples of the short motion at which repairs of the output are compared."""


class FilterRuns:
    """Runs of a filter on courses with repairs, and what is known of them.

    Attributes
    ----------
    courses : tuple of Course
        Courses of the runs, each with the rest that the filter needs to settle.
    floor : float
        The error below which nothing is looked for, rad.
    runs, updates : int
        Number of runs of the filter, and of readings of the gyro in them.
    trials : list of Trial
        Trials on all courses; the first is of the filter as it is.
    is_cut : bool
        Whether pairs were left untried for want of runs.
    is_rest_cut : bool
        Whether repairs were tried after a shorter rest than the filter needs.
    is_slow : bool
        Whether it begins with one attitude, and takes more than `FIRST_REST` to come from there to another.
    is_level : bool
        Whether the magnetometer changes nothing: the vertical alone is judged.
    growth : float
        Change of the estimate by sensors that are off by `TINY`, rad, where the filter is unstable; else 0. Then only
        what leaves less than the floor is a repair: where an unstable filter ends tells nothing of a mistake.
    chatter : float
        Motion of the answer at rest, or change of it by sensors that are off by `TINY`, rad, that does not grow.
    known : dict
        Answers to probes, by the course.

    Parameters
    ----------
    each : callable
        Function that runs the filter once for each job.
    courses : tuple of Course
        Ordinary courses; see `courses_of`.
    most_runs : int
        Runs of the filter after which no more pairs are begun.
    tell : callable, optional
        Function that is called with the number of runs after each.
    noise : mapping of str to float, optional
        Densities of the noise that the filter assumes, where they are given.
    """

    runs = updates = 0
    is_cut = is_rest_cut = is_level = is_slow = False
    growth = chatter = 0.0

    def __init__(
        self,
        each: Callable[[Sequence[Job]], Iterator[Answer | FilterError]],
        courses: tuple[Course, ...],
        most_runs: int,
        tell: Callable[[int], object] | None = None,
        noise: Mapping[str, float] | None = None,
    ) -> None:
        self._each = each
        self.courses = courses
        self.most_runs = most_runs
        self._tell = tell or (lambda runs: None)
        self.noise = noise
        self.floor = FLOOR * float(np.mean([course.turn for course in courses]))
        self.trials: list[Trial] = []
        self.known: dict[Course, Answer | FilterError] = {}
        self._rests: dict[Any, float] = {}

    def ask(self, asked: Iterable[tuple[Course, Repairs]]) -> Iterator[Answer | FilterError]:
        """Answers of the filter to courses with repairs, in their order."""
        jobs = [Job(*each, self.is_level) for each in asked]
        for job, answer in zip(jobs, self._each(jobs), strict=True):
            self.runs += 1
            self.updates += job.course.updates
            self._tell(self.runs)
            yield answer

    def answer(self, course: Course, *repairs: Repair) -> Answer | None:
        """Answer of the filter to one course, or None where it fails."""
        [answer] = self.ask([(course, repairs)])
        return answer if isinstance(answer, Answer) else None

    def choice(self) -> list[Trial]:
        """Trials so far that mend the error: first the one that is named, then those that do as well."""
        return choose(self.trials, self.floor, 0.0 if self.growth else MENDED)

    @property
    def unrepaired(self) -> Trial:
        """Trial of the filter as it is."""
        return plain(self.trials)

    @property
    def chosen(self) -> Trial:
        """Trial of the filter with its mistakes repaired, or as it is."""
        return next(iter(self.choice()), self.unrepaired)

    @property
    def course(self) -> Course:
        """The first course, with the kind of gyro that the filter expects."""
        return self.courses[0].of_scenario(gyro_rate=self.chosen.kind)

    @property
    def long(self) -> Course:
        """The first course with a motion ten times as long."""
        return replace(self.course, moving_s=10.0 * self.course.moving_s)

    @property
    def short(self) -> tuple[Course, ...]:
        """The beginning of the first course, on which repairs are compared at first."""
        settle_s = min(self.courses[0].settle_s, SCREENED_REST)
        return (replace(self.courses[0], moving_s=SCREENED_S, settle_s=settle_s).nearly_perfect(),)

    @property
    def settles_s(self) -> float:
        """Longest rest that the filter needs on an ordinary course, s."""
        return max(course.settle_s for course in self.courses)

    @property
    def longest_rest_s(self) -> float:
        """Longest rest that the filter needs in any attitude and field that was tried, s."""
        return max((rest for (*_, off), rest in self._rests.items() if not off), default=0.0)

    def settled(self, course: Course, least_s: float = FIRST_REST) -> Course:
        """The course with a rest, doubled until the filter has settled in half of it, to `MAX_REST` at most."""
        if not course.ramp_s:
            return course
        key = tuple(course.parameter("initial_attitude_xyzw")), tuple(course.field), course.off
        if key not in self._rests:
            rest = max(least_s, self.settles_s)
            while (
                (settled := self._settled_s(course, rest)) > 0.5 * rest
                and rest < MAX_REST
                and self.updates < 1.5 * self.most_updates
            ):
                rest = min(2.0 * rest, MAX_REST)
            self._rests[key] = rest if settled else 0.0
        return replace(course, settle_s=self._rests[key])

    def _settled_s(self, course: Course, rest: float) -> float:
        answer = self.answer(replace(course, settle_s=rest, moving_s=0.0, gaps_s=()))
        if answer and answer.settled_s < np.inf and answer.restless > self.floor:
            self.chatter = max(self.chatter, answer.restless)
        return answer.settled_s if answer else 0.0

    def _named(self, causes: Iterable[Cause]) -> list[Cause]:
        """Causes in the output that may be named: without constants, where the heading is not judged."""
        return [cause for cause in causes if not (self.is_level and cause.price)]

    @property
    def most_updates(self) -> int:
        """Readings of the gyro after which no more pairs are begun."""
        most = MAX_UPDATES_SETTLING if self.is_slow or self.settles_s > CALM else MAX_UPDATES
        return most + UNPROBED * (bool(self.trials) and self.unrepaired.error > UNJUDGED)

    @property
    def affordable(self) -> int:
        """Number of runs of the short course for which readings are left."""
        return max(0, self.most_updates - self.updates) // self.short[0].updates

    def _affordable(self, count: int) -> list[Course]:
        """Courses of nearly perfect sensors, their rest cut so that so many repairs take half of the updates left."""
        runs = max(1, 2 * len(GYRO_KINDS) * len(self.courses) * count)
        rest_s = max(0.5 * (self.most_updates - self.updates) / runs / self.courses[0].rate - MOVING, SCREENED_REST)
        self.is_rest_cut |= rest_s < self.settles_s
        return [replace(each, settle_s=min(each.settle_s, rest_s)).nearly_perfect() for each in self.courses]

    def fully(
        self, chosen: Iterable[Repairs], causes: Sequence[Cause] = (), *, courses: Sequence[Course] = ()
    ) -> Iterator[Trial]:
        """Try repairs on some courses with both kinds of gyro, with and without `JOINT`.

        All courses are the default, with nearly perfect sensors, on which an unstable filter fails.
        """
        jointly = [(*repairs, *joint) for repairs in chosen for joint in ((), (JOINT,))]
        courses = courses or [course.nearly_perfect() for course in self.courses]
        by_kind = [tuple(course.of_scenario(gyro_rate=kind) for course in courses) for kind in GYRO_KINDS]
        return chain.from_iterable(self.tried([*product(jointly, by_kind)], causes))

    def tried(
        self, asked: Sequence[tuple[Repairs, tuple[Course, ...]]], causes: Sequence[Cause] = ()
    ) -> Iterator[list[Trial]]:
        """Trials of repairs on courses of one kind: as they are, then with each cause undone in the output.

        Where no input is repaired pairs of causes are undone as well.

        Raises
        ------
        FilterError
            If the filter fails without a repair.
        """
        answers = self.ask([(course, repairs) for repairs, courses in asked for course in courses])
        for repairs, courses in asked:
            kind = courses[0].parameter("gyro_rate")
            right = list[Answer]()
            for answer in islice(answers, len(courses)):
                if isinstance(answer, Answer) and not (repairs and answer.broken.size):
                    right.append(answer)
                elif isinstance(answer, FilterError) and not repairs:
                    raise answer
            if len(right) < len(courses):
                yield [Trial(repairs, kind, np.pi, (np.pi, np.pi))]
                continue
            tracks = [answer.track.fraction() for answer in right]
            parts = tracks[0].partial_errors()
            if courses == self.short:
                tracks = [each.thinned(SCREENED) for each in tracks]
            unrepaired = right if repairs in ((), (JOINT,)) else ()
            alone = Trial(repairs, kind, error_of(tracks), parts, tracks[0], unrepaired)
            undone = without(tracks, self._named(causes), pairs=not alone.codes)
            yield [alone, *(Trial((*repairs, *outputs), kind, error) for outputs, error in undone)]
