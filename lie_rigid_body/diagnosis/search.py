"""The search for repairs, and the rule that chooses from all tried repairs those that name the mistakes.

Repairs of the output are tried first, then single repairs of the input, then pairs, within a budget of filter runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain, product
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.course import GYRO_KINDS, REST, Course
from lie_rigid_body.diagnosis.repairs import (
    FITTED,
    JOINT,
    ORDER,
    Answer,
    Job,
    Repair,
    Repairs,
    drifting,
    exact_repairs,
    first_attitude,
    without,
)
from lie_rigid_body.evaluation.causes import CAUSES, IDENTITY, Cause
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.foundation.errors import FilterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass

FLOOR: Final = 0.1
"""Share of the turn between two readings below which errors count as equal, and nothing is looked for."""
MENDED: Final = 0.1
"""Largest share of the error that a repair may leave if the error stays above the floor."""
HALVED: Final = 0.5
"""Largest share of the error that a repair may leave if it brings the error below the floor."""
NEAR: Final = 2.0
"""Factor within which errors above the floor count as equal."""

SCREENED_S: Final = 4.0
"""Length of the motion on which repairs are compared at first, s."""
SCREENED: Final = 100
"""Number of samples of the short motion at which repairs of the output are compared."""
FINALISTS: Final = 4
"""Number of repairs, of the best alone and of the best with a repair of the output, that go on to all courses."""
PRUNING_RATIO: Final = 10.0
"""Multiple of the least error, or of the floor, above which a repair is not tried further."""
BEAM: Final = 8
"""Largest number of repairs, the most promising ones, each of which is paired with every other repair."""
UNCHANGED: Final = 1e-6
"""Change of the estimate, rad, below which a repair has no effect."""
SILENT: Final = 1e-12
"""Factor by which the readings of a sensor vanish beside those that a filter uses."""
QUICK: Final = tuple(cause for cause in CAUSES if cause.code not in ("lagging", "leading", "clock_rate"))
"""Causes that are undone when repairs are first compared; a fit of stamps takes longer, and hides no other repair."""


@short_dataclass(frozen=True, eq=False)
class Trial:
    """Runs with one kind of gyro and with repairs, and the error that they leave.

    Attributes
    ----------
    repairs : tuple of Repair
    kind : str
        The kind of gyro.
    error : float
        RMS of the total error over the last two thirds of all runs, rad.
    parts : tuple of float
        RMS of the error of the vertical, and of that of the turns, rad, where it is known. In the choice of pairs after
        the least that it leaves with one repair of the output. One repair of two may take away one of these alone.
    track : Matched or None
        The estimate on the first course, at those samples that are compared; none where the filter failed.
    unrepaired : sequence of Answer
        What the filter answers on each course where no reading is repaired; else none.
    """

    repairs: Repairs
    kind: str
    error: float
    parts: tuple[float, ...] = ()
    track: Matched | None = None
    unrepaired: Sequence[Answer] = ()

    def changes(self, other: Trial) -> bool:
        """Whether its estimate differs from that of another trial, or the filter failed in one of them."""
        return self.track is None or other.track is None or self.track.max_difference(other.track) > UNCHANGED

    @cached_property
    def mistakes(self) -> Repairs:
        """Repairs that name mistakes: all but `JOINT`."""
        return tuple(repair for repair in self.repairs if repair != JOINT)

    @cached_property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(repair.code for repair in self.mistakes)

    @cached_property
    def rank(self) -> tuple[int, int, list[int]]:
        """Rank of the trial: number of repairs, price, places in the table. The least rank is named."""
        return len(self.codes), sum(repair.price for repair in self.mistakes), sorted(map(ORDER.index, self.codes))


def plain(trials: Iterable[Trial]) -> Trial:
    """Trial without a repair, with the kind of gyro that the filter expects; `JOINT` does not count as a repair."""
    return min((t for t in trials if not t.codes), key=lambda t: t.error)


def choose(trials: Sequence[Trial], floor: float, mended: float = MENDED) -> list[Trial]:
    """Trials that mend the error: first the one that is named, then others of as many repairs that do as well.

    Parameters
    ----------
    trials : sequence of Trial
        Trials that include those without a repair.
    floor : float
        The error below which all count as equal, rad.
    mended : float, optional
        Share of the error that a repair may leave above the floor.
    """
    before = plain(trials).error
    limit = max(mended * before, min(floor, HALVED * before))
    mending = [t for t in trials if t.codes and t.error <= limit]
    if before <= floor or not mending:
        return []
    best = min(t.error for t in mending)
    as_good = [t for t in mending if t.error <= (floor if best <= floor else NEAR * best)]
    named = min(as_good, key=lambda t: (t.rank, t.error))
    return [named, *(t for t in as_good if len(t.codes) == len(named.codes) and t.codes != named.codes)]


class Search:
    """A search under way, whose choice can be asked for at any time.

    Attributes
    ----------
    courses : tuple of Course
        Courses of the runs, with a longer rest before the motion if the filter is right after that.
    floor : float
        The error below which nothing is looked for, rad.
    runs : int
        Number of runs of the filter.
    trials : list of Trial
        Trials on all courses; the first is of the filter as it is.
    is_cut : bool
        Whether pairs were left untried for want of runs.
    begins_alike : bool
        Whether the filter begins with one attitude, whatever it reads. Then the courses begin there too.
    scatter : float
        Largest change of the estimate between two equal runs, rad, where the filter is wrong.
    change : float
        Change of the estimate by sensors that are off by `TINY`, rad, where the filter is unstable; else 0. Then only
        what leaves less than the floor is a repair: where an unstable filter ends tells nothing of a mistake.

    Parameters
    ----------
    each : callable
        Function that runs the filter once for each job.
    courses : tuple of Course
        Ordinary courses; see `courses_of`.
    most_runs : int
        Runs of the filter after which no more pairs are begun.
    tell : callable
        Function that is called with the number of runs after each.
    """

    def __init__(
        self,
        each: Callable[[Sequence[Job]], Iterator[Answer | FilterError]],
        courses: tuple[Course, ...],
        most_runs: int,
        tell: Callable[[int], object] = lambda runs: None,
    ) -> None:
        self._each = each
        self.courses = courses
        self.most_runs = most_runs
        self._tell = tell
        self.floor = FLOOR * float(np.mean([course.turn for course in courses]))
        self.trials: list[Trial] = []
        self.runs = 0
        self.is_cut = False
        self.begins_alike = False
        self.scatter = self.change = 0.0

    def ask(self, jobs: Sequence[Job]) -> Iterator[Answer | FilterError]:
        """Answers of the filter to jobs, in their order."""
        for answer in self._each(jobs):
            self.runs += 1
            self._tell(self.runs)
            yield answer

    def choice(self) -> list[Trial]:
        """Trials so far that mend the error: first the one that is named, then those that do as well."""
        return choose(self.trials, self.floor, 0.0 if self.change else MENDED)

    @property
    def chosen(self) -> Trial:
        """Trial of the filter with its mistakes repaired, or as it is."""
        return next(iter(self.choice()), plain(self.trials))

    @property
    def course(self) -> Course:
        """The first course, with the kind of gyro that the filter expects."""
        return self.courses[0].of_scenario(gyro_rate=self.chosen.kind)

    @property
    def short(self) -> tuple[Course, ...]:
        """The beginning of the first course, on which repairs are compared at first."""
        return (replace(self.courses[0], moving_s=SCREENED_S).nearly_perfect(),)

    def run(self) -> None:
        """Look for repairs if the filter is wrong.

        If it is right from its own first attitude, or after a longer rest, go on with that.
        """
        self.trials += self.fully([()], courses=self.courses)
        exact = self.trials
        if self._is_right_on(self.courses) or any(
            answer.broken.size for trial in (*exact, *self.trials) for answer in trial.unrepaired
        ):
            self.trials = exact
            return
        first = first_attitude(exact[0].unrepaired)
        self.begins_alike = first is not None
        # it may tell the first attitude in another convention
        for begin in [first, IDENTITY.tolist()] * self.begins_alike:
            if self._is_right_on([course.of_scenario(initial_attitude_xyzw=begin) for course in self.courses]):
                return
        before = self.courses, self.trials
        if not self._is_right_on([replace(course, rest_s=3.0 * REST) for course in self.courses]):
            self.courses, self.trials = before
            self.look()

    def _is_right_on(self, courses: Sequence[Course]) -> bool:
        """Go on with some courses and nearly perfect sensors; whether the filter is right there."""
        self.courses = tuple(courses)
        self.trials = list(self.fully([()]))
        return plain(self.trials).error <= self.floor

    def changes(self) -> Iterator[tuple[float, float]]:
        """Changes of the estimate in an equal run, rad, and by nearly perfect sensors, or 0 up to the floor."""
        for kind, repairs in product(GYRO_KINDS, ((), (JOINT,))):
            course = self.courses[0].of_scenario(gyro_rate=kind)
            given = self.ask([Job(each, repairs) for each in (course, course, course.nearly_perfect())])
            exact, again, nearly = (answer if isinstance(answer, Answer) else None for answer in given)
            if exact and again and nearly:
                scatter, change = (exact.track.max_difference(other.track) for other in (again, nearly))
                yield scatter, change if change > max(self.floor, NEAR * scatter) else 0.0

    @property
    def is_by_chance(self) -> bool:
        """Whether equal runs differ by more than what a repair may leave, so that none can be told from chance."""
        return self.scatter > max(self.floor, MENDED * plain(self.trials).error)

    def look(self) -> None:
        """Look for repairs, the cheapest first, until no dearer one can be named instead, or the budget is spent."""
        self.scatter, self.change = np.max([*self.changes(), (0.0, 0.0)], axis=0).tolist()
        if self.is_by_chance:
            return
        self.trials += self.fully([()], CAUSES)
        if self._is_mended(1):
            return
        ((unrepaired,),) = self.tried([((), self.short)])
        singles = self._screened([(repair,) for repair in exact_repairs()], QUICK)
        changing = [trial.mistakes[0] for trial in singles if trial.changes(unrepaired)]
        if not self._is_mended(1):
            singles += self._fitted_beside(())
        firsts = [trial.mistakes for trial in _most_promising(singles)[:BEAM]]
        beside = [[(*first, repair) for repair in changing if repair.code != first[0].code] for first in firsts]
        for step in (
            *(partial(self._screened, pairs) for pairs in beside),
            *(partial(self._fitted_beside, first) for first in firsts),
        ):
            if self._is_mended(2) or not self._may_go_on():
                return
            step()

    def _may_go_on(self) -> bool:
        """Whether the budget allows more runs; `is_cut` keeps a refusal."""
        self.is_cut = self.runs >= self.most_runs
        return not self.is_cut

    def _is_mended(self, count: int) -> bool:
        """Whether so few repairs, without a constant, leave less than the floor: no later one is named instead."""
        return any(t.error <= self.floor and t.rank[:2] <= (count, 0) for t in self.choice()[:1])

    def _fitted_beside(self, first: Repairs) -> list[Trial]:
        """Try repairs with a fitted constant, alone, then also with those of the output, or beside another."""
        causes = () if first else QUICK
        rests = (first, (*first, JOINT))
        pairs = [(code, rest) for code in FITTED if code not in [each.code for each in first] for rest in rests]
        return self._screened(
            [(self._fitted(code, rest, causes), *rest) for code, rest in pairs if self._may_go_on()], causes
        )

    def _screened(self, chosen: Sequence[Repairs], causes: Sequence[Cause] = ()) -> list[Trial]:
        """Try repairs on the short course, and each with some causes in the output; then the best on all courses."""
        if not chosen:
            return []
        found = list(self.tried([(repairs, self.short) for repairs in chosen], causes))
        least = {trials[0]: min(trials, key=lambda trial: trial.error) for trials in found}
        best = sorted(least, key=lambda trial: least[trial].error)[:FINALISTS]
        alone = sorted(least, key=lambda trial: trial.error)[:FINALISTS]  # else an output's repair hides them
        far = PRUNING_RATIO * max(self.floor, least[best[0]].error)
        promising = [trial for trial in dict.fromkeys((*alone, *best)) if least[trial].error <= far]
        finals = dict.fromkeys(trial.mistakes for trial in promising if self._uses_what_it_scales(least[trial]))
        self.trials += self.fully(finals, CAUSES if causes else ())
        return [replace(trial, parts=(with_output.error, *trial.parts)) for trial, with_output in least.items()]

    def _uses_what_it_scales(self, trial: Trial) -> bool:
        """Whether each sensor that a repair rescales is heard, and the filter does not normalise it.

        A repair that makes a sensor nearly silent also mends a wrong correction. But it leaves the error of a
        drift of the gyro that only this sensor corrects, or enlarges it. A repair that makes a sensor huge also
        drowns a constant that the filter adds to it. But if the filter normalises it, no unit is wrong, and
        half of the factor does as well. Both changes of the error have to be more than the floor, as smaller
        errors change by chance. The second has to be more than twice what the repair leaves, too: half of the
        factor leaves twice of such a constant.
        """
        costs = (
            self.drift_costs(repair.code.removesuffix("_units"), trial.repairs)
            for repair in trial.mistakes
            if repair.code.endswith("_units")
        )
        return all(silence > self.floor and abs(half) > max(self.floor, NEAR * trial.error) for silence, half in costs)

    def drift_costs(self, sensor: str, repairs: Repairs) -> tuple[float, float]:
        """Increases of the error, rad, by a silent sensor and by half of its readings, in a drift it alone tells."""
        drifts = [Repair("", "", 0, partial(drifting, sensor, share), "", "") for share in (1.0, SILENT, 0.5)]
        used, silenced, halved = (trial.error for (trial,) in self.tried([((d, *repairs), self.short) for d in drifts]))
        return silenced - used, halved - used

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

    def _fitted(self, code: str, rest: Repairs, causes: Sequence[Cause]) -> Repair:
        """The best constant of a repair beside others, and perhaps one of the output."""
        of, tried = FITTED[code]

        def left(values: Iterable[float]) -> list[float]:
            asked = [((of(value), *rest), self.short) for value in values]
            return [min(trial.error for trial in trials) for trials in self.tried(asked, causes)]

        place = int(np.argmin(left(tried)))
        low = tried[max(0, place - 1)]
        high = tried[min(len(tried) - 1, place + 1)]
        if code == "time_step":
            best: float = scipy.optimize.minimize_scalar(
                lambda value: left([value])[0] ** 2, bounds=(low, high), method="bounded"
            ).x
        else:
            between = [count for count in range(int(low), int(high) + 1) if count]
            best = between[int(np.argmin(left(between)))]
        return of(best)

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
        answers = self.ask([Job(course, repairs) for repairs, courses in asked for course in courses])
        for repairs, courses in asked:
            given = [next(answers) for _ in courses]
            kind = courses[0].parameter("gyro_rate")
            failed = [answer for answer in given if isinstance(answer, FilterError)]
            if failed and not repairs:
                raise failed[0]
            right = [answer for answer in given if isinstance(answer, Answer) and not (repairs and answer.broken.size)]
            if len(right) < len(courses):
                yield [Trial(repairs, kind, np.pi, (np.pi, np.pi))]
                continue
            tracks = [answer.track.fraction() for answer in right]
            parts = tracks[0].partial_errors()
            if courses == self.short:
                tracks = [each.thinned(SCREENED) for each in tracks]
            alone = Trial(repairs, kind, error_of(tracks), parts, tracks[0], () if repairs else right)
            yield [
                alone,
                *(
                    Trial((*repairs, *outputs), kind, error)
                    for outputs, error in without(tracks, causes, pairs=not alone.codes)
                ),
            ]


def _most_promising(trials: Sequence[Trial]) -> list[Trial]:
    """Order trials by their best rank in any error: with a repair of the output, of the vertical, of the turns."""
    errors = np.array([trial.parts for trial in trials])
    places = np.argsort(np.argsort(errors, axis=0, kind="stable"), axis=0).min(axis=1)
    return [trials[number] for number in np.argsort(places, kind="stable")]
