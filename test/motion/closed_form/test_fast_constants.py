"""Constants in double-double against mpmath, on both sides of every switch, and the same bits alone and together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from closed_form_far_reference import course_of, far_reference, far_time
from closed_form_reference import attitude_error, rate_error
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.inertia import principal_decomposition
from lie_rigid_body.motion.closed_form.attitude import GeneralMotion
from lie_rigid_body.motion.closed_form.decimal_constants import frame_and_polhode, general_motion
from lie_rigid_body.motion.closed_form.decimal_frames import digits_for, principal_axes
from lie_rigid_body.motion.closed_form.fast_constants import fast_motion_of_one
from lie_rigid_body.motion.closed_form.solution import evaluations
from lie_rigid_body.motion.motion import InitialConditions

ATTITUDE = [0.1, -0.7, 0.3, -0.5]
MIXED = 1.0 - 2.0**-20, 1.0 + 2.0**-20

# each operation is right to 2⁻¹⁰⁰; before l² − 2HJ₂ there are some eight, and it cancels by at most 2¹¹
RATE_BOUND = mpf(2) ** -86
# and of the decomposition the square of its 2⁻⁵⁰ is left, divided by differences of at least 2⁻¹⁰
COUPLED_BOUND = mpf(2) ** -84
# beyond the switch only the rounding to a pair is left
DECIMAL_BOUND = mpf(2) ** -104

MOMENTS = st.floats(0.1, 10.0)
RATES = st.floats(0.01, 100.0)
SIDES = st.sampled_from(MIXED)
SIGNS = st.tuples(*[st.sampled_from([1.0, -1.0])] * 3)
TURNS = st.tuples(*[st.floats(-2.0, 2.0)] * 3).filter(lambda v: min(map(abs, v)) > 0.01)
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


def fast(inertia, rate) -> GeneralMotion | None:
    moments, axes = principal_decomposition(np.array(inertia))
    return fast_motion_of_one(inertia, moments.tolist(), axes.tolist(), ATTITUDE, rate)


def in_decimals(inertia: list[list[float]], rate: list[float]) -> GeneralMotion:
    with working_precision(digits_for(inertia)):
        frame, polhode = frame_and_polhode(principal_axes(inertia), inertia, rate)
        return general_motion(frame, polhode, ATTITUDE)


def exact(pair) -> mpf:
    return mpf(float(pair[0])) + mpf(float(pair[1]))


def whole_turns_off(difference: mpf) -> mpf:
    return abs(difference - mp.nint(difference))


def assert_rates(motion: GeneralMotion, inertia, rate, bound: mpf) -> None:
    """Turns per nanosecond: of the body rate on its path, and half those of the mean turn about the momentum.

    Right to a share of the largest rate there is: that is what makes an angle wrong in the end.
    """
    with mp.workdps(60):
        course = course_of(np.array(inertia), rate)
        circulation = 1 / course.period / 10**9
        turn = course.growth / (2 * mp.pi) * circulation - motion.sense * circulation
        fastest = mp.sqrt(sum(mpf(w) ** 2 for w in rate)) / (2 * mp.pi) / 10**9
        fastest *= np.linalg.cond(inertia)
        assert whole_turns_off(exact(motion.phase_clock.rate) - circulation) <= bound * fastest
        assert whole_turns_off(exact(motion.half_turn_rate) - turn / 2) <= bound * fastest


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
        assert abs(exact(motion.phase_clock.start) - turns) <= mpf(2) ** -56


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(MOMENTS, MOMENTS, st.floats(1.01, 60.0), st.floats(2e-3, 0.999), RATES, RATES, NAMES, SIGNS)
def test_constants_of_regular_motions(j1, j3, fan, m1, w2, w3, names, signs):
    assume(abs(j3 - j1) > 1e-3 * j1)
    moments = moments_for(j1, j3, fan)
    inertia, rate = placed(moments, rates_for(moments, m1, w2, w3), names, signs)
    motion = fast(inertia, rate)
    assume(motion is not None)
    assert motion is not None
    assert_rates(motion, inertia, rate, RATE_BOUND)
    assert_begins_at_the_start(motion, inertia, rate)


def turned(moments, rates, turn) -> tuple[list[list[float]], list[float]]:
    """The body seen from axes turned by this quaternion."""
    matrix = so3.exp(np.array(turn))
    tensor = matrix @ np.diag(moments) @ matrix.T
    return (0.5 * (tensor + tensor.T)).tolist(), (matrix @ np.array(rates)).tolist()


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(MOMENTS, MOMENTS, st.floats(1.01, 60.0), st.floats(2e-3, 0.999), RATES, RATES, TURNS)
def test_constants_with_products_of_inertia(j1, j3, fan, m1, w2, w3, turn):
    assume(abs(j3 - j1) > 1e-3 * j1 and abs(m1 - 0.5) > 1e-9)
    moments = moments_for(j1, j3, fan)
    rates = rates_for(moments, m1, w2, w3)
    assume(rates[0] > 1e-4)
    inertia, rate = turned(moments, rates, turn)
    motion = fast(inertia, rate)
    assume(motion is not None)
    assert motion is not None
    assert_rates(motion, inertia, rate, COUPLED_BOUND)
    slow = in_decimals(inertia, rate)
    np.testing.assert_allclose(all_but_low_parts(motion), all_but_low_parts(slow), rtol=0.0, atol=4e-15)


@pytest.mark.parametrize("apart", [2.0**-10 * side for side in (1.0 - 1e-6, 1.0 + 1e-6)])
@pytest.mark.parametrize("close", [0, 2])
def test_moments_that_hardly_differ_with_products_of_inertia(apart: float, close: int):
    moments = [1.0 - apart, 1.0, 0.6] if close == 0 else [0.6 * 1.0, 0.6 + apart, 1.0]
    for rates in ([0.3, 0.5, 1.1], [1.1, 0.5, 0.3], [0.3, 1.1, 0.2]):
        inertia, rate = turned(moments, rates, [0.3, -0.5, 0.8])
        motion = fast(inertia, rate)
        assert (motion is None) == (apart < 2.0**-10)
        assert_rates(in_decimals(inertia, rate), inertia, rate, DECIMAL_BOUND)
        if motion is not None:
            assert_rates(motion, inertia, rate, COUPLED_BOUND)


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 400.0), st.sampled_from([2.5, 8.0, 30.0, 120.0, 400.0]), SIDES, st.floats(2e-3, 1.0), SIGNS)
def test_every_number_of_steps_is_enough_on_both_sides_of_its_switch(j3, ratio, side, m1, signs):
    fan = ratio * side * math.sqrt(m1)
    assume(fan > 1.001 and j3 > 1.001)
    for ends in ((1.0, j3), (j3, 1.0)):
        moments = moments_for(ends[0], ends[1], fan)
        inertia, rate = placed(moments, rates_for(moments, m1, 0.3, 1.0), (0, 1, 2), signs)
        motion = fast(inertia, rate)
        assert (motion is None) == (ratio * side > 400.0)
        if motion is not None:
            assert_rates(motion, inertia, rate, RATE_BOUND)
        assert_rates(in_decimals(inertia, rate), inertia, rate, DECIMAL_BOUND)


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(MOMENTS, MOMENTS, st.floats(1.1, 8.0), st.sampled_from([0.5, 2.0**-10]), SIDES, RATES, SIGNS)
def test_either_arithmetic_is_right_on_both_sides_of_each_parameter(j1, j3, fan, switch, side, w2, signs):
    assume(abs(j3 - j1) > 0.01 * j1)
    moments = moments_for(j1, j3, fan)
    inertia, rate = placed(moments, rates_for(moments, switch * side, w2, 1.0), (0, 1, 2), signs)
    motion, slow = fast(inertia, rate), in_decimals(inertia, rate)
    assert (motion is None) == (switch * side < 2.0**-10)
    assert_rates(slow, inertia, rate, DECIMAL_BOUND)
    assert_begins_at_the_start(slow, inertia, rate)
    if motion is not None:
        assert_rates(motion, inertia, rate, RATE_BOUND)
        assert_begins_at_the_start(motion, inertia, rate)
        assert type(motion.theta) is type(slow.theta)
        np.testing.assert_allclose(all_but_low_parts(motion), all_but_low_parts(slow), rtol=0.0, atol=2e-15)


def numbers(form: Any) -> Iterator[float]:
    """The numbers in a nest of tuples, in order."""
    if isinstance(form, float):
        yield form
        return
    for part in form:
        yield from numbers(part)


def all_but_low_parts(motion: GeneralMotion) -> list[float]:
    return [
        float(x) for x in [*numbers(motion.theta), *motion.direction_amplitudes, *motion.world_xyzw, *motion.frame_xyzw]
    ]


@pytest.mark.parametrize("size", [1e-20, 1e-5, 1e5, 1e20])
@pytest.mark.parametrize("side", MIXED)
def test_sizes_at_the_limits(size: float, side: float):
    inertia, rate = np.diag([1.0, 2.0, 3.0]).tolist(), [0.3, 0.5, 1.1]
    for scale, unit in ((size, 1.0), (1.0, size)):
        tensor, fastest = (scale * side * np.array(inertia)).tolist(), [unit * side * w for w in rate]
        motion = fast(tensor, fastest)
        if motion is not None:
            assert_rates(motion, tensor, fastest, RATE_BOUND)
        assert_rates(in_decimals(tensor, fastest), tensor, fastest, DECIMAL_BOUND)


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
def test_motions_that_are_not_regular_are_left_to_decimals(moments: list[float], rate: list[float]):
    assert fast(np.diag(moments).tolist(), rate) is None


def crowd(count: int) -> InitialConditions:
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
    axes = np.linalg.qr(random.normal(size=(count // 2, 3, 3)))[0]
    turned = axes @ inertia[::2] @ axes.swapaxes(1, 2)
    inertia[::2] = 0.5 * (turned + turned.swapaxes(1, 2))
    attitude /= np.linalg.norm(attitude, axis=1)[:, np.newaxis]
    return starts_of(inertia, attitude, rate)


def starts_of(inertia: np.ndarray, attitude: np.ndarray, rate: np.ndarray) -> InitialConditions:
    moments, axes = principal_decomposition(inertia)
    bodies = RigidBody.trusted(inertia, np.linalg.inv(inertia), axes, moments)
    return InitialConditions((len(inertia),), bodies, State.trusted(attitude, rate))


def test_constants_have_the_same_bits_alone_and_together():
    starts = crowd(240)
    together = np.full((240, 100), np.nan)
    for some in evaluations(starts):
        together[some.members, : len(some.table)] = some.table.T
    for i in range(240):
        inertia, states = starts.bodies.inertia[i : i + 1], starts.states[i : i + 1]
        (alone,) = evaluations(starts_of(inertia, states.attitude_xyzw, states.body_rate))
        np.testing.assert_array_equal(together[i, : len(alone.table)], alone.table[:, 0])


COMPLEMENTS = [0.9, 0.5 * MIXED[0], 0.5 * MIXED[1], 0.03, 2.0**-10 * MIXED[0], 2.0**-10 * MIXED[1]]
FANS = [1.0 + 1e-9, 2.2, 9.0]
ENDS = [(0.7, 1.0), (1.0, 0.7)]


@pytest.mark.parametrize(
    ("m1", "ends", "fan"),
    [(m1, ENDS[(i + j) % 2], fan) for i, m1 in enumerate(COMPLEMENTS) for j, fan in enumerate(FANS)],
)
def test_states_are_right_after_ten_thousand_million_radians(m1: float, ends: tuple[float, float], fan: float):
    moments = moments_for(ends[0], ends[1], fan)
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
