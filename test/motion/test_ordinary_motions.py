"""Constants in double-double against mpmath, on both sides of every switch, and the same bits alone and together."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from closed_form_far_reference import course_of, far_reference, far_time
from closed_form_reference import attitude_error, rate_error
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.motion.closed_form import pairs
from lie_rigid_body.motion.closed_form.arctangent import arctangent
from lie_rigid_body.motion.closed_form.columns import numbers
from lie_rigid_body.motion.closed_form.ensemble import Ensemble
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.ordinary import ordinary_one
from lie_rigid_body.motion.closed_form.pairs import Pair
from lie_rigid_body.motion.closed_form.polhode import frame_and_polhode
from lie_rigid_body.motion.closed_form.precision import working_precision
from lie_rigid_body.motion.closed_form.principal_axes import digits_for, principal_axes

ATTITUDE = [0.1, -0.7, 0.3, -0.5]
MIXED = 1.0 - 2.0**-20, 1.0 + 2.0**-20

# a hundred operations to 2⁻¹⁰⁰ each, one of which cancels by at most 2¹¹
RATE_BOUND = mpf(2) ** -82
# beyond the switch only the rounding to a pair is left
DECIMAL_BOUND = mpf(2) ** -104

MOMENTS = st.floats(0.1, 10.0)
RATES = st.floats(0.01, 100.0)
SIDES = st.sampled_from(MIXED)
SIGNS = st.tuples(*[st.sampled_from([1.0, -1.0])] * 3)
NAMES = st.permutations(range(3))


def moments_for(j1: float, j3: float, fan: float) -> tuple[float, float, float]:
    """Moments with 1 − ν = 1 + J₃(J₂ − J₁)/J₁(J₃ − J₂) about as given."""
    return j1, j1 * j3 * fan / (j3 + (fan - 1.0) * j1), j3


def rates_for(moments: tuple[float, float, float], m1: float, w2: float, w3: float) -> tuple[float, float, float]:
    """Rates with 1 − m about as given, or ω₁ = 0 if there are none; ω₃ about the axis that the momentum circles."""
    j1, j2, j3 = moments
    d21, d31, d32 = abs(j2 - j1), abs(j3 - j1), abs(j3 - j2)
    c1 = d21 * j2 * w2 * w2 + d31 * j3 * w3 * w3
    square = (d32 * j3 * w3 * w3 - m1 * d32 * c1 / d31) / (d21 * j1)
    return math.sqrt(max(square, 0.0)), w2, w3


def placed(moments, rates, names, signs) -> tuple[list[list[float]], list[float]]:
    """Any naming and sense of the body axes."""
    assume(rates[0] > 1e-4)
    diagonal, rate = [moments[i] for i in names], [signs[i] * rates[i] for i in names]
    return np.diag(diagonal).tolist(), rate


def in_decimals(inertia: list[list[float]], rate: list[float]) -> GeneralMotion:
    with working_precision(digits_for([entry for row in inertia for entry in row])):
        frame, polhode = frame_and_polhode(principal_axes(inertia), inertia, rate)
        return GeneralMotion.of(frame, polhode, ATTITUDE)


def exact(pair) -> mpf:
    return mpf(float(pair[0])) + mpf(float(pair[1]))


def whole_turns_off(difference: mpf) -> mpf:
    return abs(difference - mp.nint(difference))


def assert_rates(motion: GeneralMotion, inertia, rate, bound: mpf) -> None:
    """Turns per nanosecond: of the body rate on its path, and half those of the mean turn about the momentum."""
    with mp.workdps(60):
        course = course_of(np.array(inertia), rate)
        circulation = 1 / course.period / 10**9
        turn = course.growth / (2 * mp.pi) * circulation - motion.sense * circulation
        fastest = mp.sqrt(sum(mpf(w) ** 2 for w in rate)) / (2 * mp.pi) / 10**9
        fastest *= max(np.diagonal(inertia)) / min(np.diagonal(inertia))
        assert whole_turns_off(exact(motion.polhode_clock.rate) - circulation) <= bound * circulation
        assert whole_turns_off(exact(motion.half_turn_clock.rate) - turn / 2) <= bound * fastest


def assert_begins_at_the_start(motion: GeneralMotion, inertia, rate) -> None:
    """The phase of the start, by mpmath's integral of the first kind; the amplitudes, by their definition."""
    with mp.workdps(60):
        course = course_of(np.array(inertia), rate)
        frame = np.array(motion.axes)
        w = [mpf(float(x)) for x in frame.T @ np.array(rate)]
        j = [mpf(float(x)) for x in np.diag(frame.T @ np.array(inertia) @ frame)]
        c1 = abs(j[1] * (j[1] - j[0]) * w[1] ** 2 + j[2] * (j[2] - j[0]) * w[2] ** 2)
        c3 = abs(j[0] * (j[0] - j[2]) * w[0] ** 2 + j[1] * (j[1] - j[2]) * w[1] ** 2)
        squares = c3 / j[0] / abs(j[2] - j[0]), c3 / j[1] / abs(j[2] - j[1]), c1 / j[2] / abs(j[2] - j[0])
        for amplitude, square in zip(motion.rate_amplitudes, squares, strict=True):
            assert abs(abs(mpf(float(amplitude))) - mp.sqrt(square)) <= mpf(2) ** -52 * mp.sqrt(square)
        angle = mp.atan2(motion.sense * w[1] / mp.sqrt(squares[1]), w[0] / mp.sqrt(squares[0]))
        quarter = mp.pi / (2 * mp.agm(1, mp.sqrt(course.m1)))
        turns = mp.ellipf(angle, 1 - course.m1) / quarter / 4
        assert abs(exact(motion.polhode_clock.start) - turns) <= mpf(2) ** -56


@settings(max_examples=150, deadline=None)
@given(MOMENTS, MOMENTS, st.floats(1.01, 60.0), st.floats(2e-3, 0.999), RATES, RATES, NAMES, SIGNS)
def test_constants_of_ordinary_motions(j1, j3, fan, m1, w2, w3, names, signs):
    assume(abs(j3 - j1) > 1e-3 * j1)
    moments = moments_for(j1, j3, fan)
    inertia, rate = placed(moments, rates_for(moments, m1, w2, w3), names, signs)
    motion = ordinary_one(inertia, ATTITUDE, rate)
    assume(motion is not None)
    assert_rates(motion, inertia, rate, RATE_BOUND)
    assert_begins_at_the_start(motion, inertia, rate)


@settings(max_examples=120, deadline=None)
@given(st.floats(1.0, 400.0), st.sampled_from([2.5, 8.0, 30.0, 120.0, 400.0]), SIDES, st.floats(2e-3, 1.0), SIGNS)
def test_every_number_of_steps_is_enough_on_both_sides_of_its_switch(j3, ratio, side, m1, signs):
    fan = ratio * side * math.sqrt(m1)
    assume(fan > 1.001 and j3 > 1.001)
    for ends in ((1.0, j3), (j3, 1.0)):
        moments = moments_for(*ends, fan)
        inertia, rate = placed(moments, rates_for(moments, m1, 0.3, 1.0), (0, 1, 2), signs)
        motion = ordinary_one(inertia, ATTITUDE, rate)
        assert (motion is None) == (ratio * side > 400.0)
        if motion is not None:
            assert_rates(motion, inertia, rate, RATE_BOUND)
        assert_rates(in_decimals(inertia, rate), inertia, rate, DECIMAL_BOUND)


@settings(max_examples=90, deadline=None)
@given(MOMENTS, MOMENTS, st.floats(1.1, 8.0), st.sampled_from([0.5, 2.0**-10]), SIDES, RATES, SIGNS)
def test_either_arithmetic_is_right_on_both_sides_of_each_parameter(j1, j3, fan, switch, side, w2, signs):
    assume(abs(j3 - j1) > 0.01 * j1)
    moments = moments_for(j1, j3, fan)
    inertia, rate = placed(moments, rates_for(moments, switch * side, w2, 1.0), (0, 1, 2), signs)
    motion, slow = ordinary_one(inertia, ATTITUDE, rate), in_decimals(inertia, rate)
    assert (motion is None) == (switch * side < 2.0**-10)
    assert_rates(slow, inertia, rate, DECIMAL_BOUND)
    assert_begins_at_the_start(slow, inertia, rate)
    if motion is not None:
        assert_rates(motion, inertia, rate, RATE_BOUND)
        assert_begins_at_the_start(motion, inertia, rate)
        assert type(motion.wave) is type(slow.wave)
        np.testing.assert_allclose(all_but_low_parts(motion), all_but_low_parts(slow), rtol=0.0, atol=2e-15)


def all_but_low_parts(motion: GeneralMotion) -> list[float]:
    return [float(x) for x in [*numbers(motion.wave), *motion.direction_amplitudes, *motion.world, *motion.frame]]


@pytest.mark.parametrize("size", [1e-20, 1e-5, 1e5, 1e20])
@pytest.mark.parametrize("side", MIXED)
def test_sizes_at_the_limits(size: float, side: float):
    inertia, rate = np.diag([1.0, 2.0, 3.0]).tolist(), [0.3, 0.5, 1.1]
    for scale, unit in ((size, 1.0), (1.0, size)):
        tensor, fast = (scale * side * np.array(inertia)).tolist(), [unit * side * w for w in rate]
        motion = ordinary_one(tensor, ATTITUDE, fast)
        if motion is not None:
            assert_rates(motion, tensor, fast, RATE_BOUND)
        assert_rates(in_decimals(tensor, fast), tensor, fast, DECIMAL_BOUND)


EXTREME = [
    ([1.0, 2.0, 3.0], [1e-6, 1.0, 2e-7]),
    ([3.0, 4.0, 6.0], [2.0, 3.0, 1.0]),
    ([1.0, 2.0, 3.0], [1e-200, 1.0, 1e-200]),
    ([1.0, 2.0, 3.0], [1e200, 1e200, 3e200]),
    ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]),
    ([1.0, 1.0, 1.0], [0.3, 0.5, 1.0]),
    ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
    ([1e-5, 1.0, 1.0], [0.3, 0.5, 1.0]),
]


@pytest.mark.parametrize(("moments", "rate"), EXTREME)
def test_what_is_not_ordinary_is_left_to_decimals(moments: list[float], rate: list[float]):
    assert ordinary_one(np.diag(moments).tolist(), ATTITUDE, rate) is None


def crowd(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bodies of every kind, in random order."""
    random = np.random.default_rng(3)
    moments = random.uniform(0.1, 1.0, size=(count, 3))
    moments[::5, 1] = moments[::5, 0]
    moments[1::5] = [1.0, 2.0, 3.0]
    rate = random.normal(size=(count, 3)) * 10.0 ** random.uniform(-3.0, 3.0, size=(count, 1))
    rate[1::5, ::2] *= 0.1
    rate[2::7] *= random.choice([0.0, 1e-9, 1.0, -1.0], size=(len(rate[2::7]), 3))
    attitude = random.normal(size=(count, 4))
    inertia = np.array([np.diag(row) for row in moments])
    return inertia, attitude / np.linalg.norm(attitude, axis=1)[:, np.newaxis], rate


def test_constants_have_the_same_bits_alone_and_together():
    inertia, attitude, rate = crowd(700)
    together = np.full((700, 100), np.nan)
    for some in Ensemble.of(inertia, attitude, rate).evaluations:
        together[some.members, : len(some.table)] = some.table.T
    for i in range(700):
        (alone,) = Ensemble.of(inertia[i : i + 1], attitude[i : i + 1], rate[i : i + 1]).evaluations
        np.testing.assert_array_equal(together[i, : len(alone.table)], alone.table[:, 0])


@pytest.mark.parametrize("m1", [0.9, 0.5 * MIXED[0], 0.5 * MIXED[1], 0.03, 2.0**-10 * MIXED[0], 2.0**-10 * MIXED[1]])
@pytest.mark.parametrize("ends", [(0.7, 1.0), (1.0, 0.7)])
@pytest.mark.parametrize("fan", [1.0 + 1e-9, 2.2, 9.0])
def test_states_are_right_after_ten_thousand_million_radians(m1: float, ends: tuple[float, float], fan: float):
    moments = moments_for(*ends, fan)
    c1 = abs(ends[1] - ends[0]) * ends[1]
    w2 = 0.3 * math.sqrt(c1 / moments[1] / max(abs(moments[1] - ends[0]), 1e-3))
    rate = rates_for(moments, m1, w2, 1.0) if fan > 2.0 else (0.2, 0.7, 1.0)
    assert rate[0] > 0.01
    body, start = (
        RigidBody(list(moments)),
        State(np.array(ATTITUDE) / np.linalg.norm(ATTITUDE), 1000.0 * np.array(rate)),
    )
    t_ns = far_time(body.inertia, start.body_rate, 1e10, 2.5)
    truth = far_reference(body.inertia, start.attitude_xyzw, start.body_rate, t_ns)
    state = ClosedForm(body, start).at(t_ns)
    assert attitude_error(truth.attitude_xyzw, state.attitude_xyzw) < 2e-15
    assert rate_error(truth.body_rate, state.body_rate) < 1e-15


def fraction(pair: Pair) -> Fraction:
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


PARTS = st.floats(1e-12, 1e12)
LOWS = st.floats(-0.5, 0.5)


@settings(max_examples=200, deadline=None)
@given(PARTS, LOWS, PARTS, LOWS, st.booleans())
def test_arithmetic_of_pairs(a: float, rest: float, b: float, other: float, negative: bool):
    b = -b if negative else b
    x, y = (a, a * rest * 2.0**-53), (b, b * other * 2.0**-53)
    p, q, ulp = fraction(x), fraction(y), Fraction(2) ** -100
    for operation, truth, size in (
        (pairs.add, p + q, max(abs(p), abs(q)) * 2),
        (pairs.subtract, p - q, max(abs(p), abs(q)) * 2),
        (pairs.multiply, p * q, abs(p * q)),
        (pairs.divide, p / q, abs(p / q)),
    ):
        result = operation(x, y)
        assert abs(fraction(result) - truth) <= size * ulp
        assert_same_in_arrays(result, operation(in_array(x), in_array(y)))
    root = pairs.square_root(x)
    assert abs(fraction(root) ** 2 - p) <= 2 * p * ulp
    assert_same_in_arrays(root, pairs.square_root(in_array(x)))


def in_array(pair: Pair) -> Pair:
    return np.full(9, pair[0]), np.full(9, pair[1])


def assert_same_in_arrays(pair: Pair, many: Pair) -> None:
    for part, column in zip(pair, many, strict=True):
        np.testing.assert_array_equal(column, np.full(9, part))


def test_the_root_of_nothing_is_nothing():
    assert pairs.square_root((0.0, 0.0)) == (0.0, 0.0)


@settings(max_examples=100, deadline=None)
@given(st.floats(0.0, 1.0) | st.integers(0, 64).map(lambda k: k / 64.0), LOWS)
def test_arctangent_of_a_pair(x: float, rest: float):
    tangent = (x, x * rest * 2.0**-53)
    angle = arctangent(tangent)
    with mp.workdps(50):
        assert abs(exact(angle) - mp.atan(exact(tangent))) <= mpf(2) ** -66
    assert_same_in_arrays(angle, arctangent(in_array(tangent)))
