"""exp, log and the Jacobians of SO(3) against 50-digit arithmetic, from 1e-300 rad to π."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from mpmath import mp

from lie_rigid_body.lie import quaternion, series, so3
from lie_rigid_body.lie.vectors import norm

ANGLES = [
    *(float(a) for a in np.logspace(-300, -20, 15)),
    *(float(a) for a in np.logspace(-19, np.log10(3.1), 60)),
    *(series.SERIES_LIMIT * (1.0 + s) for s in (-1e-9, -1e-16, 0.0, 1e-15, 1e-9)),
    *(float(np.pi - d) for d in (1e-2, 1e-5, 1e-8, 1e-12, 4e-16, 0.0)),
]
AXES = [(1.0, 0.0, 0.0), (0.6, -0.8, 0.0), (0.36, 0.48, -0.8), (-1e-9, 1.0, 1e-5)]
FIFTEEN_DIGITS = 1e-15


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(50):
        yield


def vectors() -> np.ndarray:
    return np.array([np.array(axis) / np.linalg.norm(axis) * angle for angle in ANGLES for axis in AXES])


def wide_turns(count: int = 400) -> np.ndarray:
    """Rotation vectors of 2.5 rad to π in random directions, where the entries of the rotation are largest."""
    random = np.random.default_rng(20)
    axes = random.normal(size=(count, 3))
    angles = random.uniform(2.5, np.pi, (count, 1))
    worst_known = [2.0950553812118766, 2.0926827963576518, 0.23742678288911792]
    return np.array([worst_known, *(axes / np.linalg.norm(axes, axis=1, keepdims=True) * angles)])


def exact_hat(v) -> mpmath.matrix:
    x, y, z = (mp.mpf(float(c)) for c in v)
    return mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def exact_angle(v) -> mpmath.mpf:
    return mp.sqrt(sum(mp.mpf(float(c)) ** 2 for c in v))


def exact_function(v, linear, quadratic) -> mpmath.matrix:
    """I + linear(θ) [v] + quadratic(θ) [v]², each coefficient evaluated at far more digits than it cancels."""
    theta = exact_angle(v)
    with mp.workdps(60 + 3 * max(0, int(-mp.log10(theta)))):
        a, b = linear(theta), quadratic(theta)
    h = exact_hat(v)
    return mp.eye(3) + a * h + b * h * h


EXACT = {
    "exp": (lambda t: mp.sin(t) / t, lambda t: (1 - mp.cos(t)) / t**2),
    "left_jacobian": (lambda t: (1 - mp.cos(t)) / t**2, lambda t: (t - mp.sin(t)) / t**3),
    "right_jacobian": (lambda t: -(1 - mp.cos(t)) / t**2, lambda t: (t - mp.sin(t)) / t**3),
    "left_jacobian_inverse": (lambda t: -mp.mpf(1) / 2, lambda t: (1 - t / 2 * mp.cot(t / 2)) / t**2),
    "right_jacobian_inverse": (lambda t: mp.mpf(1) / 2, lambda t: (1 - t / 2 * mp.cot(t / 2)) / t**2),
}


@pytest.mark.parametrize("name", EXACT)
def test_matrix_functions_have_fifteen_digits(name):
    v = vectors()
    for vector, computed in zip(v, getattr(so3, name)(v), strict=True):
        exact = exact_function(vector, *EXACT[name])
        worst = max(abs(mp.mpf(float(computed[i, j])) - exact[i, j]) for i in range(3) for j in range(3))
        assert worst < FIFTEEN_DIGITS, vector


def test_exp_has_fifteen_digits_in_every_direction():
    v = wide_turns()
    for vector, computed in zip(v, so3.exp(v), strict=True):
        exact = exact_function(vector, *EXACT["exp"])
        worst = max(abs(mp.mpf(float(computed[i, j])) - exact[i, j]) for i in range(3) for j in range(3))
        assert worst < FIFTEEN_DIGITS, vector


@pytest.mark.parametrize("name", EXACT)
def test_off_diagonal_part_keeps_its_digits_at_tiny_angles(name):
    """Next to the identity the interesting part is tiny: it, too, must be right to 15 digits of itself."""
    v = vectors()[: 4 * 28]
    for vector, computed in zip(v, so3.vee(getattr(so3, name)(v)), strict=True):
        linear, _ = EXACT[name]
        theta = exact_angle(vector)
        with mp.workdps(60 + 3 * max(0, int(-mp.log10(theta)))):
            coefficient = linear(theta)
        for c, part in zip(computed, vector, strict=True):
            exact = coefficient * mp.mpf(float(part))
            assert abs(mp.mpf(float(c)) - exact) <= FIFTEEN_DIGITS * abs(coefficient) * theta


def test_quaternion_exponential():
    v = vectors()
    for vector, computed in zip(v, quaternion.exp(v), strict=True):
        theta = exact_angle(vector)
        exact = [mp.mpf(float(c)) / theta * mp.sin(theta / 2) for c in vector]
        for c, e in zip(computed[:3], exact, strict=True):
            assert abs(mp.mpf(float(c)) - e) <= FIFTEEN_DIGITS * mp.sin(theta / 2)
        assert abs(mp.mpf(float(computed[3])) - mp.cos(theta / 2)) < FIFTEEN_DIGITS


def test_quaternion_logarithm():
    v = vectors()
    for q, computed in zip(quaternion.exp(v), quaternion.log(quaternion.exp(v)), strict=True):
        exact = [mp.mpf(float(c)) for c in q]
        sine = mp.sqrt(sum(c * c for c in exact[:3]))
        angle = 2 * mp.atan2(sine, exact[3])
        if angle > mp.pi:
            angle -= 2 * mp.pi
        for c, e in zip(computed, exact[:3], strict=True):
            assert abs(mp.mpf(float(c)) - e / sine * angle) <= FIFTEEN_DIGITS * abs(angle)


def test_log_inverts_exp_on_both_representations():
    v = vectors()[: -4 * 2]  # short of π, where either axis is right
    angle = norm(v)[:, np.newaxis]
    assert np.all(np.abs(quaternion.log(quaternion.exp(v)) - v) <= 1e-15 * angle)
    assert np.all(np.abs(so3.log(so3.exp(v)) - v) <= 2e-15 * angle)


def test_log_at_half_turn_gives_the_axis_up_to_sign():
    for axis in AXES:
        unit = np.array(axis) / np.linalg.norm(axis)
        v = so3.log(so3.exp(np.pi * unit))
        assert np.linalg.norm(v) <= np.pi * (1 + 1e-15)
        assert abs(abs(v @ unit) - np.pi) < 1e-14


def test_zero_vector_gives_the_identity():
    zero = np.zeros(3)
    for function in (so3.exp, so3.left_jacobian, so3.right_jacobian_inverse):
        np.testing.assert_array_equal(function(zero), np.eye(3))
    np.testing.assert_array_equal(quaternion.exp(zero), [0, 0, 0, 1])
    np.testing.assert_array_equal(quaternion.log([0, 0, 0, 1.0]), zero)
