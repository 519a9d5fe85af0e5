"""What the room `evaluation` says when it refuses, and of limits, differences, findings and turns."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np
import pytest
from motions import FRD, NED, STAMPS, about_up, attitude, truth_of
from test_turning import CYCLED, SWAPPED, UNCHANGED, remarks_on

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import (
    ExactTruth,
    Limits,
    SampledTruth,
    attitude_error,
    attitude_nees,
    bias_error,
    evaluate,
)
from lie_rigid_body.evaluation.arguments import read_series, read_stamps
from lie_rigid_body.evaluation.attitudes import AttitudeError
from lie_rigid_body.evaluation.cramer_rao_bound import AttitudeReadings, NoisySensors, VectorReadings, cramer_rao_bound
from lie_rigid_body.evaluation.differences import of_pairs, of_runs
from lie_rigid_body.evaluation.ensemble_consistency import ensemble_consistency
from lie_rigid_body.evaluation.remarks import DEGREE
from lie_rigid_body.evaluation.statistics import Tally
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion

ONE, ZERO = [0.0, 0.0, 0.0, 1.0], [0.0] * 4
Q = np.tile(ONE, (3, 1))
P = np.array([[4.0, 1.0, -0.5], [1.0, 3.0, 0.2], [-0.5, 0.2, 0.5]]) * 1e-6
TWO = np.arange(2)
UP = VectorReadings(TWO, np.array([0.0, 0.0, 9.81]), 0.3)
ASLANT = VectorReadings(TWO, np.array([0.6, 0.0, 0.8]), 0.3)
MOTION = "slow_tumble"
TRUE = attitude(MOTION)
TRUTH = truth_of(MOTION)
EVERY = np.arange(len(STAMPS))
MASK = np.ma.masked_array([0, 1, 2], mask=[False, True, False])
NO_NUMBERS = [Q.astype(str), Q.astype(bool), Q.astype(str).astype(object), [[None] * 4] * 3, [[1, 2], [3]], {"q": Q}]
NO_ANGLES = (0.0, -1.0, np.nan, np.inf, "1deg", True, [1.0], 10**400, np.timedelta64(1, "s"), np.bool_(True))
NO_TIMES = (None, "0", 0.5, True, [[0], [1, 2]], 10**30)
FORTY = STAMPS[:20]
NO_PAIRS = [([1.0] * 50, [1.0] * 49), ([[1.0]], [[1.0]]), (1.0, 2.0), ([1.0], "b"), (None, [1.0]), ([1j], [1.0])]
NO_PAIRS += [([np.inf], [1.0]), ([1.0], [-2.0])]
ENSEMBLE = np.ones((12, 5, 3))
NO_ENSEMBLES = [
    (np.arange(5.0), ENSEMBLE[:9], np.eye(3)),
    (np.arange(5.0), ENSEMBLE, -np.eye(3)),
    *((np.arange(5.0), ENSEMBLE * value, np.eye(3)) for value in (np.nan, np.inf)),
    (np.arange(5.0), ENSEMBLE[0], np.eye(3)),
    (np.arange(5.0), ENSEMBLE, np.ones((5, 3, 3))),
    (np.arange(4.0), ENSEMBLE, np.eye(3)),
    (np.arange(5.0)[np.newaxis], ENSEMBLE, np.eye(3)),
    (np.arange(5.0), ENSEMBLE, np.eye(3), np.tile(ONE, (5, 1))),
]


def both(*given):
    """What both say that read stamps and attitudes."""
    with pytest.raises(InputError):
        SampledTruth(*given)
    read_series("estimate", *given)


def all_of(stamps):
    """What all say that are asked for the truth at some stamps."""
    sampled = SampledTruth([0, 1], Q[:2])
    asked = [ask for truth in (TRUTH, sampled) for ask in (truth.at, truth.covers, truth.states)]
    for ask in asked:
        with pytest.raises(InputError):
            ask(stamps)
    sampled.uncertainty_at(stamps)


def bounded(end):
    """The refusal of a last stamp."""
    with pytest.raises(InputError):
        SampledTruth([0, 1], Q[:2], end)
    ExactTruth(still, 0, end)


def still(stamps):
    return np.zeros((len(stamps), 4))


def score(stamps=STAMPS, estimate=TRUE, **given):
    return evaluate(stamps, estimate, TRUTH, **given)


def bound(**given):
    return cramer_rao_bound(TWO, Q[:2], NoisySensors(**{"gyro_noise": 0.1, **given}))


class Judge:
    """Something that has a method ``score``, and is no truth."""

    def score(self, *given, **how):
        return "a score"

    def __repr__(self):
        return "<Judge>"


def consistency(covariance, axes="world"):
    return score(covariance=covariance, covariance_axes=axes)


REFUSED = {
    InputError: [
        *(lambda value=value: Limits(max_rms_deg=value) for value in NO_ANGLES),
        *(lambda value=value: Limits(max_after=((1.0, value),)) for value in NO_ANGLES),
        *(lambda value=value: Limits(max_after=value) for value in (5, (5,), ((-1.0, 1.0),), ((np.nan, 1.0),))),
        lambda: Limits.parse("0deg"),
        *(lambda text=text: Limits.parse(text) for text in ("", "1", "-1deg", "1s", "1 deg deg", "1e999deg", "1,5deg")),
        *(
            lambda text=text: Limits.parse(max_after=text)
            for text in ("0s:0deg", 3, None, "10s2deg", "10:2deg", "1s:2s")
        ),
        lambda: score(limits="1deg"),
        lambda: both([], np.empty((0, 4))),
        lambda: both([0.0, 1.0], Q[:2]),
        lambda: both([[0], [1, 2]], Q[:2]),
        lambda: both([0, 5, 3], Q),
        lambda: both([0, 5], Q),
        lambda: both([0, 1], [ONE, ZERO]),
        lambda: both([0, 1], [ONE, [0, 0, np.nan, 0]]),
        *(lambda stamps=stamps: all_of(stamps) for stamps in NO_TIMES),
        lambda: SampledTruth([0, 0], Q[:2]),
        lambda: ExactTruth(still, 1, 0),
        *(lambda end=end: bounded(end) for end in (10**30, np.inf, np.nan, "0", [], 0.5)),
        lambda: read_stamps("estimate", np.array([-(2**63), 2**63 - 1])),
        lambda: read_stamps("estimate", np.array([2**63, 2**63 + 1], dtype=np.uint64)),
        *(lambda given=given: read_series("estimate", [0, 1, 2], given) for given in NO_NUMBERS),
        lambda: read_stamps("estimate", MASK),
        lambda: attitude_error([ONE, [np.nan, 0, 0, 1]], ONE),
        lambda: attitude_error(Q + 1j, Q),
        lambda: attitude_error(Q, np.ma.masked_array(Q, mask=Q == 0.0)),
        lambda: attitude_error(np.ones((3, 3)), Q),
        lambda: attitude_error(Q, Q[:2]),
        lambda: attitude_error(ONE, ZERO),
        lambda: attitude_error(np.empty((0, 4)), ONE),
        lambda: attitude_error("north", ONE),
        lambda: bias_error(np.zeros((2, 3)), np.diag([0.0, np.inf, 0.0])[:2]),
        lambda: score(STAMPS + 10**18),
        lambda: score(STAMPS.repeat(2)[:1501] + 10**18),
        lambda: score(np.full(1501, -(10**9))),
        lambda: score(STAMPS[:1] - 10**9, TRUE[:1]),
        lambda: score(STAMPS[::-1]),
        lambda: score(estimate=np.where(EVERY[:, np.newaxis] < 9, TRUE, np.nan)),
        lambda: score([], np.empty((0, 4))),
        lambda: score(None),
        lambda: score(longest_lag_s=-1.0),
        lambda: score(converged_deg=0.0),
        *(lambda truth=truth: evaluate(STAMPS, TRUE, truth) for truth in (Judge(), None, TRUE)),
        *(lambda given=given: of_runs(*given) for given in NO_PAIRS),
        *(lambda given=given: ensemble_consistency(*given) for given in NO_ENSEMBLES),
        lambda: ensemble_consistency(np.arange(5.0), ENSEMBLE, np.eye(3), axes="earth"),
        lambda: score(covariance=np.tile(P, (5, 1, 1))),
        lambda: score(covariance_axes="map"),
        lambda: consistency(np.zeros((3, 3))),
        lambda: consistency(np.diag([-1.0, 0.0, 0.0])),
        lambda: consistency(np.diag([1.0, 0.0, 1.0])),
        lambda: consistency(np.diag([1.0, -2.0, 1.0])),
        lambda: consistency(np.eye(3) * 1e-310),
        lambda: consistency([[1e-150, 1e200, 0], [1e200, 1e-150, 0], [0, 0, 1]]),
        lambda: consistency([[1, 2, 0], [0, 1, 0], [0, 0, 1]]),
        lambda: consistency([[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
        lambda: consistency(np.eye(2)),
        lambda: consistency(np.full((3, 3), np.nan)),
        lambda: consistency(np.tile(P, (7, 1, 1))),
        *(lambda axes=axes: consistency(P, axes=axes) for axes in ("map", ["world"])),
        *(lambda noise=noise: bound(gyro_noise=noise) for noise in (0.0, 1e-60, 1e200)),
        lambda: bound(vectors=[VectorReadings(TWO, 1e-300 * UP.vector, 0.3)]),
        lambda: bound(attitudes=[AttitudeReadings(TWO, 1e-30 * np.eye(3))]),
        lambda: bound(attitudes=[AttitudeReadings(TWO, np.eye(3) - 0.5)]),
    ],
}


def broken(limits, t_s, total_deg, given=0, due_s=0.0):
    """What a limit that is broken says of errors of one size."""
    tally = Tally(limits)
    total = np.full(len(t_s), np.radians(total_deg))
    tally.add(np.round(1e9 * np.array(t_s)).astype(np.int64), AttitudeError(total, total, total))
    [told] = tally.broken(given, round(1e9 * due_s))
    return told


def difference(ratio, runs=12, pairs=1):
    """The sentence on a ratio of errors that varies by a tenth over runs."""
    errors = np.linspace(1.0, 1.1, runs)
    return of_pairs([(ratio * errors, errors[::-1])] * pairs)[0].sentence("a", "b")


def about_other_axes():
    """The remark on a covariance of errors on the world's axes that is given as one on the body's."""
    errors = np.random.default_rng(1).normal(size=(4000, 3)) * [1e-3, 1e-2, 1e-1]
    truth = np.tile(quaternion.exp([0.0, np.pi / 2.0, 0.0]), (4000, 1))
    estimate = quaternion.multiply(quaternion.exp(errors), truth)
    return attitude_nees(estimate, truth, np.diag([1e-6, 1e-4, 1e-2]), "body").remark


def found(estimate, kept=EVERY, truth=TRUTH, stamps=STAMPS):
    """Code and sentence of the first finding of an estimate at some of the stamps."""
    first = evaluate(stamps[kept], estimate[kept], truth).findings[0]
    return f"{first.code}: {first.message}"


def noted(estimate):
    return "\n".join(note.message for note in evaluate(STAMPS, estimate, TRUTH).notes)


def left(turn):
    return found(quaternion.multiply(turn, TRUE))


def right(turn):
    return found(quaternion.multiply(TRUE, turn))


def coarse():
    fast = attitude("fast_tumble")
    return found(fast, truth=SampledTruth(STAMPS[::20], fast[::20]))


def spinning():
    spin = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0]))
    truth = ExactTruth(lambda t_ns: spin.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    return found(quaternion.multiply(about_up(4.0), spin.at(STAMPS).attitude_xyzw), truth=truth)


def turning(matrix):
    """The remark on a gyro that reads the turns of a body by a matrix."""
    [remark] = remarks_on(matrix)
    return f"{remark.code}: {remark.message}"


SAID = [
    lambda: broken(Limits(1.0), [0.0], 2.0),
    lambda: broken(Limits(max_after=((1.0, 1.0),)), [0.0, 2.0], 3.0),
    lambda: broken(Limits(max_after=((9.0, 1.0),)), [0.0, 2.0], 3.0),
    lambda: broken(Limits(9.0), [0.0, 2.0], 3.0, given=90),
    lambda: broken(Limits(9.0), [0.0, 2.0], 3.0, due_s=60.0),
    lambda: difference(0.5),
    lambda: difference(1.0),
    lambda: difference(1.0, 7, 6),
    lambda: of_runs([np.nan, 1.0], [1.0, 1.0]).sentence("a", "b"),
    lambda: bound().unobserved,
    lambda: bound(vectors=[UP]).unobserved,
    lambda: bound(vectors=[ASLANT]).unobserved,
    lambda: about_other_axes(),
    lambda: found(quaternion.conjugate(TRUE)),
    lambda: found(np.roll(TRUE, 1, axis=-1)),
    lambda: left(NED),
    lambda: found(quaternion.multiply(quaternion.multiply(NED, TRUE), FRD)),
    lambda: left(about_up(-12.0)),
    lambda: left(quaternion.exp([0.0, np.pi / 3, 0.0])),
    lambda: right(quaternion.exp([0.0, 0.0, np.pi / 2])),
    lambda: found(attitude(MOTION, 0.5)),
    lambda: noted(attitude(MOTION, -0.02)),
    lambda: found(attitude(MOTION, -0.5)),
    lambda: found(np.tile(TRUE[:1], (len(STAMPS), 1))),
    lambda: found(TRUE[np.where((EVERY >= 100) & (EVERY < 700), 100, EVERY)]),
    lambda: spinning(),
    lambda: found(np.where(EVERY[:, np.newaxis] % 2, TRUE[::-1], TRUE)),
    lambda: found(TRUE, np.delete(EVERY, slice(200, 300))),
    lambda: found(TRUE, np.repeat(EVERY, 2)),
    lambda: found(TRUE, EVERY[600:]),
    lambda: found(TRUE, EVERY[:900]),
    lambda: coarse(),
    lambda: found(1.01 * TRUE),
    lambda: turning(DEGREE * UNCHANGED),
    lambda: turning(UNCHANGED / DEGREE),
    lambda: turning(2.0 * UNCHANGED),
    lambda: turning(10.0 * UNCHANGED),
    lambda: turning(0.3 * UNCHANGED),
    lambda: turning(SWAPPED),
    lambda: turning(CYCLED),
    lambda: turning(DEGREE * SWAPPED),
]
