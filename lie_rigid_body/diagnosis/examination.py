"""A diagnosis from its beginning to its end: search, choice, probes, and what is said of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, cast

import numpy as np

from lie_rigid_body.diagnosis.answers import Answer
from lie_rigid_body.diagnosis.course import NOISE, TINY, courses_of, noise_of
from lie_rigid_body.diagnosis.filter_diagnosis import ErrorOverTime, FilterDiagnosis, Mistake, Note, degrees
from lie_rigid_body.diagnosis.filter_runs import MAX_REST
from lie_rigid_body.diagnosis.probes import NOTES, PROBES
from lie_rigid_body.diagnosis.probing import Probe, in_degrees, told
from lie_rigid_body.diagnosis.repairs import HALVED, JOINT, ORDER
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.diagnosis.situations import Situation, common, situations
from lie_rigid_body.diagnosis.trials import NEAR, Trial
from lie_rigid_body.estimates.estimators import Estimator, Workers, each_alone, source_of
from lie_rigid_body.estimates.programs import NodeEstimator, time_limit
from lie_rigid_body.evaluation.causes import or_else
from lie_rigid_body.evaluation.matched import error_of
from lie_rigid_body.foundation.arrays import whole_number
from lie_rigid_body.foundation.parameters import Given
from lie_rigid_body.runs.ensemble import scenario_of
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.system.portable import MAX_PROCESSES, cores

MAX_RUNS: Final = 2000
"""Default number of runs of the filter after which no more repairs are tried."""
MAX_RUNS_OF_NODE: Final = 400
"""Default number of runs of a ROS 2 node after which no more repairs are tried: each is a process and takes seconds."""
WORKERS_OF_NODE: Final = 2
"""Number of processes per core that run a node: most of the time of a run all of them wait for the middleware."""
LEFT_OUT_OF_NODE: Final = ("converges", "first_attitude", "long_run", "covariance")
"""Probes that are left out for a node, as they need many or long runs."""
TIMEOUT_S: Final = 60.0
"""Longest time of one run of the filter, s, if the caller does not say."""
_ALONE: Final = (
    "The function has no name by which another process finds it: it was run in this one, without workers and without a "
    "limit of its time."
)
_FREE_FALL: Final = (
    "In this scenario the accelerometer reads no gravity, which a filter may need. The courses of diagnose have "
    "gravity, unless the parameter gravity is 0."
)
"""First sentence about a scenario in which bodies have no weight."""
TOLD: Final = math.radians(1e-3)
"""Least difference between the errors of two kinds of gyro that a note tells, rad."""


def diagnose(
    estimate: Estimator | str,
    *,
    scenario: str | Path | Scenario | Given | None = None,
    workers: int | None = None,
    max_runs: int | None = None,
    timeout: float = TIMEOUT_S,
    progress: Callable[[int], object] | None = None,
    parameters: Given | None = None,
    **named: object,
) -> FilterDiagnosis:
    """Find the mistakes of an attitude filter by repairs of its input and output, and probe what it can do.

    The filter is run again and again, with perfect sensors, on readings that are repaired: axes, units, times. The
    repair that makes its error vanish names its mistake. Then each probe puts one difficulty in its way.

    Parameters
    ----------
    estimate : callable or str
        A function of a `Run` whose ``truth`` is None, ``"module:function"``, or what
        `lie_rigid_body.testing.command_estimator` makes of a program, or `node_estimator` of a ROS 2 node; that module
        needs pytest. It returns attitudes (N, 4), scalar last, at the stamps of the IMU, or stamps and attitudes.
    scenario : str, Path, Scenario or mapping, optional
        Motion, rates and fields in place of the usual ones; a mapping replaces only what it names.
    workers : int, optional
        Processes; by default one per core, and two for a node.
    max_runs : int, optional
        Runs of the filter after which no more repairs are tried; by default 2000, and 400 of a node.
    timeout : float
        Longest time of one run of the filter, s.
    progress : callable, optional
        Told the number of runs after each.
    parameters : mapping, optional
        The motion, rates and fields by their public names, over those of the scenario. Also the noise that the filter
        assumes, as ``sensor_grade`` or as densities: the probes ``noise`` and ``covariance`` run with it.
    **named
        The same, one by one.

    Returns
    -------
    FilterDiagnosis

    Raises
    ------
    InputError
        If there is no such function, it raises an exception, does not return, or returns what is no estimate.
    """
    every = {**(parameters or {}), **named}
    noise = noise_of(every)
    said = {name: value for name, value in every.items() if name not in (*NOISE, "sensor_grade")}
    given = (
        {**(scenario or {}), **said}
        if scenario is None or isinstance(scenario, Mapping)
        else scenario_of(scenario, said).parameters()
    )
    courses = courses_of(given, said)
    time_limit(timeout)
    source = source_of(estimate)
    is_node = isinstance(source, NodeEstimator)
    most, each_core, left_out = (MAX_RUNS_OF_NODE, WORKERS_OF_NODE, LEFT_OUT_OF_NODE) if is_node else (MAX_RUNS, 1, ())
    most = most if max_runs is None else whole_number("max_runs", max_runs, 1)
    count = each_core * cores() if workers is None else whole_number("workers", workers, 1, MAX_PROCESSES)
    with closing(Workers(source, count, timeout)) if source else nullcontext() as crew:
        search = Search(
            crew.each if crew else partial(each_alone, cast("Estimator", estimate)),
            courses,
            most,
            progress,
            noise,
        )
        remarks = [f"Each run of a node takes seconds: it is not probed for {', '.join(left_out)}."] * is_node
        found = examined(search, remarks if source else [_ALONE], left_out)
    weightless = given.get("accelerometer_mode") == "free_fall" or not courses[0].parameter("gravity")
    return replace(found, first=(_FREE_FALL, *found.first)) if weightless else found


def examined(search: Search, remarks: Sequence[str], left_out: Collection[str]) -> FilterDiagnosis:
    """Search, name and probe, but for some probes; when interrupted, tell what was found so far."""
    errors = list[ErrorOverTime]()
    probes = list[Probe]()
    notes = list[Note]()
    found = list[Situation]()
    interrupted = False
    try:
        search.run()
        errors += _over_time(search)
        if not search.choice() and search.unrepaired.error > search.floor and not search.is_by_chance:
            found += situations(search)
        probes += told(search, [row for row in PROBES if row.code not in left_out])
        notes += (
            Note(each.code, f"{each.message}.", each.value)
            for each in told(search, [row for row in NOTES if row.code not in left_out])
            if each.passed is False and each.value is not None
        )
    except KeyboardInterrupt:
        if not search.trials:
            raise
        interrupted = True
    mistakes = tuple(_mistakes(search, errors))
    return FilterDiagnosis(
        mistakes,
        tuple(probes),
        (*_notes(search), *notes),
        search.runs,
        errors[0].rms_deg if errors else search.unrepaired.error_deg,
        math.degrees(search.floor),
        tuple(_headline(search, found, probes)),
        tuple(found),
        (*remarks, *_remarks(search, mistakes)),
        tuple(errors),
        interrupted,
        search.updates,
    )


def _remarks(search: Search, mistakes: Sequence[Mistake]) -> Iterator[str]:
    """Sentences about what was left untried, and what remains without a name."""
    if search.is_rest_cut:
        yield f"Repairs were tried after less than the {search.settles_s:.0f} s of rest that it needs."
    if search.is_cut:
        yield "Not all pairs of repairs were tried: the budget of runs and readings was spent."
    if mistakes and search.chosen.error > search.floor:
        yield (
            f"The {degrees(search.chosen.error_deg)} that remain have no name yet: correct what is named, and diagnose "
            "again."
        )


def _headline(search: Search, found: list[Situation], probes: Sequence[Probe]) -> Iterator[str]:
    """Sentences that stand first: growing errors, sensors that are not heard, what helps most, situations."""
    unrepaired = search.unrepaired
    if search.growth:
        which = f": the correction by the {search.unstable_by} has the wrong sign" if search.unstable_by else ""
        yield (
            f"It is unstable: errors of {TINY * search.course.turn:.1g} of the readings change the estimate by "
            f"{in_degrees(search.growth)}, and the change grows{which}."
        )
    if search.deaf and (unrepaired.error > search.floor or any(probe.passed is False for probe in probes)):
        yield _deaf(search)
    if search.is_by_chance:
        yield f"Two equal runs differ by {in_degrees(search.scatter)}: no repair is looked for."
    if found and (helpful := search.most_helpful):
        [repair] = helpful.mistakes
        yield (
            f"Most helps {repair.code} ({repair.text}), which leaves {degrees(helpful.error_deg)} of "
            f"{degrees(unrepaired.error_deg)}: it explains a part alone."
        )
    if found and (said := common(found, math.degrees(search.floor))):
        yield said


def _deaf(search: Search) -> str:
    """Sentence about the sensors that change nothing."""
    sensors = " and the ".join(search.deaf)
    change = f"The {sensors} change{'s' * (len(search.deaf) == 1)} nothing after the first second"
    if "magnetometer" in search.deaf and not search.is_level:
        return f"{change}: the magnetometer sets the first heading alone."
    return f"{change}{': its heading is free, and its vertical alone is judged' * search.is_level}."


def _over_time(search: Search) -> Iterator[ErrorOverTime]:
    """The errors of the filter as it is, and after each of the repairs that are named."""
    chosen = search.chosen
    courses = [course.of_scenario(gyro_rate=chosen.kind) for course in search.courses]
    joint = (JOINT,) * (JOINT in chosen.repairs)
    ordered = search.in_order(chosen)
    for count in range(len(ordered) + 1):
        repairs = ordered[:count]
        answers = search.ask((course, (*repairs, *joint)) for course in courses)
        tracks = [answer.track for answer in answers if isinstance(answer, Answer)]
        if len(tracks) == len(courses):
            yield ErrorOverTime(
                repairs[-1].code if repairs else "",
                tracks[0].stamps_ns / 1e9,
                np.degrees(tracks[0].error().total),
                math.degrees(error_of([track.fraction() for track in tracks])),
            )


def _mistakes(search: Search, errors: list[ErrorOverTime]) -> Iterator[Mistake]:
    """The mistakes that are named; what is left after each of several is known where it was asked of the filter."""
    named, *others = search.choice() or [search.unrepaired]
    known = dict.fromkeys(named.codes[-1:], named.error_deg) | {each.code: each.rms_deg for each in errors}
    first = known.get("", search.unrepaired.error_deg)
    before = first
    ordered = search.in_order(named)
    for place, found in enumerate(ordered):
        if found.code == "gyro_scale":
            continue
        after = known.get(found.code, before)
        instead = instead_of(named, others, found.code)
        doubt = f" On this motion {' or '.join(instead)} explains it as well." if instead else ""
        left = f"{found.deed} an error of {degrees(after)} instead of {degrees(before)}."
        if after > HALVED * before and place + 1 < len(ordered):
            left = "Alone its repair does not help."
        elif before > HALVED * first and place:
            left = f"Both repairs together leave an error of {degrees(after)} instead of {degrees(first)}."
        yield Mistake(found.code, f"{found.fact}. {left}{doubt}", found.text, before, after, instead)
        before = after


def instead_of(named: Trial, others: Sequence[Trial], code: str) -> tuple[str, ...]:
    """Codes that may replace one of the named codes while the others stay, in the order of the table."""
    found = {or_else(code, named.codes, other.codes) for other in others}
    return tuple(sorted(found - {"", *named.codes}, key=ORDER.index))


def _notes(search: Search) -> Iterator[Note]:
    """Notes on what helps the filter and is no mistake: later vector readings, and the other kind of gyro."""
    chosen = search.chosen
    if search.deaf:
        yield Note("deaf", _deaf(search), ", ".join(search.deaf))
    longest = search.longest_rest_s
    if longest and not search.needs_rest:
        unsettled = " Perhaps it does not: longer is not tried." * (longest >= MAX_REST)
        yield Note(
            "settles",
            f"It is given {longest:.0f} s at rest before a course, in whose second half its answer stands "
            f"still.{unsettled}",
            longest,
        )
    if search.chatter:
        yield Note(
            "chatters",
            f"Its answer at rest moves, or two runs with nearly equal readings differ, by "
            f"{in_degrees(search.chatter)}. That does not grow, as where each correction has a fixed length.",
            math.degrees(search.chatter),
        )
    if search.needs_noise:
        yield Note(
            "needs_noise",
            "Perfect readings give attitudes that are not finite; those with the noise of tactical sensors do not.",
            "tactical",
        )
    for repair in chosen.mistakes:
        if repair.code == "gyro_scale":
            value = 1.0 / float(repair.constants[0])
            yield Note("gyro_scale", f"It counts the gyro {value:.5g} times.", value)
    alike = [trial for trial in search.trials if trial.codes == chosen.codes]
    without = min((t.error for t in alike if JOINT not in t.repairs), default=0.0)
    if JOINT in chosen.repairs and without > max(search.floor, NEAR * chosen.error):
        ahead = f"its estimate is ahead by up to a sample, {in_degrees(without)}"
        left = f"{JOINT.deed} {degrees(chosen.error_deg)} are left."
        yield Note(JOINT.code, f"{JOINT.fact}: {ahead}. {left}", math.degrees(without))
    other = min((t for t in alike if t.kind != chosen.kind), key=lambda t: t.error, default=chosen)
    if other.error > max(NEAR * chosen.error, chosen.error + TOLD):
        yield Note(
            "gyro_kind",
            f"The filter expects {chosen.kind} rates: with {other.kind} ones its error is {in_degrees(other.error)}.",
            chosen.kind,
        )
