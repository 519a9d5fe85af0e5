"""The search for repairs: those of the output, single ones of the input, then pairs, within a budget of filter runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.optimize import minimize_scalar

from lie_rigid_body.diagnosis.course import KINDS, Course, of_kind
from lie_rigid_body.diagnosis.filter import Answer, FilterError, Job
from lie_rigid_body.diagnosis.repairs import FITTED, JOINT, Repair, exact_repairs
from lie_rigid_body.diagnosis.trial import Choice, Outputs, Trial, choose
from lie_rigid_body.evaluation.causes import CAUSES, Cause, Track, Tracks, error_of

SCREENED_S: Final = 4.0
"""Length of the motion on which repairs are compared at first, s."""
SCREENED: Final = 100
"""Samples of it at which repairs of the output are compared."""
FINALISTS: Final = 6
"""Number of repairs that are then tried on all courses, of those that are best alone, and with one of the output."""
FAR: Final = 10.0
"""Factor of the least error, or of the floor, above which a repair is not tried further."""
BEAM: Final = 8
"""Largest number of repairs of which each is tried together with every other one."""
UNCHANGED: Final = 1e-6
"""Change of the error, rad, below which a repair is none."""
FINEST_FACTOR: Final = 1e-6
"""Accuracy to which a factor is fitted."""
_OF_TIME: Final = ("lagging", "leading", "clock_rate")
QUICK: Final = tuple(cause for cause in CAUSES if cause.code not in _OF_TIME)
"""Causes that are undone in the first comparison; a fit of stamps takes longer, and hides no other repair."""

Repairs = tuple[Repair, ...]
Ask = Callable[[Sequence[Job]], Iterator[Answer | FilterError]]
"""Runs the filter, as many times as there are jobs."""


def track(course: Course, answer: Answer) -> Track:
    """What a filter answered, beside the truth."""
    return Track(answer.stamps_ns, answer.attitude_xyzw, course.truth)


def settled(whole: Track) -> Track:
    """The last two thirds of the samples, by which a filter has converged."""
    return whole.part(slice(len(whole.stamps_ns) // 3, None))


class Search:
    """A search under way; what was found so far can be asked for at any time.

    Attributes
    ----------
    trials : list of Trial
        Those on all courses.
    is_cut : bool
        Whether pairs were left untried for want of runs.

    Parameters
    ----------
    ask : callable
    courses : tuple of Course
        The ordinary ones, with an integrated gyro.
    floor : float
        The error below which nothing is looked for, rad.
    has_room : callable
        Whether the budget allows more runs of the filter.
    """

    def __init__(self, ask: Ask, courses: tuple[Course, ...], floor: float, has_room: Callable[[], bool]) -> None:
        self._ask, self._courses, self._floor, self._has_room = ask, courses, floor, has_room
        self._short = (replace(courses[0], moving_s=SCREENED_S),)
        self._exact = exact_repairs()
        self.trials: list[Trial] = []
        self.is_cut = False

    def choice(self) -> Choice | None:
        """What is named so far."""
        return choose(self.trials, self._floor)

    def run(self) -> None:
        """Look for repairs, the cheapest first, until no dearer one can be named instead, or the budget is spent."""
        self.fully([()], CAUSES, pairs=True)
        if self._is_mended(1, 0):
            return
        ((plain, *_),) = self.tried([((), self._short)])
        singles = self._with_every_other(())
        changing = {trial.inputs[0] for trial in singles if abs(trial.error - plain.error) > UNCHANGED}
        self._exact = tuple(repair for repair in self._exact if repair in changing)
        for first in sorted(singles, key=lambda trial: self._cost(trial, plain))[:BEAM]:
            if self._is_mended(2, 0):
                return
            self.is_cut = not self._has_room()
            if self.is_cut:
                return
            self._with_every_other(first.inputs)

    def _is_mended(self, count: int, price: int) -> bool:
        """Whether so few and so cheap repairs leave an error below the floor: then no later one is named instead."""
        choice = self.choice()
        return choice is not None and choice.named.error <= self._floor and choice.named.rank[:2] <= (count, price)

    def _cost(self, trial: Trial, plain: Trial) -> float:
        """Least share that a repair leaves of an error: of the whole, the vertical's, or the turns'."""
        pairs = zip((trial.error, *trial.parts), (plain.error, *plain.parts), strict=True)
        return min((left + self._floor) / (before + self._floor) for left, before in pairs)

    def _with_every_other(self, first: Repairs) -> list[Trial]:
        """Try each repair of the input beside others; those with a constant where none without mends the error."""
        known = [repair.code for repair in first]
        found = self._screened([(*first, repair) for repair in self._exact if repair.code not in known])
        if not self._is_mended(len(first) + 1, 0):
            codes = [code for code in FITTED if code not in known]
            rests = [(*first, *joint) for joint in ((), (JOINT,))]
            found += self._screened([(self._fitted(code, rest), *rest) for code in codes for rest in rests])
        return found

    def _screened(self, chosen: Sequence[Repairs]) -> list[Trial]:
        """Try repairs shortly, a single one also with each of the output's, and the best of them on all courses."""
        single = all(len(set(repairs) - {JOINT}) == 1 for repairs in chosen)
        found = list(self.tried([(repairs, self._short) for repairs in chosen], QUICK if single else ()))
        least = {trials[0]: min(trial.error for trial in trials) for trials in found}
        best = sorted(least, key=least.__getitem__)[:FINALISTS]
        alone = sorted(least, key=lambda trial: trial.error)[:FINALISTS]  # else an output's repair hides them
        far = FAR * max(self._floor, least[best[0]])
        finals = dict.fromkeys(trial.inputs for trial in (*alone, *best) if least[trial] <= far)
        self.fully(finals, CAUSES if single else ())
        return list(least)

    def fully(self, chosen: Iterable[Repairs], causes: Sequence[Cause] = (), *, pairs: bool = False) -> None:
        """Try repairs on all courses, with both kinds of gyro, with and without `JOINT`."""
        by_kind = [of_kind(self._courses, kind) for kind in KINDS]
        jointly = [(*repairs, *joint) for repairs in chosen for joint in ((), (JOINT,))]
        for found in self.tried([(each, courses) for each in jointly for courses in by_kind], causes, pairs=pairs):
            self.trials += found

    def _fitted(self, code: str, rest: Repairs) -> Repair:
        """The best constant of a repair beside others."""
        of, tried = FITTED[code]

        def left(values: Iterable[float]) -> list[float]:
            return [each[0].error for each in self.tried([((of(value), *rest), self._short) for value in values])]

        place = int(np.argmin(left(tried)))
        low, high = tried[max(0, place - 1)], tried[min(len(tried) - 1, place + 1)]
        if code == "time_step":
            options = {"xatol": FINEST_FACTOR, "maxiter": 40}
            best = minimize_scalar(lambda x: left([x])[0] ** 2, bounds=(low, high), method="bounded", options=options).x
        else:
            between = [count for count in range(int(low), int(high) + 1) if count]
            best = between[int(np.argmin(left(between)))]
        return of(float(best))

    def tried(
        self, asked: Sequence[tuple[Repairs, tuple[Course, ...]]], causes: Sequence[Cause] = (), *, pairs: bool = False
    ) -> Iterator[list[Trial]]:
        """Trials of repairs on courses of one kind, the first alone, the others with a cause in the output undone.

        Raises
        ------
        FilterError
            If the filter fails without a repair.
        """
        answers = self._ask([Job(course, repairs) for repairs, courses in asked for course in courses])
        for repairs, courses in asked:
            tracks, right, kind = [], True, courses[0].kind
            for course in courses:
                answer = next(answers)
                if isinstance(answer, FilterError) and not repairs:
                    raise answer
                right = right and isinstance(answer, Answer) and not answer.broken.size
                tracks += [settled(track(course, answer))] if isinstance(answer, Answer) else []
            if not right:
                yield [Trial(repairs, (), kind, np.pi, (np.pi, np.pi))]
                continue
            parts, few = tracks[0].partial_errors(), [each.few(SCREENED) for each in tracks]
            compared = few if courses == self._short else tracks
            undone = _undone(compared, causes, pairs=pairs)
            alone = Trial(repairs, (), kind, error_of(compared), parts)
            yield [alone, *(Trial(repairs, outputs, kind, error) for outputs, error in undone)]


def _undone(tracks: Tracks, causes: Iterable[Cause], *, pairs: bool) -> Iterator[tuple[Outputs, float]]:
    """Each cause, or every two of which the first has no constant, with what is left without them."""
    for cause in causes:
        constants, error = cause.fitted(tracks)
        undone = ((cause.code, tuple(constants.tolist())),)
        yield undone, error
        if pairs and not cause.price:
            without = [cause.undo(track, constants) for track in tracks]
            others = (other for other in CAUSES if other.code != cause.code)
            yield from ((undone + second, left) for second, left in _undone(without, others, pairs=False))
