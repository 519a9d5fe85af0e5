"""A diagnosis from its beginning to its end: search, choice, probes, and what is said of them."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.course import REST, Course, courses_of, of_kind
from lie_rigid_body.diagnosis.probes import Setup, probed, with_unit
from lie_rigid_body.diagnosis.repairs import JOINT, Answer, Job
from lie_rigid_body.diagnosis.result import ErrorOverTime, FilterDiagnosis, Mistake, Note, Probe, degrees
from lie_rigid_body.diagnosis.search import BY_CODE, FLOOR, Choice, Search, Trial, plain, settled, track, undo
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import ExactTruth, evaluate
from lie_rigid_body.evaluation.causes import error_of
from lie_rigid_body.runs.ensemble import scenario_of
from lie_rigid_body.runs.estimators import Estimator
from lie_rigid_body.runs.node import NodeEstimator
from lie_rigid_body.runs.workers import Alone, Crew, FilterError, Workers, source_of
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.system import cores
from lie_rigid_body.wording import listed, shown

MOST_RUNS: Final = 2000
"""Runs of the filter after which no more repairs are tried, if the caller does not say."""
MOST_RUNS_OF_NODE: Final = 400
"""The same of a ROS 2 node, of which each run is a process and takes seconds."""
WORKERS_OF_NODE: Final = 2
"""Workers a core for a node: in much of the time of a run all wait for the middleware."""
LEFT_OUT_OF_NODE: Final = ("converges", "long_run", "covariance")
"""Probes of many or of long runs, which a node is spared."""
TIMEOUT_S: Final = 60.0
"""Longest time of one run of the filter, s, if the caller does not say."""
HELPS: Final = 2.0
"""Factor by which another kind of gyro, or later readings, change an error that is told in a note."""
TOLD: Final = float(np.radians(1e-3))
"""Difference of the errors of two kinds of gyro that is told in a note, rad."""
WITHOUT_REPAIR: Final = ("stuck", "mixed", "gaps", "turn_rate", "turn_axes")
"""Findings of `evaluate` that no repair undoes: they are told where nothing helps."""
_OF_NODE: Final = (
    f"Each run of a node takes seconds: {listed(LEFT_OUT_OF_NODE)} are not probed. What is told is all that was found."
)
_ALONE: Final = (
    "The function has no name by which another process finds it: it was run in this one, without workers and without a "
    "limit of its time."
)


def diagnose(
    estimate: Estimator | str,
    *,
    scenario: str | Path | Scenario | None = None,
    workers: int | None = None,
    max_runs: int | None = None,
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
        A function of a `Run` whose ``truth`` is None, ``"module:function"``, or what
        `lie_rigid_body.testing.command_estimator` makes of a program, or `node_estimator` of a ROS 2 node. It returns
        attitudes (N, 4), scalar last, at the stamps of the IMU, or stamps and attitudes.
    scenario : str, Path or Scenario, optional
        The motion, rates and fields instead of those chosen here.
    workers : int, optional
        Processes; by default one per core, and two for a node.
    max_runs : int, optional
        Runs of the filter after which no more repairs are tried; by default 2000, and 400 of a node.
    timeout : float
        Longest time of one run of the filter, s.
    progress : callable, optional
        Told the number of runs after each.
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
    courses = courses_of(given)
    for name, value in (("workers", workers), ("max_runs", max_runs)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
            raise InputError(f"{name}: {shown(value)} is no number from 1 on: give for example {name}=2")
    if not timeout > 0.0:
        raise InputError(f"timeout: {shown(timeout)} is not above 0: give a time in seconds")
    source, is_node = source_of(estimate), isinstance(estimate, NodeEstimator)
    crew: Crew
    if source is not None:
        crew = Workers(source, workers or cores() * (WORKERS_OF_NODE if is_node else 1), timeout)
    else:
        assert not isinstance(estimate, str)
        crew = Alone(estimate)
    most = max_runs or (MOST_RUNS_OF_NODE if is_node else MOST_RUNS)
    remarks = (_OF_NODE,) if is_node else () if source else (_ALONE,)
    with closing(crew):
        examination = Examination(crew, courses, most, progress or (lambda runs: None))
        return examination.run(*remarks, left_out=LEFT_OUT_OF_NODE if is_node else ())


class Examination:
    """One diagnosis.

    Parameters
    ----------
    crew : Crew
    courses : tuple of Course
    most_runs : int
    tell : callable
        Told the number of runs of the filter after each.
    """

    def __init__(self, crew: Crew, courses: tuple[Course, ...], most_runs: int, tell: Callable[[int], object]) -> None:
        self._crew, self._courses, self._most_runs, self._tell, self._runs = crew, courses, most_runs, tell, 0
        self._floor = FLOOR * float(np.mean([course.turn for course in courses]))
        self._search = self._begun()

    def _begun(self) -> Search:
        return Search(self._ask, self._courses, self._floor, lambda: self._runs < self._most_runs)

    def _ask(self, jobs: Sequence[Job]) -> Iterator[Answer | FilterError]:
        for answer in self._crew.each(jobs):
            self._runs += 1
            self._tell(self._runs)
            yield answer

    def run(self, *remarks: str, left_out: Sequence[str] = ()) -> FilterDiagnosis:
        """Search, name and probe, but for probes that are left out; when interrupted, tell what was found so far."""
        interrupted = False
        probes: list[Probe] = []
        told: list[Note] = []
        errors: list[ErrorOverTime] = []
        self._search.fully([()])
        try:
            self._look()
            chosen = self._chosen
            errors += self._over_time()
            probes.append(self._follows())
            course = of_kind(self._courses, chosen.kind)[0]
            for found in probed(self._ask, Setup(course, chosen, self._floor), left_out):
                if isinstance(found, Probe):
                    probes.append(found)
                else:
                    told.append(found)
        except KeyboardInterrupt:
            interrupted = True
        mistakes, notes = tuple(self._mistakes(errors)), (*self._notes(), *told)
        unrepaired = plain(self._search.trials)
        if self._search.is_cut and not interrupted:
            remarks += (f"No more repairs were tried after {self._most_runs} runs: --max-runs allows more.",)
        if errors and not mistakes and unrepaired.error > self._floor:
            remarks += (_command(of_kind(self._courses, unrepaired.kind)[0], errors[0]),)
        left, floor = np.degrees([unrepaired.error, self._floor]).tolist()
        return FilterDiagnosis(
            mistakes, tuple(probes), notes, self._runs, left, floor, remarks, tuple(errors), interrupted
        )

    def _look(self) -> None:
        """Look for repairs of a filter that is wrong; of one that is right after a longer rest it goes on with that."""
        wrong, courses = self._search, self._courses
        if wrong.is_broken or plain(wrong.trials).error <= self._floor:
            return
        self._courses = tuple(replace(course, rest_s=3.0 * REST) for course in courses)
        self._search = self._begun()
        self._search.fully([()])
        if plain(self._search.trials).error > self._floor:
            self._courses, self._search = courses, wrong
            wrong.run()

    @property
    def _chosen(self) -> Trial:
        """The filter with its mistakes repaired, or as it is."""
        choice = self._search.choice()
        return choice.named if choice else plain(self._search.trials)

    def _over_time(self) -> Iterator[ErrorOverTime]:
        """The errors of the filter as it is, and after each of the repairs that are named."""
        chosen = self._chosen
        courses, steps = of_kind(self._courses, chosen.kind), [((), ()), *chosen.steps]
        answers = self._ask([Job(course, repairs) for repairs, _ in steps for course in courses])
        for code, (_, outputs) in zip(("", *chosen.codes), steps, strict=True):
            given = [next(answers) for _ in courses]
            tracks = [undo(track(c, a), outputs) for c, a in zip(courses, given, strict=True) if isinstance(a, Answer)]
            if len(tracks) == len(courses):
                left = float(np.degrees(error_of([settled(each) for each in tracks])))
                yield ErrorOverTime(code, tracks[0].stamps_ns / 1e9, np.degrees(tracks[0].errors()), left)

    def _follows(self) -> Probe:
        """Whether the filter, with its mistakes repaired, follows a motion with perfect sensors."""
        chosen = self._chosen
        passed = bool(chosen.error <= self._floor or chosen.codes)
        what, error = "with its mistakes repaired" if chosen.codes else "with perfect sensors", np.degrees(chosen.error)
        said = f"{what} it errs by {with_unit(error)} (limit {with_unit(np.degrees(self._floor))})"
        (answer,) = self._ask([Job(of_kind(self._courses, chosen.kind)[0], chosen.repairs)])
        if not passed and isinstance(answer, Answer):
            stamps, truth = answer.stamps_ns, self._courses[0].truth
            known = ExactTruth(truth.at, int(stamps[0]), int(stamps[-1]))
            found = evaluate(stamps, answer.attitude_xyzw, known).findings
            said += "".join(f"; {each.code}: {each.message}" for each in found if each.code in WITHOUT_REPAIR)
        return Probe("follows", passed, said, float(error))

    def _mistakes(self, errors: Sequence[ErrorOverTime]) -> Iterator[Mistake]:
        """The mistakes that are named; what is left after each of several is known where it was asked of the filter."""
        choice = self._search.choice()
        if choice is None:
            return
        left = {each.code: each.rms_deg for each in errors}
        before = left.get("", float(np.degrees(plain(self._search.trials, joint=False).error)))
        for code in choice.named.codes:
            after = float(np.degrees(choice.named.error)) if code == choice.named.codes[-1] else left.get(code, before)
            yield _mistake(choice, code, before, after)
            before = after

    def _notes(self) -> Iterator[Note]:
        """What helps the filter and is no mistake: later readings of the vectors, and the other kind of gyro."""
        chosen = self._chosen
        alike = [trial for trial in self._search.trials if trial.codes == chosen.codes]
        without = min((t.error for t in alike if not t.joint), default=0.0)
        if chosen.joint and without > max(self._floor, HELPS * chosen.error):
            value, left = np.degrees([without, chosen.error]).tolist()
            said = f"its estimate is ahead by up to a sample, {value:.2g}°. {JOINT.deed} {degrees(left)} are left."
            yield Note(JOINT.code, f"{JOINT.fact}: {said}", value)
        other = min((t for t in alike if t.kind != chosen.kind), key=lambda t: t.error, default=chosen)
        if other.error > max(HELPS * chosen.error, chosen.error + TOLD):
            said = f"with {other.kind} ones it errs by {np.degrees(other.error):.2g}°."
            yield Note("gyro_kind", f"The filter expects {chosen.kind} rates: {said}", chosen.kind)


def _mistake(choice: Choice, code: str, before: float, after: float) -> Mistake:
    """A mistake that is named, with the errors before and after its repair, degrees."""
    outputs = dict(choice.named.outputs)
    if code in outputs:
        cause, constants = BY_CODE[code], np.array(outputs[code])
        fact, deed = cause.fact(constants), cause.deed(constants)
        repair = " ".join(f"{constant:.5g}" for constant in outputs[code]) if cause.price else "undone"
    else:
        (found,) = (each for each in choice.named.inputs if each.code == code)
        fact, deed, repair = found.fact, found.deed, found.text
    or_else = choice.or_else(code)
    doubt = f" Undoing {' or '.join(or_else)} does as well on this motion." if or_else else ""
    verb = "leaves" if code in outputs and not deed.endswith("they") else "leave"
    message = f"{fact}. {deed} {verb} {degrees(after)} instead of {degrees(before)}.{doubt}"
    return Mistake(code, message, repair, before, after, or_else)


def _command(course: Course, errors: ErrorOverTime) -> str:
    """The shortest run on which the filter errs most."""
    late = errors.t_s[np.argmax(errors.error_deg >= 0.9 * errors.error_deg.max())]
    default = Scenario.from_parameters({"imu_rate": 1.0}).parameters()
    words = ["lie-rigid-body", "record", "errs.mcap", "--duration", f"{np.ceil(max(1.0, late - REST)):g}"]
    for name, value in course.scenario.parameters().items():
        if value != default[name]:
            words += ["-p", f"{name}:={list(value) if isinstance(value, tuple) else value}".replace(" ", "")]
    return f"It errs most in: {shlex.join(words)}"
