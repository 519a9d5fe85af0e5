"""The theta functions' cubics against series of many digits, up to the largest nome and argument they serve for."""

from __future__ import annotations

import math

import pytest
from mpmath import mp, mpf

from lie_rigid_body.motion.closed_form import jacobi

NOMES = [math.exp(-math.pi), 1e-2, 1e-6, 1e-20, 1e-60]
REAL = [1e-9, 0.1, math.pi / 4.0, 1.2, math.pi / 2.0]
"""ζ; the largest of iχ is that of 2q cosh 2χ = 1 + q²."""


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(50):
        yield


def quotient(kind: int, zeta, q: float):
    """θ by the factor that its cubic leaves out."""
    factor = {1: 2 * mpf(q) ** 0.25 * mp.sin(zeta), 2: 2 * mpf(q) ** 0.25 * mp.cos(zeta), 3: 1, 4: 1}[kind]
    return mp.jtheta(kind, zeta, mpf(q)) / factor


def require(q: float, zeta, z) -> None:
    for kind in (1, 2, 3, 4):
        exact = quotient(kind, zeta, q)
        found = mpf(jacobi.value(jacobi.theta_cubics(q)[kind - 1], float(z)))
        # θ₄ vanishes at the pole of the elliptic functions, at twice the largest χ; the other three keep their size
        assert abs((found - exact).real) < 6e-16, (kind, zeta)


@pytest.mark.parametrize("q", NOMES)
@pytest.mark.parametrize("zeta", REAL)
def test_cubics_are_theta_functions_of_real_arguments(q: float, zeta: float):
    shift = mpf("1e-30") if zeta == math.pi / 2.0 else 0  # cos ζ is in the denominator
    require(q, mpf(zeta) + shift, 2 * mpf(q) * mp.cos(2 * mpf(zeta)))


@pytest.mark.parametrize("q", NOMES)
@pytest.mark.parametrize("share", [1e-9, 0.1, 0.5, 0.9, 1.0])
def test_cubics_are_theta_functions_of_imaginary_arguments(q: float, share: float):
    chi = share * mp.acosh((1 + mpf(q) ** 2) / (2 * mpf(q))) / 2
    require(q, mp.mpc(0, chi), 2 * mpf(q) * mp.cosh(2 * chi))
