"""A diagnosis from its beginning to its end: search, choice, probes, and what is said of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Lock
from typing import Any, Final

import numpy as np

from lie_rigid_body.diagnosis.choice import BY_CODE, FLOOR, Candidate, Choice, Outputs, plain_error, undo
from lie_rigid_body.diagnosis.filter import Filter, NamedFunction
from lie_rigid_body.diagnosis.probes import NOTES, PROBES, Probing, Setup, shown_angle
from lie_rigid_body.diagnosis.repairs import JOINT, Repair
from lie_rigid_body.diagnosis.result import ErrorOverTime, FilterDiagnosis, Mistake, Note, Probe, degrees
from lie_rigid_body.diagnosis.search import Search, Try
from lie_rigid_body.diagnosis.trial import KINDS, REST, Trial, trials_of
from lie_rigid_body.diagnosis.workers import Alone, Workers
from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.ensemble import scenario_of
from lie_rigid_body.runs.estimators import Estimator
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.wording import shown

MOST_RUNS: Final = 2000
"""Runs of the filter after which no more pairs are begun, if the caller does not say."""
TIMEOUT_S: Final = 60.0
"""Longest time of one run of the filter, s, if the caller does not say."""
HELPS: Final = 2.0
"""Factor by which another kind of gyro, or later readings, change an error that is told in a note."""
TOLD_DEG: Final = 1e-3
"""Difference of the errors of two kinds of gyro that is told in a note, degrees."""
_ALONE: Final = (
    "The function has no name by which another process finds it: it was run in this one, without workers and without a "
    "limit of its time."
)


UNEXPLAINED: Final = (
    "; no repair mends that: it may lose readings, stand still, mix conventions, or turn at another rate or about "
    "other axes for a part of the time"
)
"""What is said where nothing helps: causes that have no repair."""


@dataclass
class Counter:
    """Runs of the filter, counted by threads, and told to whoever shows them."""

    tell: Callable[[int], object]
    runs: int = 0

    def __post_init__(self) -> None:
        self._lock = Lock()

    def begun(self) -> None:
        """Count one more."""
        with self._lock:
            self.runs += 1
            self.tell(self.runs)


def diagnose(
    estimate: Estimator | str,
    *,
    scenario: str | Path | Scenario | None = None,
    workers: int | None = None,
    max_runs: int = MOST_RUNS,
    timeout: float = TIMEOUT_S,
    progress: Callable[[int], object] | None = None,
    **parameters: object,
) -> FilterDiagnosis:
    """Say what is wrong with an attitude filter, by repairing it from outside, and what it can do.

    The filter is run again and again, with perfect sensors, on readings that are repaired: axes, units, times. The
    repair that makes its error vanish names its mistake. Then it is probed with one thing at a time in its way.

    Parameters
    ----------
    estimate : callable or str
        A function of a `Run` whose ``truth`` is None, or ``"module:function"``. It returns attitudes (N, 4), scalar
        last, at the stamps of the IMU, or stamps and attitudes.
    scenario : str, Path or Scenario, optional
        The motion, rates and fields instead of those chosen here.
    workers : int, optional
        Processes; by default one per core.
    max_runs : int
        Runs of the filter after which no more pairs of repairs are begun.
    timeout : float
        Longest time of one run of the filter, s.
    progress : callable, optional
        Told the number of runs before each.
    **parameters
        Parameters of the scenario by their public names.

    Returns
    -------
    FilterDiagnosis

    Raises
    ------
    InputError
        If there is no such function, it raises an exception, does not return, or returns what is no estimate.
    """
    given = dict(parameters) if scenario is None else scenario_of(scenario, parameters).parameters()
    trials = trials_of(given)
    for name, value in (("workers", workers), ("max_runs", max_runs)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
            raise InputError(f"{name}: {shown(value)} is no number from 1 on: give for example {name}=2")
    if not timeout > 0.0:
        raise InputError(f"timeout: {shown(timeout)} is not above 0: give a time in seconds")
    counter = Counter(progress or (lambda runs: None))
    source = NamedFunction(estimate) if isinstance(estimate, str) else NamedFunction.of(estimate)
    crew: Alone | Workers
    if source is not None:
        crew = Workers(source, workers or _cores(), timeout, counter.begun)
    else:
        assert not isinstance(estimate, str)
        crew = Alone(estimate, counter.begun)
    try:
        return Examination(crew, trials, counter, max_runs, () if source else (_ALONE,)).run()
    finally:
        crew.close()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Examination:
    """One diagnosis.

    Parameters
    ----------
    crew : Alone or Workers
    trials : tuple of Trial
    counter : Counter
    most_runs : int
    remarks : tuple of str
        What is to be said about the diagnosis itself.
    """

    def __init__(
        self,
        crew: Alone | Workers,
        trials: tuple[Trial, ...],
        counter: Counter,
        most_runs: int,
        remarks: tuple[str, ...],
    ) -> None:
        self._crew, self._trials, self._counter, self._remarks = crew, trials, counter, remarks
        self._floor = FLOOR * float(np.mean([trial.turn for trial in trials]))
        self._search = Search(crew, trials, self._floor, lambda: counter.runs < most_runs)
        self._probes: list[Probe] = []
        self._notes: list[Note] = []
        self._mistakes: tuple[Mistake, ...] = ()
        self._errors: tuple[ErrorOverTime, ...] = ()

    def run(self) -> FilterDiagnosis:
        """Search, name and probe; when interrupted, tell what was found so far."""
        interrupted = False
        self._search.plain()
        try:
            if not self._is_right_after_a_rest():
                self._search.run()
            self._name()
            self._probe()
        except KeyboardInterrupt:
            interrupted = True
            if not self._mistakes:
                self._mistakes = tuple(self._named(asked=False))
        plain = plain_error(self._search.found)
        result = FilterDiagnosis(
            self._mistakes,
            tuple(self._probes),
            tuple(self._notes),
            self._counter.runs,
            float(np.degrees(plain.error)),
            float(np.degrees(self._floor)),
            self._remarks,
            self._errors,
            interrupted,
        )
        if self._mistakes or plain.error <= self._floor or not self._errors:
            return result
        return replace(result, remarks=(*self._remarks, self._command(plain)))

    def _is_right_after_a_rest(self) -> bool:
        """Whether the filter is wrong, but right after a longer rest: then no mistake of another kind is looked for."""
        plain = plain_error(self._search.found)
        if plain.error <= self._floor:
            return False
        trials = tuple(replace(trial.of_kind(plain.kind), rest_s=3.0 * REST) for trial in self._trials)
        rested = list(self._crew.each([Try(joint, trials) for joint in ((), (JOINT,))]))
        return any(c.error <= self._floor for each in rested if isinstance(each, list) for c in each)

    @property
    def _chosen(self) -> Candidate:
        """The filter with its mistakes repaired, or as it is."""
        choice = self._search.choice()
        return choice.named if choice else plain_error(self._search.found)

    def _name(self) -> None:
        self._mistakes = tuple(self._named(asked=True))
        chosen, alike = self._chosen, [c for c in self._search.found if c.codes == self._chosen.codes]
        self._notes += _ahead(chosen, alike, self._floor)
        self._notes += _kind(chosen, alike)
        jobs = [WatchedError(self._trials[0].of_kind(chosen.kind), *steps) for steps in _prefixes(chosen)]
        self._errors = tuple(each for each in self._crew.each(jobs) if isinstance(each, ErrorOverTime))

    def _named(self, *, asked: bool) -> Iterator[Mistake]:
        """The mistakes; how much each repair of several leaves is asked of the filter, where it may be."""
        choice = self._search.choice()
        if choice is None:
            return
        named, before = choice.named, plain_error(self._search.found, joint=False).error
        for count, code in enumerate(named.codes, 1):
            repairs, outputs, _ = _prefixes(named)[count]
            after = named.error if count == len(named.codes) else before
            if count < len(named.codes) and asked:
                trials = tuple(trial.of_kind(named.kind) for trial in self._trials)
                (found,) = self._crew.each([Try(repairs, trials, "none", outputs)])
                after = found[0].error if isinstance(found, list) and found else after
            yield _mistake(choice, code, before, after)
            before = after

    def _probe(self) -> None:
        chosen = self._chosen
        plain, below = float(np.degrees(chosen.error)), chosen.error <= self._floor
        passed = bool(below or self._mistakes)
        what = "with its mistakes repaired it" if self._mistakes else "with perfect sensors it"
        said = f"{what} errs by {shown_angle(plain)}; the floor is {np.degrees(self._floor):.2g}°" + UNEXPLAINED * (
            not passed
        )
        self._probes.append(Probe("follows", passed, said, plain))
        trials = tuple(trial.of_kind(chosen.kind) for trial in self._trials)
        setup = Setup(trials, chosen.repairs, chosen.outputs, self._floor, chosen.error)
        for found in self._crew.each([Probing(probe, setup) for probe in (*PROBES, *NOTES)]):
            if isinstance(found, Probe):
                self._probes.append(found)
            elif isinstance(found, Note):
                self._notes.append(found)
            elif isinstance(found, InputError):
                self._probes.append(Probe("follows", passed=False, message=str(found)))

    def _command(self, plain: Candidate) -> str:
        """The shortest run on which the filter errs most."""
        errors = self._errors[0]
        late = errors.t_s[np.argmax(errors.error_deg >= 0.9 * errors.error_deg.max())]
        length = float(np.ceil(max(1.0, late - REST)))
        scenario = self._trials[0].of_kind(plain.kind).scenario
        default = Scenario.from_parameters({"imu_rate": 1.0}).parameters()
        given = [
            f"-p {name}:={list(value) if isinstance(value, tuple) else value}".replace(" ", "").replace("-p", "-p ", 1)
            for name, value in scenario.parameters().items()
            if value != default[name]
        ]
        return f"It errs most in: lie-rigid-body record errs.mcap --duration {length:g} {' '.join(given)}"


def _prefixes(chosen: Candidate) -> list[tuple[tuple[Repair, ...], Outputs, str]]:
    """The repairs one after the other: none, the first, the first two; with labels."""
    joint = (JOINT,) * chosen.joint
    found: list[tuple[tuple[Repair, ...], Outputs, str]] = [((), (), "as it is")]
    for count, repair in enumerate(chosen.inputs, 1):
        found.append(((*chosen.inputs[:count], *joint), (), f"{repair.code} repaired"))
    for count, (code, _) in enumerate(chosen.outputs, 1):
        found.append((chosen.repairs, chosen.outputs[:count], f"{code} repaired"))
    return found


@dataclass(frozen=True)
class WatchedError:
    """A job: the total error over time with some repairs."""

    trial: Trial
    repairs: tuple[Repair, ...]
    outputs: Outputs
    label: str

    def __call__(self, run: Filter) -> ErrorOverTime:
        """The error of each sample."""
        track = run.answer(self.trial, self.repairs).track
        return ErrorOverTime(self.label, track.stamps_ns / 1e9, np.degrees(undo(track, self.outputs).errors()))


def _mistake(choice: Choice, code: str, before: float, after: float) -> Mistake:
    outputs = dict(choice.named.outputs)
    if code in outputs:
        cause, constants = BY_CODE[code], np.array(outputs[code])
        fact, deed, repair = cause.fact(constants), cause.deed(constants), _shortly(code, constants)
        verb = "leave" if deed.endswith("they") else "leaves"
    else:
        (found,) = (each for each in choice.named.inputs if each.code == code)
        fact, deed, repair, verb = found.fact, found.deed, found.text, "leave"
    or_else = choice.or_else(code)
    doubt = f" Undoing {' or '.join(or_else)} does as well on this motion." if or_else else ""
    was, left = float(np.degrees(before)), float(np.degrees(after))
    message = f"{fact}. {deed} {verb} {degrees(left)} instead of {degrees(was)}.{doubt}"
    return Mistake(code, message, repair, was, left, or_else)


def _shortly(code: str, constants: Any) -> str:
    """A repair of the output in a few characters."""
    if not BY_CODE[code].price:
        return "undone"
    if code in ("heading_offset", "world_turned", "body_mounting"):
        return " ".join(f"{-value:+.4g}" for value in np.degrees(constants)) + "°"
    return f"× {constants[0]:.5g}" if code == "clock_rate" else f"{-constants[0]:+.4g} s"


def _ahead(chosen: Candidate, alike: Sequence[Candidate], floor: float) -> Iterator[Note]:
    """That accelerometer and magnetometer one sample later help."""
    without = min((c.error for c in alike if not c.joint), default=0.0)
    if chosen.joint and without > max(floor, HELPS * chosen.error):
        value = float(np.degrees(without))
        yield Note(
            JOINT.code,
            f"{JOINT.fact}: its estimate is ahead by up to a sample, {value:.2g}°. {JOINT.deed} "
            f"{degrees(np.degrees(chosen.error))} are left.",
            value,
        )


def _kind(chosen: Candidate, alike: Sequence[Candidate]) -> Iterator[Note]:
    """Which kind of gyro the filter expects."""
    other = min((c.error for c in alike if c.kind != chosen.kind), default=chosen.error)
    if other > HELPS * chosen.error and np.degrees(other - chosen.error) > TOLD_DEG:
        kind, rest = chosen.kind, next(kind for kind in KINDS if kind != chosen.kind)
        said = f"The filter expects {kind} rates: with {rest} ones it errs by {np.degrees(other):.2g}°."
        yield Note("gyro_kind", said, kind)
