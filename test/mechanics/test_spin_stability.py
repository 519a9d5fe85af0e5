"""Stability of spins about the principal axes, against eigenvalues of the linearised Euler equations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.spin_stability import SpinStability

MOMENTS = [[1.0, 2.0, 3.0], [0.6, 0.8, 1.0], [7.872e-5, 3.3846e-4, 4.1526e-4], [1.0, 1.0, 1.8], [0.2, 1.0, 1.0]]


def eigenvalues(moments: list[float], axis: int, spin_rate: float) -> np.ndarray:
    """Of δ ↦ M⁻¹(Mδ × ω + Mω × δ)."""
    M, omega = np.diag(moments), spin_rate * np.eye(3)[axis]
    return np.linalg.eigvals(np.linalg.inv(M) @ (so3.hat(M @ omega) - so3.hat(omega) @ M))


@pytest.mark.parametrize("moments", [*MOMENTS, [2.0, 2.0, 2.0]])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("spin_rate", [1.0, 12.0])
def test_rates_are_the_eigenvalues(moments: list[float], axis: int, spin_rate: float):
    spin, values = SpinStability.of(moments, axis, spin_rate), eigenvalues(moments, axis, spin_rate)
    # a double eigenvalue 0 is found to the square root of round-off
    assert spin.growth_rate_1_s == pytest.approx(values.real.max(), rel=1e-12, abs=1e-7 * spin_rate)
    assert spin.wobble_rate_rad_s == pytest.approx(np.abs(values.imag).max(), rel=1e-12, abs=1e-7 * spin_rate)


@pytest.mark.parametrize("moments", MOMENTS[:3])
def test_the_intermediate_axis_alone_is_unstable(moments: list[float]):
    verdicts = [SpinStability.of(moments, i, 1.0).verdict for i in range(3)]
    assert verdicts == ["stable", "unstable", "stable"]
    small, middle, large = moments
    growth = 5.0 * math.sqrt((middle - small) * (large - middle) / (small * large))
    assert SpinStability.of(moments, 1, 5.0).growth_rate_1_s == pytest.approx(growth, rel=1e-13)


def test_equal_moments_are_neutral():
    assert [SpinStability.of([1.0, 1.0, 1.8], i, 1.0).verdict for i in range(3)] == ["neutral", "neutral", "stable"]
    assert [SpinStability.of([0.2, 1.0, 1.0], i, 1.0).verdict for i in range(3)] == ["stable", "neutral", "neutral"]
    assert [SpinStability.of([2.0, 2.0, 2.0], i, 1.0).verdict for i in range(3)] == ["neutral"] * 3


def test_a_stability_of_no_spin_has_no_rates():
    assert SpinStability.of([1.0, 2.0, 3.0], 1, 0.0) == SpinStability("unstable", 0.0, 0.0, 0.0)
