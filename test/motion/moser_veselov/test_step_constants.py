"""The constants of a Moser–Veselov step, by Newton's method and series, against Jacobi's functions of many digits."""

from __future__ import annotations

import numpy as np
import pytest
from exact_steps import dimensionless, exact_series, exact_step
from mpmath import mp, mpf

from lie_rigid_body import RigidBody, State
from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.motion.moser_veselov import MAX_TURN, MoserVeselovIntegrator
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, DimensionlessMotion
from lie_rigid_body.motion.moser_veselov.records import StepperConstants
from lie_rigid_body.motion.moser_veselov.step import step_of_length

MOTIONS = {
    "about the smallest": ([0.6, 0.8, 1.0], [3.0, 0.5, -0.9]),
    "about the largest": ([0.6, 0.8, 1.0], [0.3, 0.5, 1.1]),
    "flat": ([1.0, 2.0, 3.0], [1.1, -0.5, 0.2]),
    "beside the separatrix": ([1.0, 2.0, 3.0], [1e-9, 1.0, 2e-9]),
    "nearly symmetric": ([1.0, 1.0 + 1e-12, 1.7], [0.5, 0.7, 1.1]),
    "beside a sphere": ([1.0, 1.0 + 1e-15, 1.0 + 3e-15], [0.5, 0.7, 1.1]),
    "products": ([1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [0.4, -1.2, 0.7]),
    "beside an axis": ([0.6, 0.8, 1.0], [1e-100, 2e-100, 1.0]),
}
STEPS = [MAX_TURN, 0.1, 1e-2, 1e-4, 1e-8, 1e-20, 1e-100]
"""rad at the largest rate; below 1e-4 or so the first guess is the root, and Newton's method ends at once."""


def momentum_step(x: float, constants: StepperConstants) -> list[mpf]:
    step = step_of_length((x, 0.0), constants)
    return [mpf(hi) + mpf(lo) for hi, lo in (*step.changes, *step.factors, step.curvature)]


def exact_constants(motion: DimensionlessMotion, x: float) -> list[mpf]:
    """The same seven by S = sn(λx)/λ with λ² the larger of P and Q, and m the ratio of the smaller to it."""
    e1, e2, e3 = (mpf(str(e)) for e in motion.inverse_moments)
    m1, m3 = mpf(str(motion.m1)), mpf(str(motion.m3))
    # e₁ − 2H and 2H − e₃, where nothing cancels
    p, q = (e2 - e3) * (e1 - e3) * m3, (e1 - e2) * (e1 - e3) * m1
    larger, smaller = max(p, q), min(p, q)
    if larger == 0:
        s, one, other = mpf(x), mpf(1), mpf(1)
    else:
        u, m = mp.sqrt(larger) * x, smaller / larger
        s = mp.ellipfun("sn", u, m=m) / mp.sqrt(larger)
        one, other = mp.ellipfun("dn", u, m=m), mp.ellipfun("cn", u, m=m)
    chi, delta = (one, other) if q >= p else (other, one)
    sums = [s * delta * (e3 - e2), s * (e1 - e3), s * chi * (e2 - e1)]
    return [chi - 1, chi * delta - 1, delta - 1, *sums, s**2 * (e3 - e2) * (e2 - e1)]


@pytest.mark.parametrize("turn", STEPS)
@pytest.mark.parametrize("name", MOTIONS)
def test_the_step_of_the_momentum_is_the_exact_one(name: str, turn: float):
    """An error is the same in each of 1e8 steps, and adds up: only what the series has beyond x² is in doubles."""
    inertia, rate = MOTIONS[name]
    body, start = RigidBody(inertia), State([0, 0, 0, 1], rate)
    constants = MoserVeselovIntegrator(body, start, 20).constants
    with working_precision(DIGITS):
        motion = dimensionless(body, start)
    with mp.workdps(60 if turn > 1e-30 else 260):
        exact = exact_constants(motion, turn)
        found = momentum_step(turn, constants)
        relative = mpf("1e-17") * mpf(turn) ** 4 + mpf("1e-30")
        for value, truth in zip(found[3:], exact[3:], strict=True):
            assert abs(value - truth) <= relative * abs(truth) + mpf("1e-31") * turn
        for value, truth in zip(found[:3], exact[:3], strict=True):
            assert abs(value - truth) <= relative * abs(truth) + mpf("1e-31")


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e-6])
def test_a_step_of_the_momentum_is_that_of_eulers_equations(scale: float):
    """The addition theorems against Taylor series of Euler's equations, at the largest step and at shorter ones."""
    for inertia, rate in MOTIONS.values():
        body, start = RigidBody(inertia), State([0, 0, 0, 1], rate)
        constants = MoserVeselovIntegrator(body, start, 20).constants
        with working_precision(DIGITS), mp.workdps(50):
            motion = dimensionless(body, start)
            x = MAX_TURN * scale
            c1, c2, c3, a1, a2, a3, k = momentum_step(x, constants)
            n1, n2, n3 = (mpf(str(v)) for v in motion.momentum)
            below = 1 - k * n2 * n2
            after = [
                ((1 + c1) * n1 + a1 * n2 * n3) / below,
                ((1 + c2) * n2 + a2 * n3 * n1) / below,
                ((1 + c3) * n3 + a3 * n1 * n2) / below,
            ]
            exact, _ = exact_step(exact_series(motion), mpf(x))
            for value, truth in zip(after, exact, strict=True):
                assert abs(value - truth) < 1e-17 * x**5 + 1e-31


def test_no_step_is_no_step():
    start = State([0, 0, 0, 1], [3.0, 0.5, -0.9])
    constants = MoserVeselovIntegrator(RigidBody([0.6, 0.8, 1.0]), start, 20).constants
    step = step_of_length((1e-300, 0.0), constants)
    tiny = np.array([*step.changes, *step.factors, step.curvature, *step.half_inertia])
    assert np.isfinite(tiny).all()
    assert np.abs(tiny).max() < 1e-299
