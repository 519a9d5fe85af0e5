"""The search for repairs, and the rule that chooses from all tried repairs those that name the mistakes.

Repairs of the output are tried first, then single repairs of the input, then pairs, within a budget of filter runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.answers import first_attitude
from lie_rigid_body.diagnosis.course import NOISE, Course
from lie_rigid_body.diagnosis.filter_runs import FIRST_REST, UNJUDGED, FilterRuns
from lie_rigid_body.diagnosis.outputs import CODED, OUTPUTS, without
from lie_rigid_body.diagnosis.repairs import (
    FITTED,
    HALVED,
    JOINT,
    SCALE,
    SENSOR_READINGS,
    Repair,
    Repairs,
    drifting,
    exact_repairs,
    factor,
    perturbed,
    scaled,
)
from lie_rigid_body.diagnosis.trials import MENDED, NEAR, UNCHANGED, Trial, alone, most_promising, plain
from lie_rigid_body.evaluation.causes import CAUSES, Cause
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.lie import quaternion
from lie_rigid_body.sensors import GRADES

SCALES: Final = (1e-6, 1e-4, 1e-2, 1.0)
"""Factors of the gyro with which turns of the estimate are compared with those of the body."""
STEP: Final = 1.2
"""Factor around the best of the factors that are tried, in which one is fitted."""
FINE: Final = 1.05
"""Factor around that in which it is fitted once more, on an ordinary course."""
ASIDE: Final = quaternion.exp(np.radians([0.06, -0.08, 0.1]))
"""Quaternion by which a body begins beside the first attitude of a filter, where some filters fail."""
FINALISTS: Final = 4
"""Number of repairs, of the best alone and of the best with a repair of the output, that go on to all courses."""
PRUNING_RATIO: Final = 10.0
"""Multiple of the least error, or of the floor, above which a repair is not tried further."""
BEAM: Final = 8
"""Largest number of repairs, the most promising ones, each of which is paired with every other repair."""
SILENT: Final = 1e-12
"""Factor by which the readings of a sensor vanish beside those that a filter uses."""
GRADE_OF_NOISE: Final = {name: GRADES["tactical"][name] for name in NOISE}
"""Densities of the noise of tactical sensors."""
QUICK: Final = tuple(cause for cause in CAUSES if cause.code not in ("lagging", "leading", "clock_rate"))
"""Causes that are undone when repairs are first compared; a fit of stamps takes longer, and hides no other repair."""


class Search(FilterRuns):
    """A search under way, whose choice can be asked for at any time. See `FilterRuns` for the parameters.

    Attributes
    ----------
    free : Trial
        The filter as it is on the free motions, without a rest.
    deaf : tuple of str
        Sensors whose readings change nothing after the first second.
    scatter : float
        Largest change of the estimate between two equal runs, rad, where the filter is wrong.
    unstable_by : str
        The sensor whose correction has the wrong sign, where that is known.
    needs_rest : bool
        Whether its answer stands still from the first second on, and it is right only after a longer rest.
    needs_noise : bool
        Whether perfect readings give no answer, and those of tactical sensors do.
    """

    free: Trial
    needs_noise = needs_rest = False
    deaf: tuple[str, ...] = ()
    scatter = 0.0
    unstable_by = ""
    _short_error = np.pi
    _scaled_beside: tuple[tuple[str, ...], ...] = ()

    def in_order(self, trial: Trial) -> Repairs:
        """Repairs of a trial, the one with the largest effect first; those of the output in their order."""
        if all(each.change is None for each in trial.mistakes):
            return trial.mistakes
        return tuple(sorted(trial.mistakes, key=partial(alone, self.trials)))

    @property
    def most_helpful(self) -> Trial | None:
        """Trial with the one repair that leaves the least, if that is less than half of the error."""
        least = min((t for t in self.trials if len(t.codes) == 1), key=lambda t: t.error, default=None)
        return least if least and least.error <= HALVED * self.unrepaired.error else None

    def run(self) -> None:
        """Look for repairs if the filter is wrong, also after it has settled at rest."""
        free = list(self.fully([()], courses=[course.free() for course in self.courses]))
        self.trials = free
        self.free = plain(free)
        if any(answer.broken.size for trial in free for answer in trial.unrepaired):
            noisy = self.answer(self.courses[0].of_scenario(**GRADE_OF_NOISE))
            self.needs_noise = noisy is not None and not noisy.broken.size
            return
        self._hear()
        settled = self._settled()
        self.trials = list(self.fully([()], courses=settled))
        if self.free.error <= self.floor < self.unrepaired.error:  # it knows that the body is free
            self.courses = tuple(course.free() for course in self.courses)
            self.trials = free
            return
        if self.unrepaired.error > self.floor and not any(course.settle_s for course in settled):
            rested = [replace(course, settle_s=FIRST_REST) for course in settled]
            trials = list(self.fully([()], courses=rested))
            self.needs_rest = plain(trials).error <= HALVED * self.unrepaired.error
            if self.needs_rest:
                settled = rested
                self.trials = trials
        self.courses = tuple(settled)
        self._compare()
        if self.unrepaired.error > self.floor and not self.is_by_chance:
            self.look()

    def _settled(self) -> list[Course]:
        """The courses with the rest that the filter needs.

        Where it begins with one attitude, they begin near that: a slow filter whose readings are repaired has settled
        there at once.
        """
        courses = self.courses
        if (first := first_attitude(self.free.unrepaired)) is not None:
            starts = quaternion.multiply(first, [ASIDE, quaternion.conjugate(ASIDE)]).tolist()
            self.is_slow = self._settled_s(courses[0], FIRST_REST) == np.inf
            each = zip(courses, starts, strict=False)
            courses = tuple(course.of_scenario(initial_attitude_xyzw=start) for course, start in each)
        return [self.settled(course) for course in courses]

    def _hear(self) -> None:
        """Find the sensors that change nothing after the first second, and whether the magnetometer ever does."""
        course = self.courses[0]
        unchanged = self.answer(course)

        def is_deaf(sensor: str, since_ns: int) -> bool:
            answer = self.answer(course, Repair(change=partial(perturbed, sensor, since_ns)))
            return bool(answer and unchanged and answer.track.max_difference(unchanged.track) <= UNCHANGED)

        self.deaf = tuple(sensor for sensor in SENSOR_READINGS if is_deaf(sensor, round(1e9 * course.rest_s)))
        self.is_level = "magnetometer" in self.deaf and is_deaf("magnetometer", -(2**62))

    def _compare(self) -> None:
        """Compare equal runs, and runs of nearly perfect sensors: by chance, chatter, or a change that grows."""
        best = self.unrepaired
        course = self.course
        nearly_long_course = self.long.nearly_perfect()
        exact, again, nearly, long, nearly_long = (
            self.answer(each, *best.repairs)
            for each in (course, course, course.nearly_perfect(), self.long, nearly_long_course)
        )
        if not (exact and again and nearly):
            return
        self.scatter = exact.track.max_difference(again.track)
        change = exact.track.differences(nearly.track)
        later = (long or exact).track.differences((nearly_long or nearly).track)
        third = len(change) // 3
        level = rms(change[-third:])
        growth = rms(later[-len(later) // 3 :])
        grows = level > NEAR * rms(change[:third]) or growth > NEAR * level
        if grows and max(level, growth) > max(self.floor, NEAR * best.error, NEAR * self.scatter):
            self.growth = max(level, growth)
            most = max(self.floor, MENDED * (nearly_long.error(0.9) if nearly_long else np.pi))
            for sensor in ("accelerometer", "magnetometer"):
                answer = self.answer(nearly_long_course, scaled(sensor, -1.0), *best.repairs)
                if answer and answer.error(0.9) <= most:
                    self.unstable_by = sensor
                    break
        elif UNJUDGED >= np.median(change[-third:]) > max(self.floor, NEAR * self.scatter):
            self.chatter = max(self.chatter, float(change.max()))  # rare jumps and unrelated attitudes are no chatter

    @property
    def is_by_chance(self) -> bool:
        """Whether equal runs differ by more than what a repair may leave, so that none can be told from chance."""
        return self.scatter > max(self.floor, MENDED * self.unrepaired.error)

    def look(self) -> None:
        """Look for repairs, the cheapest first, until no dearer one can be named instead, or the budget is spent."""
        self.trials += [
            Trial((*trial.repairs, *outputs), trial.kind, error)
            for trial in self.trials
            for outputs, error in without(
                [answer.track.fraction() for answer in trial.unrepaired], self._named(OUTPUTS), pairs=True
            )
        ]
        self._scaled()
        if self._is_mended(1):
            return
        ((unrepaired,),) = self.tried([((), self.short)])
        self._short_error = unrepaired.error
        # axes of a sensor that only the first answer hears change that alone; another unit may pass a gate
        heard = [each for each in exact_repairs() if each.code not in [f"{sensor}_axes" for sensor in self.deaf]]
        singles = self._screened([(each,) for each in heard], QUICK)
        changing = [trial.mistakes[0] for trial in singles if trial.changes(unrepaired)]
        self._scaled()
        if not self._is_mended(1):
            singles += self._fitted_beside(())
        firsts = [trial.mistakes for trial in most_promising(singles)[:BEAM]]
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
        self.is_cut = self.runs >= self.most_runs or not self.affordable
        return not self.is_cut

    def _is_mended(self, count: int) -> bool:
        """Whether so few repairs leave less than the floor that no later one is named instead; of two one is fitted."""
        limit = (count, count - 1)
        return any(t.error <= self.floor and (len(t.codes) < count or t.rank[:2] <= limit) for t in self.choice()[:1])

    def _fitted_beside(self, first: Repairs) -> list[Trial]:
        """Try repairs with a fitted constant, alone, then also with those of the output, or beside another."""
        causes = () if first else QUICK
        chosen = list[Repairs]()
        for code, rest in product(FITTED, (first, (*first, JOINT))):
            if code not in [each.code for each in first] and self._may_go_on():
                repair = self._fitted(code, rest, causes)
                if not repair.is_near_another:
                    chosen.append((repair, *rest))
        return self._screened(chosen, causes)

    def _screened(self, chosen: Sequence[Repairs], causes: Sequence[Cause] = ()) -> list[Trial]:
        """Try repairs on the short course, and each with some causes in the output; then the best on all courses."""
        chosen = chosen[: self.affordable]
        if not chosen:
            return []
        found = list(self.tried([(repairs, self.short) for repairs in chosen], causes))
        least = {trials[0]: min(trials, key=lambda trial: trial.error) for trials in found}
        best = sorted(least, key=lambda trial: least[trial].error)[:FINALISTS]
        alone = sorted(least, key=lambda trial: trial.error)[:FINALISTS]  # else an output's repair hides them
        far = min(PRUNING_RATIO * max(self.floor, least[best[0]].error), max(self.floor, HALVED * self._short_error))
        finals = [
            trial.mistakes
            for trial in dict.fromkeys((*alone, *best))
            if least[trial].error <= far and self._uses_what_it_scales(least[trial])
        ]
        known = {trial.mistakes for trial in self.trials}
        singles = [(each,) for repairs in finals for each in repairs if (each,) not in known]
        wanted = list(dict.fromkeys([*singles, *finals]))
        self.trials += self.fully(wanted, causes and CAUSES, courses=self._affordable(len(wanted)))
        return [replace(trial, parts=(with_output.error, *trial.parts)) for trial, with_output in least.items()]

    def _uses_what_it_scales(self, trial: Trial) -> bool:
        """Whether each sensor that a repair rescales is heard, and the filter does not normalise it.

        A repair that makes a sensor nearly silent also mends a wrong correction. But it leaves the error of a
        drift of the gyro that only this sensor corrects, or enlarges it. A repair that makes a sensor huge also
        drowns a constant that the filter adds to it. But if the filter normalises it, no unit is wrong, and
        half of the factor does as well. Both changes of the error have to be more than the floor, as smaller
        errors change by chance. The second has to be more than twice what the repair leaves, too: half of the
        factor leaves twice of such a constant. Of a time step the first is asked alone.
        """
        for repair in trial.mistakes:
            sensor, _, kind = repair.code.rpartition("_")
            if kind in ("units", "step"):
                silence, half = self.drift_costs("gyro" if kind == "step" else sensor, trial.repairs)
                is_sized = kind == "step" or abs(half) > max(self.floor, NEAR * trial.error)
                if silence <= self.floor or not is_sized:
                    return False
        return True

    def drift_costs(self, sensor: str, repairs: Repairs) -> tuple[float, float]:
        """Increases of the error, rad, by a silent sensor and by half of its readings, in a drift it alone tells."""
        drift = Repair(change=partial(drifting, sensor))
        asked = [((drift, scaled(sensor, share), *repairs), self.short) for share in (1.0, SILENT, 0.5)]
        used, silenced, halved = (trial.error for (trial,) in self.tried(asked))
        return silenced - used, halved - used

    def _scaled(self) -> None:
        """Fit a factor of the gyro near 1 beside the cheapest repairs that leave a small error: it is a note."""
        best = {t.codes: t for t in sorted(self.trials, key=lambda t: -t.error)}
        small = MENDED * best[()].error
        bases = [
            t
            for codes, t in best.items()
            if self.floor < t.error <= (small if codes else UNJUDGED)
            and codes not in self._scaled_beside
            and not {"gyro_scale", "time_step"} & {*codes}
        ]
        for base in sorted(bases, key=lambda t: (t.rank, t.error))[:2]:
            self._scaled_beside += (base.codes,)
            inputs = tuple(each for each in base.mistakes if each.change)
            causes = [CODED[each.code] for each in base.mistakes if not each.change][-1:]
            for rest in (inputs, (*inputs, JOINT)):
                error = self._error_by_factor(rest, causes)
                if could_halve(*map(error, (1.0 - SCALE, 1.0, 1.0 + SCALE))):
                    scale = least(error, 1.0, 1.0 + SCALE)
                    self.trials += self.fully([(factor(scale), *inputs)], causes, courses=self._affordable(1))

    def _error_by_factor(self, rest: Repairs, causes: Sequence[Cause] = ()) -> Callable[[float], float]:
        """The error by a factor of the gyro beside other repairs, on the first course, rad."""
        courses = tuple(self._affordable(1)[:1])

        def error(value: float) -> float:
            [trials] = self.tried([((factor(value), *rest), courses)], causes)
            return trials[-1].error

        return error

    def _fitted(self, code: str, rest: Repairs, causes: Sequence[Cause]) -> Repair:
        """The best constant of a repair beside others, and perhaps one of the output."""
        of, tried = FITTED[code]

        def left(values: Iterable[float]) -> list[float]:
            asked = [((of(value), *rest), self.short) for value in values]
            return [min(trial.error for trial in trials) for trials in self.tried(asked, causes)]

        if code != "time_step":
            place = int(np.argmin(left(tried)))
            between = range(int(tried[max(0, place - 1)]), int(tried[min(len(tried) - 1, place + 1)]) + 1)
            counts = [count for count in between if count]
            return of(counts[int(np.argmin(left(counts)))])
        tried = tuple(sorted({*tried, *self._scales(rest)}))
        best = least(lambda value: left([value])[0], tried[int(np.argmin(left(tried)))], STEP)
        if left([best])[0] <= self.floor:  # a filter that corrects much hides a small error on so short a course
            best = least(self._error_by_factor(rest), best, FINE)
        return of(best)

    def _scales(self, rest: Repairs) -> Iterator[float]:
        """Factors of the gyro by which the estimate would turn as much as the body, by its turns with some factors."""
        for value in SCALES:
            for _ in range(3):  # Newton's steps: turns are nearly proportional to the factor
                ((trial, *_),) = self.tried([((factor(value), *rest), self.short)])
                ratio = trial.track.turn_ratio() if trial.track else 0.0
                value = float(np.clip(value / ratio if ratio > 0.0 else 0.0, 1e-7, 1e7))
            yield value


def could_halve(below: float, at: float, above: float) -> bool:
    """Whether the parabola through the squares of errors at even steps falls to half of the middle one between them."""
    slope = 0.5 * (above**2 - below**2)
    bend = max(0.5 * (above**2 + below**2) - at**2, UNCHANGED**2)
    place = np.clip(-0.5 * slope / bend, -1.0, 1.0)
    return bool(at**2 + (slope + bend * place) * place <= (HALVED * at) ** 2)


def least(error: Callable[[float], float], around: float, step: float) -> float:
    """Factor of the least error between another one divided by a step, and times it."""
    found = scipy.optimize.minimize_scalar(
        lambda value: error(value) ** 2,
        bounds=(around / step, around * step),
        method="bounded",
        options={"xatol": 1e-5 * around},
    )
    return float(found.x)
