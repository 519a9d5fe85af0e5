"""The search for repairs: those of the output, single ones of the input, then pairs, within a budget of filter runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, TypeVar

import numpy as np
from scipy.optimize import minimize_scalar

from lie_rigid_body.diagnosis.choice import UNCHANGED, Candidate, Choice, Outputs, choose, plain_error, undo
from lie_rigid_body.diagnosis.filter import Filter, FilterError
from lie_rigid_body.diagnosis.repairs import FITTED, JOINT, Repair, exact_repairs
from lie_rigid_body.diagnosis.trial import KINDS, Trial
from lie_rigid_body.evaluation.attitudes import angles_between
from lie_rigid_body.evaluation.causes import CAUSES, Cause, Track, Tracks, error_of

T = TypeVar("T")

SCREENED_S: Final = 4.0
"""Length of the motion by which repairs are compared at first, s."""
FINALISTS: Final = 6
"""Number of repairs that are then tried on all runs, of those that are best alone, and best with one of the output."""
BEAM: Final = 8
"""Largest number of repairs of which each is tried together with every other one."""
FAR: Final = 10.0
"""Factor of the least error, or of the floor, above which a repair is not tried further."""
PAIR_FINALISTS: Final = 4
"""Number of pairs with one of these that are then tried on all runs."""
ANY_PRICE: Final = 9
_OF_TIME: Final = ("lagging", "leading", "clock_rate")
QUICK: Final = tuple(cause for cause in CAUSES if cause.code not in _OF_TIME)
"""Causes that are undone in the first comparison; a fit of stamps takes longer, and hides no other repair."""
_LAGS: Final = (-2, -1, 1, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40)
"""Samples by which readings are moved at first."""
_FACTORS: Final = (0.25, 0.4, 0.6, 0.75, 0.87, 0.95, 1.05, 1.15, 1.33, 1.67, 2.5, 4.0)
"""Factors of the gyro that are tried at first."""
_FINEST_FACTOR: Final = 1e-6


Asked = Callable[[Filter], list[Candidate]]
"""A job that finds candidates."""


class Crew(Protocol):
    """Those who do jobs: `Alone` or `Workers`."""

    def each(self, jobs: Sequence[Callable[[Filter], T]]) -> Iterator[T | FilterError]:
        """The results in the order of the jobs."""
        ...


@dataclass(frozen=True)
class Try:
    """A job: repairs of the input on trials of one kind, alone and with causes undone in the output.

    Attributes
    ----------
    repairs : tuple of Repair
    trials : tuple of Trial
        With one kind of gyro.
    outputs : str
        Which causes are undone: ``none``, ``quick``, ``all``, or ``pairs``, also every two.
    applied : tuple of (str, tuple of float)
        Causes that are undone before all others, with their constants.
    """

    repairs: tuple[Repair, ...]
    trials: tuple[Trial, ...]
    outputs: str = "none"
    applied: Outputs = ()

    def __call__(self, run: Filter) -> list[Candidate]:
        """The candidates; none where a repair changes nothing, or the filter fails."""
        kind = str(self.trials[0].scenario.parameters()["gyro_rate"])
        try:
            answers = [run.answer(trial, self.repairs) for trial in self.trials]
            if any(answer.broken >= 0 for answer in answers):
                return [] if self.repairs else [Candidate((), (), np.pi, kind)]
            if any(repair != JOINT for repair in self.repairs) and self._changes_nothing(run, answers[0].track):
                return []
        except FilterError:
            if not self.repairs:
                raise
            return []
        tracks = [undo(answer.settled(), self.applied) for answer in answers]
        partial: tuple[float, ...] = ()
        if self.outputs == "quick":
            partial, tracks = tracks[0].partial_errors(), [track.few(100) for track in tracks]
        found = [Candidate(self.repairs, self.applied, error_of(tracks), kind, partial)]
        chosen = {"none": (), "quick": QUICK}.get(self.outputs, CAUSES)
        for outputs, error in _undone(tracks, chosen, pairs=self.outputs == "pairs"):
            found.append(Candidate(self.repairs, outputs, error, kind))
        return found

    def _changes_nothing(self, run: Filter, track: Track) -> bool:
        plain = run.answer(self.trials[0], (JOINT,) * (JOINT in self.repairs)).track
        attitude = track.attitude_xyzw
        return len(plain.attitude_xyzw) == len(attitude) and bool(
            np.max(angles_between(plain.attitude_xyzw, attitude)) < UNCHANGED
        )


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


@dataclass(frozen=True)
class Fit:
    """A job: the best constant of a repair that has one, on one trial.

    Attributes
    ----------
    code : str
    repairs : tuple of Repair
        Those before it, and `JOINT` where it is applied.
    trial : Trial
    """

    code: str
    repairs: tuple[Repair, ...]
    trial: Trial

    def __call__(self, run: Filter) -> list[Candidate]:
        """The candidate with the constant, if the filter takes any."""
        kept: dict[float, float] = {}

        def left(value: float) -> float:
            if value not in kept:
                found = Try((FITTED[self.code](value), *self.repairs), (self.trial,))(run)
                kept[value] = found[0].error if found else np.pi
            return kept[value]

        if self.code == "time_step":
            best = min(_FACTORS, key=left)
            place = _FACTORS.index(best)
            low, high = _FACTORS[max(0, place - 1)], _FACTORS[min(len(_FACTORS) - 1, place + 1)]
            best = float(
                minimize_scalar(
                    left, bounds=(low, high), method="bounded", options={"xatol": _FINEST_FACTOR, "maxiter": 40}
                ).x
            )
        else:
            best = min(_LAGS, key=left)
            place = _LAGS.index(best)  # between the neighbours that were tried there may be a better one
            between = range(_LAGS[max(0, place - 1)], _LAGS[min(len(_LAGS) - 1, place + 1)] + 1)
            best = min((count for count in between if count), key=left)
        return Try((FITTED[self.code](best), *self.repairs), (self.trial,), "quick")(run)


class Search:
    """A search under way; what was found so far can be asked for at any time.

    Parameters
    ----------
    crew : Crew
    trials : tuple of Trial
        The ordinary ones, with an integrated gyro.
    floor : float
        The error below which nothing is looked for, rad.
    has_room : callable
        Whether the budget allows more runs of the filter.
    """

    def __init__(self, crew: Crew, trials: tuple[Trial, ...], floor: float, has_room: Callable[[], bool]) -> None:
        self._crew, self._trials, self._floor, self._has_room = crew, trials, floor, has_room
        self.found: list[Candidate] = []
        self._screened: list[list[Candidate]] = []
        self._short = replace(trials[0], moving_s=SCREENED_S)

    def choice(self) -> Choice | None:
        """What is named so far."""
        return choose(self.found, self._floor)

    def plain(self) -> None:
        """Run the filter as it is, on all trials.

        Raises
        ------
        FilterError
            If it fails.
        """
        self._try_fully([()], "none")

    def run(self) -> None:
        """Look for repairs until the error vanishes, or the budget is spent."""
        if plain_error(self.found).error <= self._floor:
            return
        self._of_outputs()
        if not self._is_mended(1, 0):
            self._of_single_inputs()
        if not (self._is_mended(1, ANY_PRICE) or self._is_mended(2, 0)):
            self._of_pairs()

    def _is_mended(self, count: int, price: int) -> bool:
        """Whether so few and so cheap repairs leave an error below the floor: then no later one is named instead."""
        choice = self.choice()
        return choice is not None and choice.named.error <= self._floor and choice.named.rank[:2] <= (count, price)

    def _do(self, jobs: Sequence[Asked]) -> list[list[Candidate]]:
        """The candidates of each job, none where the filter fails."""
        return [[] if isinstance(each, FilterError) else each for each in self._crew.each(jobs)]

    def _try_fully(self, chosen: Iterable[tuple[Repair, ...]], outputs: str) -> None:
        """Try repairs on all trials, with both kinds of gyro, with and without `JOINT`."""
        by_kind = [tuple(trial.of_kind(kind) for trial in self._trials) for kind in KINDS]
        jobs = [
            Try((*repairs, *joint), trials, outputs)
            for repairs in chosen
            for joint in ((), (JOINT,))
            for trials in by_kind
        ]
        for each in self._crew.each(jobs):
            if not isinstance(each, FilterError):
                self.found += each
            elif not self.found:
                raise each

    def _of_outputs(self) -> None:
        self._try_fully([()], "pairs")

    def _of_single_inputs(self) -> None:
        """Screen every repair on a short trial, then try the best on all of them; at last those with a constant."""
        self._screen([Try((repair,), (self._short,), "quick") for repair in exact_repairs()])
        if not self._is_mended(1, 0):
            self._screen([Fit(code, joint, self._short) for code in FITTED for joint in ((), (JOINT,))])

    def _screen(self, jobs: Sequence[Asked]) -> None:
        found = sorted((each for each in self._do(jobs) if each), key=_least)
        alone = sorted(found, key=lambda each: each[0].error)  # else it hides among those that an output's repair mends
        self._screened = sorted([*self._screened, *found], key=_least)
        far = FAR * max(_least(found[0]), self._floor) if found else 0.0
        chosen = [each[0].inputs for each in (*alone[:FINALISTS], *found[:FINALISTS]) if _least(each) <= far]
        self._try_fully(dict.fromkeys(chosen), "all")

    def _of_pairs(self) -> None:
        """Try the best repairs of the input each with every other, and the best of these pairs on all trials."""
        orders = [
            self._screened
        ]  # one repair of two may take away the error of the vertical alone, or that of the turns
        orders += [sorted(self._screened, key=lambda each: each[0].partial[part]) for part in (0, 1)]
        firsts = list(dict.fromkeys(each[0].inputs[0] for level in zip(*orders, strict=True) for each in level))[:BEAM]
        jobs: list[list[Asked]] = [
            [Try((first, second), (self._short,)) for second in exact_repairs() if second.code != first.code]
            for first in firsts
        ]
        jobs += [[Fit(code, (first,), self._short) for code in FITTED if code != first.code] for first in firsts]
        for together in jobs:
            if not self._has_room() or self._is_mended(2, 0):
                return
            best = sorted((each for each in self._do(together) if each), key=_least)[:PAIR_FINALISTS]
            far = FAR * max(_least(best[0]), self._floor) if best else 0.0
            self._try_fully(dict.fromkeys(each[0].inputs for each in best if _least(each) <= far), "none")


def _least(candidates: Sequence[Candidate]) -> float:
    return min(candidate.error for candidate in candidates)
