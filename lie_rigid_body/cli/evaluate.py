"""``evaluate``: what attitude estimates in a bag or in files, or those of an estimator on a log, are worth, and why."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.command_line import columns_of, topic_names
from lie_rigid_body.foundation.errors import BagError, FilterError, InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.report.score_options import answer, parse, require_room
from lie_rigid_body.system import console

if TYPE_CHECKING:
    from lie_rigid_body.evaluation import Limits
    from lie_rigid_body.runs import Run

MIN_TIME_S: Final = 60.0
"""Time that a program or a node has beside the duration of a log, s."""
_NO_WORD: Final = re.compile(r"\W+", re.ASCII)


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = parse(argv)
    if given.run is None:
        raise InputError(f"no bag is given: give one; without, '{console.program('evaluate')}' follows topics of ROS 2")
    require_room(given)

    from lie_rigid_body.evaluation import Limits

    limits = Limits.parse(given.max_rms, tuple(given.max_after))
    return _of_recorded(given, limits) if given.estimate else _of_estimator(given, limits)


def _of_recorded(given: argparse.Namespace, limits: Limits) -> int:
    """Score estimates of a bag or of files."""
    from lie_rigid_body.estimates.recorded_estimate import TRUE_TOPICS, TRUTH, recorded_estimate
    from lie_rigid_body.recording.poses import is_bag

    topics = topic_names(given.topic, TRUE_TOPICS)
    if given.truth_topic:
        topics[TRUTH] = given.truth_topic
    bags = [path for path in (given.run, given.truth) if path is not None and is_bag(path)]
    with console.progress_of_bags(bags, passes=len(given.estimate)) as bar:
        reads = [recorded_estimate(given.run, topic, given.truth, topics, bar.update) for topic in given.estimate]
    return answer(given, given.run, [(read, read.score(limits, given.covariance_axes)) for read in reads])


def _of_estimator(given: argparse.Namespace, limits: Limits) -> int:
    """Run an estimator on a log, and score it where there is a truth."""
    from lie_rigid_body.cli.diagnose import given_estimator
    from lie_rigid_body.estimates.estimators import called, source_of
    from lie_rigid_body.estimates.recorded_estimate import estimate_of_run
    from lie_rigid_body.runs.ensemble import BlindRun

    run = _run_of(given)
    given.timeout = MIN_TIME_S + float(np.ptp(run.imu.t_ns)) / NS
    name, estimator = given_estimator(given)
    source = None if estimator is None else source_of(estimator)
    assert source is not None
    try:
        estimate = run.stamped(called(source.load(), BlindRun.without_truth(run.declared()), 0.0))
    except FilterError as error:
        raise InputError(f"{name}: {error}") from None
    topic = f"/{_NO_WORD.sub('_', name).strip('_')}"
    if run.log is not None and run.given_truth is None:
        if given.out is not None:
            run.to_bag(given.out, estimates={topic: estimate}, overwrite=given.force)
        kept = "" if given.out is None else f"; the estimates are in {given.out}"
        raise InputError(f"{given.run} has no truth to score {name} by: give one by --truth FILE{kept}")
    axes = None if given.covariance_axes == "world" else given.covariance_axes
    score = run.score(estimate, limits=limits, covariance_axes=axes)
    return answer(
        given,
        given.run,
        [(estimate_of_run(name, estimate, run), score)],
        lambda: run.to_bag(given.out, estimates={topic: estimate}, scores={topic: score}, overwrite=given.force),
    )


def _run_of(given: argparse.Namespace) -> Run:
    """The run of a bag that has a truth of its own, or of a log."""
    from lie_rigid_body.recording.poses import is_bag
    from lie_rigid_body.runs import Run

    of_log = (given.truth, given.truth_topic, given.imu, given.magnetometer, given.columns)
    if is_bag(given.run) and not any(of_log):
        with suppress(BagError):
            return Run.from_bag(given.run)
    return Run.from_log(
        given.run,
        truth=given.truth or given.truth_topic,
        imu=given.imu,
        magnetometer=given.magnetometer,
        columns=columns_of(given.columns),
    )
