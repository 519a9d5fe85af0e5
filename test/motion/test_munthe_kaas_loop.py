"""The small-angle branches of the written-out chart against multiprecision, on both sides of their switches."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.motion import munthe_kaas_loop as kernels

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
