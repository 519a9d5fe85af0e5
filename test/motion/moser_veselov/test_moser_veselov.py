"""The Moser–Veselov stepper: what it keeps, for how long, and its parts against multiprecision."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.motion.moser_veselov import MAX_TURN
from lie_rigid_body.motion.moser_veselov.integrator import stepper_constants
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, CyclicFrame, DimensionlessMotion
from lie_rigid_body.motion.moser_veselov.records import PowerSeries
from lie_rigid_body.motion.motion import exact_inertia
from reference import attitude_error, rate_error, truth_cases

CASES = truth_cases()
BODY = RigidBody([0.6, 0.8, 1.0])
START = State([0, 0, 0, 1], [1.8 / 0.6, 0.4 / 0.8, -0.9])
STEP_NS = 10_000_000
SOME_STEPS = 30_000
"""As many as plain Python takes in half a second."""


def dimensionless(body: RigidBody, start: State) -> DimensionlessMotion:
    return DimensionlessMotion.of(CyclicFrame.of(exact_inertia(body)), start.body_rate.tolist())


def angles(found: State, exact: State) -> np.ndarray:
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    return vectors.norm(quaternion.log(turned))


def random_bodies(count: int) -> list[tuple[RigidBody, State]]:
    """Bodies with and without products of inertia, some flat, with moments and rates of many sizes."""
    rng = np.random.default_rng(11)
    found = []
    for k in range(count):
        a, b, c = 10.0 ** rng.uniform(-4, 0, 3) * [k % 4 > 0, 1, 1]
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        tensor = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
        body = RigidBody(0.5 * (tensor + tensor.T)) if k % 2 else RigidBody([b + c, a + c, a + b])
        attitude = rng.normal(size=4)
        rate = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 0, 3)
        found.append((body, State(attitude / np.linalg.norm(attitude), rate)))
    return found


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


@pytest.mark.parametrize("turn", [MAX_TURN, 0.01])
def test_every_body_and_motion_is_followed_to_round_off(turn):
    for body, start in random_bodies(24):
        with working_precision(DIGITS):
            fastest = float(dimensionless(body, start).fastest)
        times = (np.arange(1, 31) * 1e9 * turn / fastest).astype(np.int64)
        found, exact = MovingChart(body, start, max_step=turn / fastest).at(times), ClosedForm(body, start).at(times)
        assert angles(found, exact).max() < 3e-15
        assert np.abs(found.body_rate - exact.body_rate).max() < 3e-15 * fastest


@pytest.mark.parametrize("name", CASES)
def test_truth_is_kept_for_a_thousand_seconds(name):
    case = CASES[name]
    points = [p for p in case.points if p.t_ns <= 1_000_000_000_000]
    states = MovingChart(case.body, case.start, max_step=0.02).at([p.t_ns for p in points])
    for point, attitude, rate in zip(points, states.attitude_xyzw, states.body_rate, strict=True):
        assert attitude_error(attitude, point.attitude_xyzw) < 1e-14
        assert rate_error(rate, point.body_rate) < 1e-14


@pytest.mark.parametrize("method", ["dmv2", "dmv4", "dmv10"])
def test_low_orders_keep_the_invariants_as_well(method):
    times = np.arange(1, 200) * 25_000_000
    states = MovingChart(BODY, START, method=method, max_step=0.05).at(times)
    require_invariants(states)


@pytest.mark.parametrize(
    ("moments", "rate"),
    [
        ([2.0, 2.0, 2.0], [0.3, 0.5, 1.1]),
        ([1.0, 1.0, 2.0], [0.3, 0.5, 1.1]),
        ([2.0, 1.0, 2.0], [0.3, 0.5, 1.1]),
        ([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]),
        ([1.0, 2.0, 3.0], [1e-12, 1.0, 0.0]),
        ([3.0, 1.0, 2.0], [0.0, 0.0, 1.0]),
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


def test_motion_runs_backwards_from_its_end():
    """Time reversed: the rate's sign, and nothing else, changed."""
    time = SOME_STEPS // 10 * STEP_NS
    for body, start in random_bodies(6):
        end = MovingChart(body, start, max_step=0.02).at(time)
        back = MovingChart(body, State(end.attitude_xyzw, -end.body_rate), max_step=0.02).at(time)
        # the end is rounded to doubles, and 30 s carry that rounding back
        assert angles(back, start) < 1e-13
        np.testing.assert_allclose(-back.body_rate, start.body_rate, rtol=0, atol=1e-13)


def test_two_stretches_are_one_and_steps_of_any_length_agree():
    """The group property of a flow."""
    whole = MovingChart(BODY, START, max_step=0.01).at(20_000_000_000)
    half = MovingChart(BODY, START, max_step=0.01).at(10_000_000_000)
    again = MovingChart(BODY, half, max_step=0.07).at(10_000_000_000)
    uneven = MovingChart(BODY, START, max_step=0.05).at([1, 12_345, 777_777_777, 3_141_592_653, 20_000_000_000])[-1]
    assert angles(again, whole) < 1e-14
    assert angles(uneven, whole) < 1e-15


def exact_series(motion: DimensionlessMotion, momentum: list) -> tuple[list, list]:
    """Taylor coefficients of the momentum and the quaternion, by Euler's equations in the frame's units."""
    e = [mpf(str(v)) for v in motion.inverse_moments]
    m, q = [[v] for v in momentum], [[mpf(0)], [mpf(0)], [mpf(0)], [mpf(1)]]
    for n in range(60):
        # from the last to the first, so that a Cauchy product is a dot product
        w = [[e[j] * v for v in reversed(m[j])] for j in range(3)]
        torque = [mp.fdot(m[j - 2], w[j - 1]) - mp.fdot(m[j - 1], w[j - 2]) for j in range(3)]
        a, b, c, d = q
        turn = [
            mp.fdot(d, w[0]) + mp.fdot(b, w[2]) - mp.fdot(c, w[1]),
            mp.fdot(d, w[1]) + mp.fdot(c, w[0]) - mp.fdot(a, w[2]),
            mp.fdot(d, w[2]) + mp.fdot(a, w[1]) - mp.fdot(b, w[0]),
            -mp.fdot(a, w[0]) - mp.fdot(b, w[1]) - mp.fdot(c, w[2]),
        ]
        for j in range(3):
            m[j].append(torque[j] / (n + 1))
        for j in range(4):
            q[j].append(turn[j] / (2 * (n + 1)))
    return m, q


def exact_step(series: tuple[list, list], x: mpf) -> tuple[list, list]:
    """Momentum and quaternion after a time."""
    powers = [x**n for n in range(61)]
    m, q = ([mp.fdot(v, powers) for v in part] for part in series)
    return m, q


@pytest.mark.long
@pytest.mark.parametrize("terms", [1, 3, 10])
def test_preprocessed_inertia_makes_the_algorithm_exact(terms):
    """ρ₀ρⱼ = (α + βeⱼ) m̄ⱼ at every phase, but for a remainder of the next order in the step."""
    with mp.workdps(50), working_precision(DIGITS):
        for body, start in random_bodies(2):
            motion = dimensionless(body, start)
            alpha, beta = preprocessed_inertia(Invariants.of(motion), terms)
            momentum = [mpf(str(v)) for v in motion.momentum]
            series, remainders = exact_series(motion, momentum), []
            for x in (mpf(1) / 8, mpf(1) / 16):
                after, q = exact_step(series, x)
                b = sum(mpf(str(c)) * x ** (2 * k + 1) for k, c in enumerate(beta))
                a = sum(mpf(str(c)) * x ** (2 * k + 3) for k, c in enumerate(alpha))
                rest = [
                    q[3] * q[j] - (a + b * mpf(str(motion.inverse_moments[j]))) * (momentum[j] + after[j]) / 2
                    for j in range(3)
                ]
                remainders.append(mp.norm(rest))
            order = mp.log(remainders[0] / remainders[1], 2)
            assert abs(order - (2 * terms + 1)) < 0.3


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
        motion = dimensionless(RigidBody(moments), State([0, 0, 0, 1], rate))
        constants = stepper_constants(motion, 20, motion.momentum)
        alpha, beta = coefficients(constants.alpha), coefficients(constants.beta)
        momentum = [mpf(str(v)) for v in motion.momentum]
        exact, e = exact_series(motion, momentum), [mpf(str(v)) for v in motion.inverse_moments]
        for x, bound in (mpf(0.25), 2e-20), (mpf(0.03), 1e-23):
            a = sum(c * x ** (2 * k + 3) for k, c in enumerate(alpha))
            b = sum(c * x ** (2 * k + 1) for k, c in enumerate(beta))
            after, q = exact_step(exact, x)
            rest = [q[3] * q[j] - (a + b * e[j]) * (momentum[j] + after[j]) / 2 for j in range(3)]
            assert mp.norm(rest) < bound * x / 2
