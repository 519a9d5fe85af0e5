"""The bound of the attitude's error against normal equations of all unknowns, a Riccati equation, and a real filter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_are
from scipy.spatial.transform import Rotation

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation.cramer_rao_bound import (
    AttitudeReadings,
    BiasNoise,
    CramerRaoBound,
    NoisySensors,
    VectorReadings,
    cramer_rao_bound,
    dynamic_bound,
)
from lie_rigid_body.lie.so3 import hat
from lie_rigid_body.lie.vectors import norm
from said import numbers

MOTION = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0.1, -0.3, 0.2, np.sqrt(0.86)], [0.3, 1.0, -0.4]))
PERIOD_NS = 20_000_000
H = PERIOD_NS / 1e9
UP, NORTH = np.array([0.0, 0.0, 9.81]), np.array([0.05, 0.4, -0.8])


def stamps(count: int) -> np.ndarray:
    return np.arange(count) * PERIOD_NS


def test_a_body_at_rest_comes_to_the_solution_of_the_riccati_equation():
    t_ns, q = stamps(3000), np.tile([0.0, 0.0, 0.0, 1.0], (3000, 1))
    vectors = [VectorReadings(t_ns, UP, 0.5), VectorReadings(t_ns, NORTH, 0.02)]
    found = cramer_rao_bound(t_ns, q, NoisySensors(gyro_noise=0.01, gyro_bias=BiasNoise(0.01, 1e-4), vectors=vectors))
    a = np.block([[np.eye(3), H * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
    into = np.vstack([H * np.eye(3), np.eye(3)])
    added = 1e-8 * into @ into.T
    added[:3, :3] += (H * 0.01) ** 2 * np.eye(3)
    seen = np.hstack([np.vstack([-hat(UP), -hat(NORTH)]), np.zeros((6, 3))])
    noise = np.diag([0.25] * 3 + [4e-4] * 3)
    before = solve_discrete_are(a.T, seen.T, added, noise)
    after = before - before @ seen.T @ np.linalg.solve(seen @ before @ seen.T + noise, seen @ before)
    np.testing.assert_allclose(found.filtered[-1], after[:3, :3], rtol=1e-5)


def test_what_is_left_is_known_where_nothing_is_read():
    """The gyro alone: the variance grows by (hσ)² a sample from the first, and no reading after helps."""
    t_ns = stamps(200)
    found = cramer_rao_bound(t_ns, MOTION.at(t_ns).attitude_xyzw, NoisySensors(gyro_noise=0.1, initial=0.2))
    trace = np.trace(found.filtered, axis1=1, axis2=2)
    turns = norm(MOTION.at(t_ns[1:]).body_rate) * H
    assert trace[0] == pytest.approx(3 * 0.04)
    # J_r shortens what lies across the turn by 2 sin(θ/2)/θ
    steps = (0.1 * H) ** 2 * (1.0 + 2.0 * (2.0 * np.sin(turns / 2.0) / turns) ** 2)
    np.testing.assert_allclose(np.diff(trace), steps, rtol=1e-5)
    assert (np.trace(found.smoothed, axis1=1, axis2=2) <= trace * (1.0 + 1e-12)).all()


def test_what_no_reading_tells_is_named_and_no_angle_is_larger_than_that_of_a_guess():
    t_ns = stamps(100)
    q = MOTION.at(t_ns).attitude_xyzw
    up, north = VectorReadings(t_ns, UP, 0.3), VectorReadings(t_ns, NORTH, 0.03)

    def bound(*vectors: VectorReadings) -> CramerRaoBound:
        return cramer_rao_bound(t_ns, q, NoisySensors(gyro_noise=0.01, vectors=vectors))

    nothing = bound()
    assert nothing.rms(nothing.smoothed) == pytest.approx(np.sqrt(np.pi**2 / 3.0 + 2.0))
    assert numbers(bound(north).unobserved) == [-0.0558, -0.447, 0.893]
    assert len({found.unobserved for found in (nothing, bound(up), bound(north), bound(up, north))}) == 4
    assert bound(up, north).unobserved == ""


def test_readings_of_the_attitude_are_those_of_three_vectors():
    """Three vectors at right angles of noise σ tell as much as an attitude of variance σ²/2 on each axis."""
    t_ns = stamps(50)
    q = MOTION.at(t_ns).attitude_xyzw
    three = [VectorReadings(t_ns[::5], axis, 0.02) for axis in np.eye(3)]
    whole = AttitudeReadings(t_ns[::5], 0.5 * 0.02**2 * np.eye(3))
    one = cramer_rao_bound(t_ns, q, NoisySensors(gyro_noise=0.01, vectors=three))
    other = cramer_rao_bound(t_ns, q, NoisySensors(gyro_noise=0.01, attitudes=[whole]))
    np.testing.assert_allclose(other.smoothed, one.smoothed, rtol=0, atol=1e-12)
    assert other.unobserved == ""


@pytest.mark.parametrize("noise", [1e-3, 1e-5, 1e-7])
def test_a_tiny_noise_is_not_lost_in_rounding(noise):
    """Two vectors at right angles, of one sample: their information, whatever the deviation before."""
    q = np.array([[0.0, 0.0, 0.0, 1.0]])
    vectors = [VectorReadings(stamps(1), axis, noise) for axis in np.eye(3)[:2]]
    found = cramer_rao_bound(stamps(1), q, NoisySensors(gyro_noise=1.0, vectors=vectors))
    wanted = 1.0 / (np.pi**-2 + noise**-2 * np.array([1.0, 1.0, 2.0]))
    np.testing.assert_allclose(found.smoothed[0], np.diag(wanted), rtol=0, atol=5e-3 * noise**2)


@pytest.mark.slow
def test_the_dynamic_bound_is_that_of_all_unknowns_of_the_exact_motion():
    """By the normal equations of the start and the biases, with Euler's equations integrated by SciPy."""
    inertia, count = np.array([1.0, 2.0, 2.5]), 12
    t_ns, start = 8 * stamps(count), State([0.1, -0.3, 0.2, np.sqrt(0.86)], [0.3, 1.0, -0.4])
    gyro_noise, bias, iron = 0.02, BiasNoise(0.03, 0.004), BiasNoise(0.05)
    up, north = VectorReadings(t_ns, UP, 0.5), VectorReadings(t_ns[::3], NORTH, 0.03, iron)

    def equations(_, y):
        R, rate = y[:9].reshape(3, 3), y[9:]
        return np.append(R @ hat(rate), np.cross(inertia * rate, rate) / inertia)

    def of_start(x):
        first = Rotation.from_quat(start.attitude_xyzw) * Rotation.from_rotvec(x[:3])
        y = np.append(first.as_matrix(), start.body_rate + x[3:6])
        found = solve_ivp(equations, (0.0, t_ns[-1] / 1e9), y, "DOP853", t_ns / 1e9, rtol=1e-11, atol=1e-12).y.T
        return Rotation.from_matrix(found[:, :9].reshape(-1, 3, 3)), found[:, 9:]

    def residuals(x):
        R, rate = of_start(x)
        biases = x[9:].reshape(count, 3)
        rows = [
            x[:3] / np.pi,
            x[3:6] / 100.0,
            x[6:9] / iron.turn_on,
            (rate + biases) / gyro_noise,
            R.inv().apply(UP) / up.noise,
            (R[::3].inv().apply(NORTH) + x[6:9]) / north.noise,
            biases[0] / bias.turn_on,
            np.diff(biases, axis=0) / bias.step,
        ]
        return np.concatenate([row.ravel() for row in rows])

    def derivative(of):
        step = 1e-5 * np.eye(9 + 3 * count)
        return np.array([(of(e) - of(-e)) / 2e-5 for e in step]).T

    jacobian = derivative(residuals)
    true = of_start(np.zeros(6))[0]
    turns = derivative(lambda x: (true.inv() * of_start(x)[0]).as_rotvec().ravel())
    covariance = turns @ np.linalg.inv(jacobian.T @ jacobian) @ turns.T
    given = NoisySensors(gyro_noise, bias, [up, north])

    def motion(attitude_xyzw, body_rate):
        states = ClosedForm(RigidBody(inertia), State(attitude_xyzw, body_rate)).at(t_ns)
        return states.attitude_xyzw, states.body_rate

    later = [replace(each, stamps_ns=each.stamps_ns + 10**9) for each in (up, north)]
    found = dynamic_bound(
        t_ns + 10**9, motion, (start.attitude_xyzw, start.body_rate), replace(given, vectors=later), np.ones(count)
    )
    np.testing.assert_array_equal(found.joint_ns, t_ns + 10**9)
    np.testing.assert_allclose(found.joint, covariance, rtol=0, atol=1e-5 * np.abs(covariance).max())
    blocks = np.array([covariance[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] for k in range(count)])
    np.testing.assert_allclose(found.smoothed, blocks, rtol=0, atol=1e-5 * blocks.max())
    np.testing.assert_allclose(found.filtered[-1], blocks[-1], rtol=0, atol=1e-5 * blocks[-1].max())
    without = cramer_rao_bound(t_ns, true.as_quat(), given)
    assert (np.trace(found.smoothed, axis1=1, axis2=2) < np.trace(without.smoothed, axis1=1, axis2=2)).all()
