"""Probes with noise: the error beside that of single sets of readings, and the covariance of the estimate."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.answers import Answer
from lie_rigid_body.diagnosis.course import Course, readings
from lie_rigid_body.diagnosis.probing import Probing, in_degrees, limited
from lie_rigid_body.diagnosis.search import GRADE_OF_NOISE, Search
from lie_rigid_body.evaluation import CramerRaoBound
from lie_rigid_body.evaluation.attitudes import error_vectors
from lie_rigid_body.evaluation.ensemble_consistency import ensemble_consistency
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs import simulate

SEEDS: Final = 12
"""Short runs with noise by which a covariance is judged, and as many others. Of twenty right covariances one is called
inconsistent by chance, and two of these verdicts are not."""
SHORT_S: Final = 5.0
"""Length of the motion of a short run with noise, s."""
JUDGED: Final = 20
"""Number of samples of a short run by which a covariance is judged."""


def first_given(search: Search) -> Estimate:
    """Estimate of the filter as it is, on the first course."""
    return search.trials[0].unrepaired[0].given


def _noisy(search: Search, seed: int = 1) -> Course:
    """The ordinary course with white noise: that which the filter assumes, or else of tactical sensors."""
    return replace(search.course.of_scenario(**(search.noise or GRADE_OF_NOISE)), seed=seed)


def _grade(search: Search) -> str:
    return "the given sensors" if search.noise else "tactical sensors"


def noise(search: Search) -> Probing:
    """Error with noise; its limit is that of TRIAD at the readings that are answered; the least possible is told."""
    course = _noisy(search)
    [answer] = yield [course]
    bound = simulate(course.scenario, duration=course.counted_s).cramer_rao_bound()
    assert bound
    least = CramerRaoBound.rms(bound.filtered[len(bound.filtered) // 3 :])
    return limited(
        f"with the noise of {_grade(search)} its error is",
        answer.error(),
        1.01 * of_single_sets(search, course, answer),
        f"; the Cramér–Rao bound of filters is {in_degrees(least)} over many such runs",
    )


def of_single_sets(search: Search, course: Course, answer: Answer) -> float:
    """RMS error, rad, of TRIAD from each single set of readings that is answered, without the first third."""
    stamps = answer.track.stamps_ns
    read = readings(course)
    held = np.maximum(np.searchsorted(read.field_t_ns, read.t_ns, side="right") - 1, 0)
    world = _axes(np.array([0.0, 0.0, 1.0]), course.field)
    body = _axes(read.vectors["specific_force"], read.vectors["field"][held])
    attitude = quaternion.from_matrix(world @ np.swapaxes(body, -1, -2))
    single = Matched(read.t_ns, attitude, course, is_level=search.is_level)
    answered = np.maximum(np.searchsorted(read.t_ns, stamps, side="right") - 1, 0)
    return error_of([single[answered[len(stamps) // 3 :]]])


def _axes(first: Array, second: Array) -> Array:
    """The axes that two directions span (TRIAD), in columns, shape (..., 3, 3)."""
    across = np.cross(first, second)
    axes = np.stack([first, across, np.cross(first, across)], axis=-1)
    return np.asarray(axes / np.linalg.norm(axes, axis=-2, keepdims=True))


def covariance(search: Search) -> Probing:
    """Whether a covariance is consistent, and what is wrong with it, by the rule of a campaign; by short runs."""
    has_one = first_given(search).covariance is not None
    answers = yield [replace(_noisy(search, seed), moving_s=SHORT_S) for seed in range(2 * SEEDS * has_one)]
    count = min(len(answer.track.stamps_ns) for answer in answers)
    axes = answers[0].given.covariance_axes
    at = np.linspace(count // 3, count - 1, JUDGED).astype(np.int64)
    tracks = [answer.track[at] for answer in answers]
    estimate = np.stack([track.attitude_xyzw for track in tracks])
    errors = error_vectors(estimate, np.stack([track.truth_xyzw for track in tracks]), axes)
    covariance = np.stack([answer.given.rotation_covariance()[at] for answer in answers])
    verdicts = [
        ensemble_consistency(tracks[0].stamps_ns / 1e9, errors[runs], covariance[runs], estimate[runs], axes)
        for runs in (slice(SEEDS), slice(SEEDS, None))
    ]
    found = min(verdicts, key=lambda each: (not each.passed, each.cause in ("", "factor")))
    passed = found.passed if search.noise else None
    return passed, f"with the noise of {_grade(search)}: {found.message}", found.nees_mean
