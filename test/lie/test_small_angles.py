"""Each function of an angle against mpmath, on both sides of where its formula changes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.lie import quaternion, series

SWITCHES = [0.5, series.SERIES_LIMIT]
BESIDE = [np.nextafter(switch, side * 9.0) for switch in SWITCHES for side in (0.0, 1.0)]
TINY = [*np.geomspace(1e-300, 1e-20, 9), *np.geomspace(3e-163, 3e-146, 9)]
ANGLES = np.array([*BESIDE, *SWITCHES, *TINY, *np.geomspace(1e-19, 0.3, 60), *np.linspace(0.3, 3.14, 60)])
ULP = 2.3e-16


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(60):
        yield


def series_of(coefficient, theta):
    """Σ coefficient(k) θ²ᵏ, for angles at which a formula would cancel."""
    return mp.nsum(lambda k: coefficient(int(k)) * mpf(theta) ** (2 * k), [0, 12])


def exactly(formula, coefficient):
    return lambda t: formula(mpf(t)) if t > 1e-3 else series_of(coefficient, t)


EXACT = {
    "half_angle_sine_ratio": exactly(
        lambda t: mp.sin(t / 2) / t, lambda k: (-mpf(1) / 4) ** k / (2 * mp.factorial(2 * k + 1))
    ),
    "sine_ratio": exactly(lambda t: mp.sin(t) / t, lambda k: mpf(-1) ** k / mp.factorial(2 * k + 1)),
    "dexp_linear": exactly(lambda t: (1 - mp.cos(t)) / t**2, lambda k: mpf(-1) ** k / mp.factorial(2 * k + 2)),
    "dexp_quadratic": exactly(lambda t: (t - mp.sin(t)) / t**3, lambda k: mpf(-1) ** k / mp.factorial(2 * k + 3)),
    "dexpinv_quadratic": exactly(
        lambda t: (1 - t / 2 * mp.cot(t / 2)) / t**2, lambda k: abs(mp.bernoulli(2 * k + 2)) / mp.factorial(2 * k + 2)
    ),
}
LIMITS = {
    "half_angle_sine_ratio": 0.5,
    "sine_ratio": 1.0,
    "dexp_linear": 0.5,
    "dexp_quadratic": 1.0 / 6.0,
    "dexpinv_quadratic": 1.0 / 12.0,
}


def relative(value: float, exact) -> float:
    return float(abs(mpf(float(value)) / exact - 1))


@pytest.mark.parametrize("name", EXACT)
def test_coefficients_are_right_to_round_off(name: str):
    values = getattr(series, name)(ANGLES)
    assert max(relative(v, EXACT[name](t)) for v, t in zip(values, ANGLES.tolist(), strict=True)) < 4 * ULP
    assert getattr(series, name)(np.zeros(1))[0] == pytest.approx(LIMITS[name], rel=1e-15)


SINES = [0.0, 1e-320, 1e-300, 1e-160, 1e-17, 1e-8, 1e-3]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("small", SINES)
def test_the_logarithm_is_right_beside_no_turn_and_beside_half_a_turn(small: float, sign: float):
    """Of q and −q alike; at half a turn its axis changes to the opposite."""
    large = math.sqrt(1.0 - small * small)
    [x, _, _] = quaternion.log([sign * small, 0.0, 0.0, large])
    assert x == pytest.approx(sign * float(2 * mp.asin(mpf(small))), rel=2 * ULP, abs=1e-323)
    np.testing.assert_array_equal(quaternion.log([-sign * small, 0.0, 0.0, -large]), [x, 0.0, 0.0])
    [x, _, _] = quaternion.log([large, 0.0, 0.0, sign * small])
    assert x == pytest.approx(sign * float(mp.pi - 2 * mp.asin(mpf(small))), rel=2 * ULP)
