"""The table of causes: what each repair does to an estimate that has its mistake, and the fits of its constants."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.causes import BY_CODE, CAUSES, derivative, fit, or_else
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.lie import quaternion

T_NS = np.arange(0, 20 * 10**9, 2 * 10**7)
STATES = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0.1, -0.2, 0.3, np.sqrt(0.86)], [0.9, -0.7, 1.1])).at(T_NS)
TRUTH = SampledTruth(T_NS, STATES.attitude_xyzw)
CONSTANTS = {
    "heading_offset": [0.4],
    "world_turned": [0.2, -0.3, 0.5],
    "lagging": [0.05],
    "leading": [-0.05],
    "clock_rate": [1.01],
    "body_mounting": [-0.1, 0.6, 0.2],
}


def track_of(attitude_xyzw: np.ndarray, t_ns: np.ndarray = T_NS) -> Matched:
    return Matched(t_ns, attitude_xyzw, TRUTH)


def mistaken(code: str) -> Matched:
    """An estimate with one mistake of known size, in the middle of the truth's time where it moves stamps."""
    inner = T_NS[100:-100]
    q = STATES.attitude_xyzw[100:-100]
    if code in ("lagging", "leading"):
        return track_of(q, inner + round(1e9 * CONSTANTS[code][0]))
    if code == "clock_rate":
        return track_of(q, inner[0] + np.round((inner - inner[0]) * 1.01).astype(np.int64))
    turn = np.array(CONSTANTS[code])
    if code == "heading_offset":
        return track_of(quaternion.multiply(quaternion.exp([0.0, 0.0, turn[0]]), q), inner)
    if code == "world_turned":
        return track_of(quaternion.multiply(quaternion.exp(turn), q), inner)
    return track_of(quaternion.multiply(q, quaternion.exp(turn)), inner)


def test_each_cause_has_as_many_constants_as_its_price() -> None:
    track = track_of(STATES.attitude_xyzw)
    for cause in CAUSES:
        slopes = cause.slopes(track, STATES.attitude_xyzw, STATES.body_rate)
        assert slopes.shape == (len(T_NS), 3, cause.price), cause.code


@pytest.mark.parametrize("code", CONSTANTS)
def test_the_constants_of_a_mistake_are_found(code: str) -> None:
    found, left = BY_CODE[code].fitted([mistaken(code)])
    assert left < 1e-4
    expected = [1.0 / CONSTANTS[code][0]] if code == "clock_rate" else CONSTANTS[code]
    assert found == pytest.approx(expected, abs=2e-4) or found == pytest.approx(CONSTANTS[code], abs=2e-4)


@pytest.mark.parametrize("code", CONSTANTS)
def test_slopes_are_the_change_of_the_error(code: str) -> None:
    track = mistaken(code)
    constants = np.array(CONSTANTS[code])
    cause = BY_CODE[code]
    J, error, _ = derivative(track, [(cause, constants)])
    size = 1e-6 if code in ("heading_offset", "world_turned", "body_mounting") else 1e-4  # stamps are whole ns
    for k in range(cause.price):
        step = np.zeros(cause.price)
        step[k] = size
        _, moved, _ = derivative(track, [(cause, cause.moved(constants, step))])
        inside = slice(50, -50)
        limit = 0.05 * np.abs(J).max()
        np.testing.assert_allclose(((error - moved) / size)[inside], J[inside, :, k], rtol=0, atol=limit)


@pytest.mark.parametrize("samples", [0.5, 1.5])
def test_a_lag_of_less_than_a_sample_is_none(samples: float) -> None:
    lag_s = 0.02 * samples
    track = track_of(STATES.attitude_xyzw[100:-100], T_NS[100:-100] + round(1e9 * lag_s))
    [found] = BY_CODE["lagging"].fits([track])
    assert found == pytest.approx([lag_s if samples > 1.0 else 0.0], abs=1e-4)
    assert BY_CODE["leading"].fits([track])[0] == [0.0]


def test_a_fit_ends_at_the_constants_that_it_begins_near() -> None:
    [(_, found)] = fit([mistaken("world_turned")], [(BY_CODE["world_turned"], np.array([0.3, -0.2, 0.4]))])
    assert found == pytest.approx(CONSTANTS["world_turned"], abs=1e-9)


@pytest.mark.parametrize(
    ("code", "named", "other", "found"),
    [
        ("a", ["a"], ["b"], "b"),
        ("a", ["a", "b"], ["c", "b"], "c"),
        ("a", ["a", "b"], ["c"], ""),
        ("a", ["a", "b"], ["c", "d"], ""),
        ("a", ["a"], ["a"], ""),
        ("a", ["a", "b"], ["a", "c"], ""),
        ("a", ["a"], ["b", "c"], ""),
    ],
)
def test_another_explanation_takes_the_place_of_one_name(code: str, named: list[str], other: list[str], found: str):
    assert or_else(code, named, other) == found
