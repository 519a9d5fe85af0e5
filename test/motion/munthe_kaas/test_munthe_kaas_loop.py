"""The small-angle branches of the written-out chart against multiprecision, on both sides of their switches."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.lie import so3
from lie_rigid_body.motion.munthe_kaas import loop as kernels

SWITCHES = (kernels.SHORT_SQUARED, kernels.LONG_SQUARED)
SQUARES = [
    *(s for switch in SWITCHES for s in (np.nextafter(switch, 0.0), switch, np.nextafter(switch, 9.0))),
    *np.geomspace(1e-18, 9.0, 40),
]


@pytest.mark.parametrize("s", SQUARES)
def test_coefficients_are_right_to_round_off(s):
    with mp.workdps(60):
        theta = mp.sqrt(mpf(float(s)))
        quadratic = (1 - theta / 2 * mp.cot(theta / 2)) / theta**2
        assert abs(kernels.dexpinv_quadratic(float(s)) / quadratic - 1) < 2e-15
        ratio, cosine = kernels.half_angle(float(s))
        assert abs(ratio / (mp.sin(theta / 2) / theta) - 1) < 4e-16
        assert abs(cosine - mp.cos(theta / 2)) < 4e-16


def test_limits_at_zero():
    assert kernels.dexpinv_quadratic(0.0) == pytest.approx(1.0 / 12.0, rel=1e-15)
    assert kernels.half_angle(0.0) == (0.5, 1.0)


@pytest.mark.parametrize("off", [1e-16, -1e-16, 3e-9, -3e-9, 2e-8, -2e-8])
def test_a_newton_step_brings_the_attitude_to_unit_norm(off: float):
    """One is enough within 1e-8 of it, and leaves ³⁄₂ of the square of the distance."""
    q = kernels.recentred((0.6 * (1.0 + off), 0.0, 0.0, 0.8 * (1.0 + off)), (0.0, 0.0, 0.0))
    with mp.workdps(60):
        assert abs(mp.sqrt(sum(mpf(c) ** 2 for c in q)) - 1) < 3e-16 + 1.6 * off * off


def test_the_chart_s_rate_agrees_with_the_matrices_of_the_rotation_vector():
    """Of a body of unit inertia, whose rate is its momentum: the chart's rate is J_r(β)⁻¹ω."""
    random = np.random.default_rng(5)
    unit = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    for angle in np.geomspace(1e-12, 3.0, 60):
        axis, rate = random.normal(size=3), random.normal(size=3)
        beta = axis / np.linalg.norm(axis) * angle
        (x, y, z), (px, py, pz) = beta.tolist(), rate.tolist()
        found = kernels.chart_field(x, y, z, px, py, pz, unit)
        np.testing.assert_allclose(found[:3], so3.right_jacobian_inverse(beta) @ rate, rtol=0, atol=4e-15)
        np.testing.assert_array_equal(found[3:], [0.0, 0.0, 0.0])
