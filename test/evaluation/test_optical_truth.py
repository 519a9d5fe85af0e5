"""Beside the truth of a motion capture system, with a world, markers and a clock of its own, constants are named."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from lie_rigid_body import SampledTruth
from lie_rigid_body.evaluation.causes import UP
from lie_rigid_body.evaluation.matched import Matched, lags_of_rates
from lie_rigid_body.lie import quaternion
from untyped import evaluate

NS = 10**9
RATE = 50.0
T_NS = np.arange(2000) * 20_000_000
WORLD = np.array([0.9, -0.4, 0.5])
MARKERS = np.array([0.4, 1.1, -0.2])
TILTED = np.array([0.05, 0.1, 2.1])  # by 6°: more than a heading explains


@cache
def hand(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes and body rates of 40 s of a motion by hand: harmonics in 0.05 to 1 Hz about all axes."""
    rng = np.random.default_rng(seed)
    harmonics = 2.0 * np.pi * rng.uniform(0.05, 1.0, (8, 3)) * (T_NS / NS)[:, np.newaxis, np.newaxis]
    rate = 0.5 * np.sin(harmonics + rng.uniform(0.0, 6.0, (8, 3))).sum(axis=1)
    found = [quaternion.normalize(rng.normal(size=4))]
    for step in quaternion.exp(rate[1:] / RATE):
        found.append(quaternion.normalize(quaternion.multiply(found[-1], step)))
    return np.array(found), rate


def noisy(seed: int = 0) -> np.ndarray:
    noise = np.random.default_rng(9).normal(size=(len(T_NS), 3))
    return quaternion.multiply(quaternion.exp(np.radians(0.5) * noise), hand(seed)[0])


def optical(world: np.ndarray, markers: np.ndarray, late_s: float) -> SampledTruth:
    """The motion in another world, on the axes of markers, by a clock that is late."""
    true = quaternion.multiply(quaternion.multiply(quaternion.exp(-world), hand()[0]), quaternion.exp(-markers))
    return SampledTruth(T_NS + round(late_s * NS), true)


NO = np.zeros(3)
CASES = [
    (NO, NO, 7.3, {"leading"}),
    (1.3 * UP, MARKERS, -0.35, {"heading_offset", "body_mounting", "lagging"}),
    (1.3 * UP, MARKERS, 8.2, {"heading_offset", "body_mounting", "leading"}),
    (NO, MARKERS, -3.1, {"body_mounting", "lagging"}),
    (WORLD, NO, 0.08, {"world_turned", "leading"}),
    (WORLD, MARKERS, 0.0, {"world_turned", "body_mounting"}),
    (WORLD, MARKERS, 2.4, {"world_turned", "body_mounting", "leading"}),
    (TILTED, MARKERS, 0.0, {"world_turned", "body_mounting"}),
    (TILTED, MARKERS, -0.35, {"world_turned", "body_mounting", "lagging"}),
    (TILTED, MARKERS, 8.2, {"world_turned", "body_mounting", "leading"}),
]


@pytest.mark.parametrize(("world", "markers", "late_s", "codes"), CASES)
def test_world_markers_and_clock_are_named_together(world, markers, late_s, codes):
    score = evaluate(T_NS, noisy(), optical(world, markers, late_s))
    found = [finding for finding in score.findings if finding.code != "gaps"]
    assert {finding.code for finding in found} == codes
    assert found[-1].rms_deg_after < 1.1
    if late_s:
        assert score.lag_s == pytest.approx(-late_s, abs=0.005)
        assert score.lag_standard_error_s < 0.01


def test_of_one_axis_no_world_is_told_from_markers():
    """By a motion about the vertical: a turn of the world is one of the markers, and a lag is either."""
    angle = np.cumsum(np.full(len(T_NS), 0.7 / RATE))[:, np.newaxis]
    true = quaternion.exp(angle * UP)
    turned = quaternion.multiply(quaternion.exp(WORLD), quaternion.multiply(true, quaternion.exp(MARKERS)))
    codes = {finding.code for finding in evaluate(T_NS, turned, SampledTruth(T_NS, true)).findings}
    assert not {"world_turned", "body_mounting"} <= codes
    assert not codes & {"lagging", "leading"}


@pytest.mark.parametrize("late_s", [-6.0, -0.5, 0.0, 9.5])
def test_rates_tell_a_lag_whatever_the_frames(late_s):
    track = Matched(T_NS, noisy(), optical(WORLD, MARKERS, late_s))
    assert lags_of_rates(track, 10.0)[0] == pytest.approx(-late_s, abs=0.06)
    steady = quaternion.exp(np.outer(np.arange(len(T_NS)) / RATE, [0.3, 0.2, 0.4]))
    assert lags_of_rates(Matched(T_NS, steady, SampledTruth(T_NS, steady)), 10.0) == []


@pytest.mark.slow
@pytest.mark.parametrize("memory", [0.5, 1.0, 3.0])
def test_what_converges_through_the_whole_run_is_no_constant(memory):
    """A heading that decays with a time constant of half a run to three runs; one that stays is named."""
    decay = np.exp(-np.arange(len(T_NS)) / (memory * len(T_NS)))[:, np.newaxis]
    slow = quaternion.multiply(quaternion.exp(1.2 * decay * UP), noisy())
    score = evaluate(T_NS, slow, optical(NO, NO, 0.0))
    assert score.findings == ()
    assert score.lag_s is None or abs(score.lag_s) <= 3.0 * score.lag_standard_error_s
    stays = quaternion.multiply(quaternion.exp(1.2 * UP + 0.1 * decay * UP), noisy())
    assert [finding.code for finding in evaluate(T_NS, stays, optical(NO, NO, 0.0)).findings] == ["heading_offset"]


def before_its_step(rate: np.ndarray, true: np.ndarray, gain: float) -> np.ndarray:
    """Mahony's filter with perfect readings of two vectors, compared with the attitude before the gyro's step."""
    q = true[0]
    found = [q]
    north = np.array([0.0, 0.6, -0.8])
    for k in range(1, len(true)):
        back, now = quaternion.conjugate(q), quaternion.conjugate(true[k])
        off = sum(np.cross(quaternion.rotate(now, v), quaternion.rotate(back, v)) for v in (UP, north))
        q = quaternion.normalize(quaternion.multiply(q, quaternion.exp((rate[k] + gain * off) / RATE)))
        found.append(q)
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.5, 2.0, 10.0])
@pytest.mark.parametrize("steady", [[0.0, 0.0, 0.0], [0.3, 1.0, 0.5]])
def test_a_filter_that_compares_before_its_step_has_a_note_and_no_mounting(gain, steady):
    """Its lead of a sample is in the mean a mounting by the turn in a sample, 1.3° here, about the mean rate."""
    rate = 0.3 * hand()[1] + np.array(steady)
    true = [hand()[0][0]]
    for step in quaternion.exp(rate[1:] / RATE):
        true.append(quaternion.normalize(quaternion.multiply(true[-1], step)))
    score = evaluate(T_NS, before_its_step(rate, np.array(true), gain), SampledTruth(T_NS, true))
    assert score.findings == ()
    assert [note.code for note in score.notes] == ["ahead_by_a_sample"]
    assert 0.0 < score.notes[0].value < 2.0 * np.degrees(np.linalg.norm(rate, axis=1).max() / RATE)
    assert evaluate(T_NS, np.array(true), SampledTruth(T_NS, true)).notes == ()
    across = quaternion.exp(np.radians(3.0) * np.cross([0.3, 1.0, 0.5], UP))
    mounted = quaternion.multiply(before_its_step(rate, np.array(true), gain), across)
    found = evaluate(T_NS, mounted, SampledTruth(T_NS, true)).findings
    assert [finding.code for finding in found] == ["body_mounting"]
