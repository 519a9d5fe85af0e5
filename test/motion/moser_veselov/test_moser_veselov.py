"""The Moser–Veselov stepper: what it keeps, for how long, and its parts against multiprecision."""

from __future__ import annotations

import numpy as np
import pytest
from exact_steps import dimensionless, exact_series, off_the_step
from mpmath import mp, mpf
from regimes import motion

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.motion.moser_veselov.integrator import stepper_constants
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS
from lie_rigid_body.motion.moser_veselov.records import PowerSeries

BODY = RigidBody([0.6, 0.8, 1.0])
START = State([0, 0, 0, 1], [1.8 / 0.6, 0.4 / 0.8, -0.9])
STEP_NS = 10_000_000
SOME_STEPS = 30_000
"""As many as plain Python takes in half a second."""


def angles(found: State, exact: State) -> np.ndarray:
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    return vectors.norm(quaternion.log(turned))


def run(steps: int, samples: int) -> tuple[State, State]:
    """States after numbers of steps spread evenly in their logarithm, and the true ones."""
    times = STEP_NS * np.unique(np.geomspace(steps / 1e4, steps, samples).astype(np.int64))
    return MovingChart(BODY, START, max_step=1e-9 * STEP_NS).at(times), ClosedForm(BODY, START).at(times)


def require_invariants(states: State) -> None:
    energy, momentum = BODY.kinetic_energy(START), BODY.angular_momentum(START)
    assert np.abs(BODY.kinetic_energy(states) / energy - 1.0).max() <= 5e-16
    assert vectors.norm(BODY.angular_momentum(states) - momentum).max() <= 1.5e-15


def test_energy_momentum_and_attitude_stay_true():
    steps = 1_000_000 if MovingChart(BODY, START).compile() else SOME_STEPS
    found, exact = run(steps, 100)
    require_invariants(found)
    assert angles(found, exact).max() < 5e-15
    assert np.abs(found.body_rate - exact.body_rate).max() < 1e-14


@pytest.mark.slow
def test_a_hundred_million_steps_stay_true():
    """How the errors grow is in `test_drift`: here they hardly show above the rounding of a quaternion to doubles."""
    if not MovingChart(BODY, START).compile():
        pytest.skip("10⁸ steps need numba")
    found, exact = run(100_000_000, 400)
    require_invariants(found)
    assert angles(found, exact).max() < 1e-13


@pytest.mark.parametrize("method", ["dmv2", "dmv4", "dmv10"])
def test_low_orders_keep_the_invariants_as_well(method):
    times = np.arange(1, 200) * 25_000_000
    states = MovingChart(BODY, START, method=method, max_step=0.05).at(times)
    require_invariants(states)


@pytest.mark.parametrize(
    ("moments", "rate"),
    [
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
        ([1e-300, 2e-300, 3e-300], [0.1, 0.2, 0.3]),
        ([1e300, 2e300, 2.5e300], [0.1, 0.2, 0.3]),
        ([1.0, 1.0, 2e-14], [0.3, 0.5, 1.1]),
        ([1.0, 2.0, 3.0], [1e-150, 2e-150, 3e-150]),
    ],
)
def test_special_motions_and_scales(moments, rate):
    body, start = RigidBody(moments), State([0.5, -0.5, 0.5, 0.5], rate)
    times = 7 + 100_000_000 * np.arange(20)
    found, exact = MovingChart(body, start, max_step=0.01).at(times), ClosedForm(body, start).at(times)
    assert angles(found, exact).max() < 2e-15
    assert np.abs(found.body_rate - exact.body_rate).max() <= 1e-15 * np.abs(exact.body_rate).max()


@pytest.mark.long
@pytest.mark.parametrize("terms", [1, 3, 10])
def test_preprocessed_inertia_makes_the_algorithm_exact(terms):
    """ρ₀ρⱼ = (α + βeⱼ) m̄ⱼ at every phase, but for a remainder of the next order in the step."""
    with mp.workdps(50), working_precision(DIGITS):
        for regime in ("flat", "tensor"):
            drawn = motion(regime, 11)
            found = dimensionless(drawn.body, drawn.start)
            alpha, beta = preprocessed_inertia(Invariants.of(found), terms)
            series = exact_series(found)
            long, short = (off_the_step(found, alpha, beta, series, mpf(1) / n) for n in (8, 16))
            assert abs(mp.log(long / short, 2) - (2 * terms + 1)) < 0.3


AWKWARD = {
    "flat": ([1.0, 2.0, 3.0], [0.3, 0.5, 1.1]),
    "nearly flat": ([1.0, 2.0, 3.0 * (1.0 - 1e-15)], [0.3, -0.5, 1.1]),
    "oblate": ([1.0, 1.0, 2.0], [0.3, 0.5, 1.1]),
    "prolate": ([2.0, 2.0, 1.0], [0.3, 0.5, 1.1]),
    "nearly symmetric": ([1.0, 1.0 + 1e-15, 1.7], [0.3, 0.5, 1.1]),
    "sphere": ([2.0, 2.0, 2.0], [0.3, 0.5, 1.1]),
    "nearly a sphere": ([1.0, 1.0 + 1e-12, 1.0 + 3e-12], [0.3, 0.5, 1.1]),
    "needle": ([1.0, 1.0, 2e-14], [0.3, 0.5, 1.1]),
    "needle across": ([1.0, 1.0 + 1e-8, 2e-8], [0.3, 0.5, 0.0]),
    "needle along": ([1.0, 1.0 + 1e-8, 2e-8], [0.0, 1e-9, 1.0]),
    "on the separatrix": ([3.0, 4.0, 6.0], [-2.0, 3.0, 1.0]),
    "near the separatrix": ([1.0, 2.0, 3.0], [1e-12, 1.0, 1e-13]),
    "about the intermediate axis": ([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]),
    "m3 = 0": ([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]),
    "m1 = 0": ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]),
    "m3 tiny": ([1.0, 2.0, 3.0], [1.0, 1e-9, 1e-150]),
}


def coefficients(series: PowerSeries) -> list[mpf]:
    first, second = (mpf(hi) + mpf(lo) for hi, lo in series[:2])
    return [first, second, *map(mpf, reversed(series.later))]


@pytest.mark.parametrize("case", AWKWARD)
def test_the_series_give_the_exact_step(case: str):
    """ρ₀ρⱼ against a Taylor series of the motion, relative to the half turn ½x.

    An error of the series repeats at every step: 1e8 of the longest amount to less than 2e-13 rad.
    """
    moments, rate = AWKWARD[case]
    with mp.workdps(60), working_precision(DIGITS):
        found = dimensionless(RigidBody(moments), State([0, 0, 0, 1], rate))
        constants = stepper_constants(found, 20, found.momentum)
        alpha, beta = coefficients(constants.alpha), coefficients(constants.beta)
        series = exact_series(found)
        for x, bound in (mpf(0.25), 2e-20), (mpf(0.03), 1e-23):
            assert off_the_step(found, alpha, beta, series, x) < bound * x / 2
