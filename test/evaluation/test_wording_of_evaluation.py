"""What the room `evaluation` says when it refuses: the value, the limit and the remedy, in one short line.

And its sentences about limits and differences.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from motions import STAMPS, attitude, truth_of

from lie_rigid_body.evaluation import (
    AttitudeReadings,
    BiasNoise,
    ExactTruth,
    Limits,
    SampledTruth,
    VectorReadings,
    attitude_error,
    attitude_nees,
    bias_error,
    evaluate,
    nees,
    unavoidable_error,
)
from lie_rigid_body.evaluation.arguments import read_series, read_stamps
from lie_rigid_body.evaluation.attitudes import AttitudeError
from lie_rigid_body.evaluation.differences import Difference, of_run, of_runs
from lie_rigid_body.evaluation.honesty import honesty
from lie_rigid_body.evaluation.statistics import Tally
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import LONGEST_LINE
from lie_rigid_body.lie import quaternion

WRONG: Any = 3
ONE, ZERO = [0.0, 0.0, 0.0, 1.0], [0.0] * 4
Q = np.tile(ONE, (3, 1))
P = np.array([[4.0, 1.0, -0.5], [1.0, 3.0, 0.2], [-0.5, 0.2, 0.5]]) * 1e-6
GIVEN: dict[str, Any] = {"stamps_ns": [0, 1], "truth_xyzw": [ONE] * 2, "gyro_noise": 0.1}
UP, ASLANT = VectorReadings([0, 1], [0.0, 0.0, 9.81], 0.3), VectorReadings([0, 1], [0.6, 0.0, 0.8], 0.3)
TRUE = attitude("slow_tumble")
MASK = np.ma.masked_array([0, 1, 2], mask=[False, True, False])
NO_NUMBERS: list[Any] = [
    *(Q.astype(str), Q.astype(bool), Q.astype(str).astype(object), [[None] * 4] * 3, [[1, 2], [3]], {"q": Q}, object())
]

Call = Callable[[], object]


def still(stamps: Any) -> np.ndarray:
    return np.zeros((len(stamps), 4))


def score(stamps: Any, estimate: Any, **given: Any) -> object:
    return evaluate(stamps, estimate, truth_of("slow_tumble"), **given)


def series(*given: Any) -> list[Call]:
    """Both that read stamps and attitudes."""
    return [lambda: read_series("estimate", *given), lambda: SampledTruth(*given)]


def limits(value: Any) -> list[Call]:
    return [lambda: Limits(max_rms_deg=value), lambda: Limits(max_after=((1.0, value),))]


def unavoidable(**given: Any) -> Call:
    return lambda: unavoidable_error(**{**GIVEN, **given})


def consistency(covariance: Any, **more: Any) -> Call:
    return lambda: attitude_nees(np.tile(ONE, (4000, 1)), np.tile(ONE, (4000, 1)), covariance, **more)


NO_TIMES: list[Any] = [10**30, np.inf, np.nan, "0", []]
REFUSED: dict[str, list[Call]] = {
    # limits
    "is not a finite number of degrees above 0: give": [
        call for value in (0.0, -1.0, np.nan, np.inf, "1deg", True, [1.0], 10**400) for call in limits(value)
    ],
    "max_after": [
        lambda value=value: Limits(max_after=value)  # type: ignore[misc]
        for value in (5, (5,), ((-1.0, 1.0),), ((np.nan, 1.0),))
    ],
    "give": [
        lambda: Limits.parse("0deg"),
        *(lambda text=text: Limits.parse(max_after=text) for text in ("0s:0deg", WRONG, None)),
    ],
    "an angle such as 1deg": [
        lambda text=text: Limits.parse(text)  # type: ignore[misc]
        for text in ("", "1", "deg", "-1deg", "1s", "nan deg", "1 deg deg", "1e999deg", "1,5deg", "١deg")
    ],
    "10s:2deg": [lambda: Limits.parse(max_after="10s"), lambda: Limits.parse(max_after="10s2deg")],
    "a time such as 10s": [lambda: Limits.parse(max_after="10:2deg")],
    "an angle such as": [lambda: Limits.parse(max_after="10s:2s")],
    r"limits: '1deg' is none: give for example Limits.parse\('1deg'": [lambda: score(STAMPS, TRUE, limits="1deg")],
    # stamps and attitudes
    "give a flat list of at least one": series([], np.empty((0, 4))),
    "integer nanoseconds": [
        *series([0.0, 1.0], Q[:2]),
        *series([[0], [1, 2]], Q[:2]),
        *(
            lambda ask=ask, stamps=stamps: ask(stamps)
            for truth in (truth_of("slow_tumble"), SampledTruth([0, 1], Q[:2]))
            for ask in (truth.at, truth.covers, truth.states, SampledTruth([0, 1], Q[:2]).uncertainty_at)
            for stamps in (None, "0", 0.5, True, [[0], [1, 2]], 10**30)
        ),
    ],
    "out of order in 1 places, first at sample 2, 2e-09 s": series([0, 5, 3], Q),
    "for 2 stamps": series([0, 5], Q),
    "1 of 2 quaternions are zero or overflow, the first is row 1.* or fill in the orientation": series(
        [0, 1], [ONE, ZERO]
    ),
    "1 of 2 rows are not finite, the first is row 1": [
        *series([0, 1], [ONE, [0, 0, np.nan, 0]]),
        lambda: attitude_error([ONE, [np.nan, 0, 0, 1]], ONE),
    ],
    "a stamp occurs twice": [lambda: SampledTruth([0, 0], Q[:2])],
    "ends at 0 ns": [lambda: ExactTruth(still, 1, 0)],
    r"is no whole number within 2\*\*31 s of 0": [
        call
        for time in (*NO_TIMES, 0.5)
        for call in (
            partial(ExactTruth, still, 0, time),
            partial(SampledTruth, [0, 1], Q[:2], time),
        )
    ],
    r"those of ROS 2 are within 2\*\*31 s: give nanoseconds": [
        lambda: read_stamps("estimate", np.array([-(2**63), 2**63 - 1])),
        lambda: read_stamps("estimate", np.array([2**63, 2**63 + 1], dtype=np.uint64)),
    ],
    "estimate: not numbers: give an array of shape": [
        lambda given=given: read_series("estimate", [0, 1, 2], given)  # type: ignore[misc]
        for given in NO_NUMBERS
    ],
    "complex": [lambda: attitude_error(Q + 1j, Q), lambda: nees(np.zeros((3, 3)), np.eye(3) * 1j)],
    "masked": [
        lambda: attitude_error(Q, np.ma.masked_array(Q, mask=Q == 0.0)),
        lambda: read_stamps("estimate", MASK),
    ],
    # errors
    r"estimate_xyzw: shape \(3, 3\) is not \(\.\.\., 4\)": [lambda: attitude_error(np.ones((3, 3)), Q)],
    r"does not go with truth_xyzw of shape \(2, 4\)": [
        lambda: attitude_error(Q, Q[:2]),
        lambda: attitude_nees(Q, Q[:2], P),
    ],
    "truth_xyzw: 1 of 1 quaternions are zero or overflow": [lambda: attitude_error(ONE, ZERO)],
    "empty": [lambda: attitude_error(np.empty((0, 4)), ONE)],
    "not numbers": [lambda: attitude_error("north", ONE)],
    "truth: 1 of 2 rows are not finite": [lambda: bias_error(np.zeros((2, 3)), np.diag([0.0, np.inf, 0.0])[:2])],
    r"truth: shape \(1, 3\) is not \(5, 3\)": [lambda: bias_error(np.zeros((5, 3)), np.zeros((1, 3)))],
    r"truth: shape \(6, 3\) is not \(5, 3\)": [lambda: bias_error(np.zeros((5, 3)), np.zeros((6, 3)))],
    # a score
    "none of its 1501 stamps is within the truth, from 0 s to 30 s: they begin 1e.09 s after it": [
        lambda: score(STAMPS + 10**18, TRUE)
    ],
    "none of its 1501 stamps is within the truth, from 0 s to 30 s": [
        lambda: score(STAMPS.repeat(2)[:1501] + 10**18, TRUE)
    ],
    "all of its 1501 stamps are -1000000000 ns: fill in header.stamp": [lambda: score(np.full(1501, -(10**9)), TRUE)],
    "none of its 1 stamps is within the truth": [lambda: score(STAMPS[:1] - 10**9, TRUE[:1])],
    "out of order in 1500 places": [lambda: score(STAMPS[::-1], TRUE)],
    "1492 of 1501 rows are not finite": [
        lambda: score(STAMPS, np.where(np.arange(1501)[:, np.newaxis] < 9, TRUE, np.nan))
    ],
    "at least one": [lambda: score([], np.empty((0, 4)))],
    "left_out: .* is no whole number from 0 on": [
        lambda given=given: score(STAMPS, TRUE, left_out=given)  # type: ignore[misc]
        for given in ("x", -1, 1.5, None, [0])
    ],
    "due_ns: .* is no whole number from": [
        lambda given=given: score(STAMPS, TRUE, due_ns=given)  # type: ignore[misc]
        for given in ("x", 0.5, -(10**400), [0])
    ],
    r"bound .*, sensors .*: give what unavoidable_error\(\) returns, and rad from 0 on": [
        lambda given=given: score(STAMPS, TRUE, **given)  # type: ignore[misc]
        for given in ({"bound": "x"}, *({"sensors": given} for given in ("x", -1.0, np.nan, [0.1])))
    ],
    "seed: .* is no whole number from 0 on: give one": [
        lambda judge=judge, seed=seed: judge(seed)  # type: ignore[misc]
        for judge in (
            lambda seed: of_run(STAMPS[:20], STAMPS[:20], seed),
            lambda seed: of_runs(STAMPS[:20], STAMPS[:20], seed),
            lambda seed: honesty(np.arange(5.0), np.ones((12, 5, 3)), np.eye(3), seed=seed),
        )
        for seed in ("x", -1, 1.5, True, None)
    ],
    "5 of them for 1501 estimates": [lambda: score(STAMPS, TRUE, covariance=np.tile(P, (5, 1, 1)))],
    # covariances
    "says that the estimator does not know it": [consistency(np.zeros((3, 3))), consistency(np.diag([-1.0, 0.0, 0.0]))],
    "0 on its diagonal: give positive variances": [consistency(np.diag([1.0, 0.0, 1.0]))],
    "-2 on its diagonal: give positive variances": [consistency(np.diag([1.0, -2.0, 1.0]))],
    "1e-310 on its diagonal: give positive variances, 1e-200 at least": [consistency(np.eye(3) * 1e-310)],
    "not symmetric": [
        consistency([[1e-150, 1e200, 0], [1e200, 1e-150, 0], [0, 0, 1]]),
        consistency([[1, 2, 0], [0, 1, 0], [0, 0, 1]]),
    ],
    "not positive definite": [
        consistency([[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
        lambda: AttitudeReadings([0], np.eye(3) - 0.5),
    ],
    r"shape \(2, 2\) is not": [consistency(np.eye(2))],
    "not finite": [consistency(np.full((3, 3), np.nan))],
    r"is not \(3, 3\) or \(4000, 3, 3\)": [consistency(np.tile(P, (7, 1, 1)))],
    "give 'world' or 'body'": [
        *(consistency(P, axes=axes) for axes in ("map", ["world"], None)),
        lambda: score(STAMPS, TRUE, covariance_axes="map"),
    ],
    r"is not between 0 and 1: give for example probability=0\.95": [
        lambda given=given: nees(np.zeros((9, 3)), P, given)  # type: ignore[misc]
        for given in (2.0, -1, np.nan, 0.0, 1.0, "0.95", [0.9])
    ],
    r"up to 1e\+200: the NEES overflows": [lambda: nees(np.full((9, 3), 1e200), np.eye(3))],
    # the unavoidable error
    "gyro_noise: 0.0 is not a finite number of SI units above 0": [unavoidable(gyro_noise=0.0)],
    "initial": [unavoidable(initial=np.nan)],
    "rising": [unavoidable(stamps_ns=[1, 1])],
    "noise of a vector: 0.0": [lambda: VectorReadings([0], [0.0, 0.0, 9.81], 0.0)],
    "has no direction": [lambda: VectorReadings([0], [0.0, 0.0, 0.0], 0.1)],
    "turn_on: -1.0": [lambda: BiasNoise(turn_on=-1.0)],
    "covariance: shape .2, 3, 3. is not .3, 3.": [lambda: AttitudeReadings([0, 1], np.tile(np.eye(3), (2, 1, 1)))],
    "gyro_readings: .1, 0.: give a number of 1 or more": [unavoidable(gyro_readings=[1, 0])],
    "gyro_readings": [unavoidable(gyro_readings=[[1, 1]] * 2)],
    "bias: 0.03 is none: give a BiasNoise": [
        lambda: VectorReadings([0], [0.0, 0.0, 9.81], 0.1, bias=0.03),  # type: ignore[arg-type]
        unavoidable(gyro_bias=0.03),
    ],
    "vectors: .* is none: give a list of VectorReadings": [
        unavoidable(vectors=given) for given in (UP, [[0, 0, 9.8]], None)
    ],
    "attitudes: .* is none: give a list of AttitudeReadings": [
        unavoidable(attitudes=given) for given in (AttitudeReadings([0], np.eye(3)), [UP], None)
    ],
    "linear_errors: not numbers: give an array": [
        call
        for given in ([[1, 2], [3]], "x")
        for call in (
            partial(VectorReadings, [0], [0.0, 0.0, 9.81], 0.1, linear_errors=given),
            unavoidable(gyro_linear_errors=given),
        )
    ],
    "gyro_noise: 1e.200 is beyond": [unavoidable(gyro_noise=1e200)],
    "give integer nanoseconds": [unavoidable(stamps_ns=[0.0, 1.0])],
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("said", REFUSED)
def test_it_is_refused_in_one_line(said: str) -> None:
    for call in REFUSED[said]:
        with pytest.raises(InputError, match=said) as caught:
            call()
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) <= LONGEST_LINE


def broken(limits: Limits, t_s: list[float], total_deg: float, given: int = 0, due_s: float = 0.0) -> str:
    """What a limit that is broken says of errors of one size."""
    tally, total = Tally(limits), np.full(len(t_s), np.radians(total_deg))
    tally.add(np.round(1e9 * np.array(t_s)).astype(np.int64), AttitudeError(total, total, total))
    [told] = tally.broken(given, round(1e9 * due_s))
    return told


def difference(low: float, high: float, better: int = 1, runs: int = 1) -> str:
    return Difference(0.5 * (low + high), low, high, better, runs).sentence("a", "b")


def about_other_axes() -> str:
    """The remark on a covariance of errors on the world's axes that is given as one on the body's."""
    errors = np.random.default_rng(1).normal(size=(4000, 3)) * [1e-3, 1e-2, 1e-1]
    truth = np.tile(quaternion.exp([0.0, np.pi / 2.0, 0.0]), (4000, 1))
    estimate = quaternion.multiply(quaternion.exp(errors), truth)
    return attitude_nees(estimate, truth, np.diag([1e-6, 1e-4, 1e-2]), "body").remark


LITTLE = "were compared: limits hold for at least half of them"
SAID: dict[str, Callable[[], str]] = {
    "the error is 2° rms, above the limit of 1°": lambda: broken(Limits(1.0), [0.0], 2.0),
    "the error is 3° at 2 s, above the limit of 1° after 1 s": lambda: broken(
        Limits(max_after=((1.0, 1.0),)), [0.0, 2.0], 3.0
    ),
    "the estimate ends at 2 s, before the limit after 9 s begins": lambda: broken(
        Limits(max_after=((9.0, 1.0),)), [0.0, 2.0], 3.0
    ),
    f"only 2 of 90 estimates {LITTLE}": lambda: broken(Limits(9.0), [0.0, 2.0], 3.0, given=90),
    f"only 2 of 60 s since the first estimate {LITTLE}": lambda: broken(Limits(9.0), [0.0, 2.0], 3.0, due_s=60.0),
    "a is better than b by 2° ± 0.5°": lambda: difference(-2.5, -1.5),
    "b is better than a by 2° ± 0.5°, in 6 of 9 runs": lambda: difference(1.5, 2.5, 3, 9),
    "a and b: no difference that 9 runs could show (-1° to +1°)": lambda: difference(-1.0, 1.0, 4, 9),
    "a and b: too few common runs (3) to tell a difference": lambda: Difference(0.0, -np.inf, np.inf, 1, 3).sentence(
        "a", "b"
    ),
    "the attitude": lambda: unavoidable_error(**GIVEN).unobserved,
    "a turn about the vertical": lambda: unavoidable_error(**GIVEN, vectors=[UP]).unobserved,
    "a turn about (0.6, 0, 0.8) of the world": lambda: unavoidable_error(**GIVEN, vectors=[ASLANT]).unobserved,
    "if the covariance is about them, give covariance_axes world": lambda: about_other_axes().partition(": ")[2],
}
"""Sentences about limits, differences, covariances and what no sensor tells, each with what says it."""


@pytest.mark.parametrize("sentence", SAID)
def test_what_is_found_is_said(sentence: str) -> None:
    assert SAID[sentence]() == sentence
