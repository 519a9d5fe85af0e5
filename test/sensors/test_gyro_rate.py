"""The rate of a gyro: at an instant it is the body's, over an interval it is the turn itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation
from sensor_models import MOTION, STEP_NS, imu, times

from lie_rigid_body import State
from lie_rigid_body.sensors.imu import IntegratedRate


def test_an_instantaneous_rate_is_the_body_rate() -> None:
    t = times(100)
    assert imu().measure(t, MOTION.at(t))["gyro"].tolist() == MOTION.at(t).body_rate.tolist()


@pytest.mark.parametrize("jitter_ns", [0, 3_000_000])
def test_integrated_rates_compose_to_the_turn_of_the_body(jitter_ns: int) -> None:
    t = times(500) + np.random.default_rng(2).integers(0, jitter_ns + 1, 500)
    rates = imu(gyro_rate="integrated").measure(t, MOTION.at(t))["gyro"]
    turn = Rotation.from_quat(MOTION.at(np.array([-STEP_NS])).attitude_xyzw[0])
    for rate, dt, truth in zip(rates, np.diff(t, prepend=-STEP_NS), MOTION.at(t).attitude_xyzw, strict=True):
        turn = turn * Rotation.from_rotvec(rate * (dt * 1e-9))
        assert (turn.inv() * Rotation.from_quat(truth)).magnitude() < 2e-13


def test_an_integrated_rate_is_the_rate_in_the_middle_of_a_short_interval() -> None:
    """The difference falls with the square of the interval."""
    errors = []
    for step in (STEP_NS, STEP_NS // 10):
        t = np.array([step], dtype=np.int64)
        gyro = imu(0, gyro_rate="integrated")
        middle = MOTION.at(t // 2).body_rate
        errors.append(np.abs(gyro.measure(t, MOTION.at(t))["gyro"] - middle).max())
    assert errors[0] < 1e-4
    assert errors[1] == pytest.approx(errors[0] / 100.0, rel=0.02)


def test_the_sign_of_a_quaternion_changes_nothing() -> None:
    t = times(20)
    states = MOTION.at(t)
    signs = np.where(np.arange(20) % 3 == 0, -1.0, 1.0)[:, np.newaxis]
    flipped = State.trusted(states.attitude_xyzw * signs, states.body_rate)
    plain, other = (imu(gyro_rate="integrated").measure(t, s)["gyro"] for s in (states, flipped))
    assert plain.tolist() == other.tolist()


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-160, 1e-17, 1e-8, 1e-3, 0.5, 2.0, 3.1, math.pi - 1e-12])
@pytest.mark.parametrize("interval_ns", [1, 10_000_000, 10**15])
def test_an_integrated_rate_is_right_for_the_smallest_turns_and_up_to_half_a_turn(
    angle: float, interval_ns: int
) -> None:
    with mp.workdps(60):
        half = mpf(angle) / 2
        before = State([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
        after = State([[float(mp.sin(half)), 0.0, 0.0, float(mp.cos(half))]], [[0.0, 0.0, 0.0]])
        [rate] = IntegratedRate(0, before).over(np.array([interval_ns]), after)
        assert rate.tolist() == pytest.approx(
            [float(mpf(angle) * 10**9 / interval_ns), 0.0, 0.0], rel=1e-15, abs=1e-320
        )
