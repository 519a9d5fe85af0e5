"""How spans are divided into steps, beside whole multiples of the largest step."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body import MovingChart, RigidBody, State
from lie_rigid_body.groups import SO, GroupMovingChart, GroupState, Lagrangian, mass_matrix
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.time_steps import steps_between, steps_to

SLACK = Fraction(1, 10**9)


@given(st.lists(st.integers(0, 10**12), max_size=8), st.floats(1e-6, 1e6))
def test_steps_are_as_few_as_their_largest_length_allows(gaps: list[int], max_step: float):
    times = np.cumsum(np.array(gaps, dtype=np.int64))
    spans, counts = steps_to(times, 0, max_step)
    assert spans.tolist() == gaps
    for span, count in zip(gaps, counts.tolist(), strict=True):
        wanted = Fraction(span, 10**9) / Fraction(max_step)
        assert count >= wanted * (1 - Fraction(1, 10**14)) - SLACK
        assert count < wanted + 1 or count == 0 == span
        assert (count == 0) == (span == 0)


@pytest.mark.parametrize("step_ns", [1, 3, 7, 1000, 10_000_000, 33_333_333, 10**9])
@pytest.mark.parametrize("number", [1, 2, 3, 49, 1000, 123_456, 99_999_999])
def test_a_span_of_whole_steps_has_as_many(step_ns: int, number: int):
    """Whatever rounding the largest step has suffered, and not one more; a nanosecond longer takes one more."""
    for max_step in (step_ns / 1e9, step_ns * 1e-9):
        _, counts = steps_to(np.array([number * step_ns]), 0, max_step)
        assert counts.tolist() == [number]
        if step_ns * number < 10**8:
            _, counts = steps_to(np.array([number * step_ns + 1]), 0, max_step)
            assert counts.tolist() == [number + 1]


@given(st.integers(1, 10**15), st.floats(1e-9, 1e6))
def test_one_period_is_divided_as_a_row_of_them(span_ns: int, max_step: float):
    _, counts = steps_to(np.array([span_ns]), 0, max_step)
    assert steps_between(span_ns / 1e9, max_step) == pytest.approx(counts[0], rel=1e-14, abs=0)
    assert steps_to(np.array([1, span_ns + 1]), 0, 1e300)[1].tolist() == [1, 1]


def test_a_step_is_limited_by_the_turn_as_well():
    for name in ("dmv4", "dmv20"):
        assert METHODS[name].longest_step(10.0, 5.0) == 0.05
        assert METHODS[name].longest_step(0.01, 5.0) == 0.01
        assert METHODS[name].longest_step(10.0, 0.0) == 10.0
    assert METHODS["rkmk4"].longest_step(10.0, 5.0) == 10.0


@pytest.mark.parametrize("name", METHODS)
def test_a_step_of_0_is_as_long_as_the_method_allows(name: str):
    """A quarter radian where steps are exact, else a millisecond; of a body at rest the interval."""
    assert METHODS[name].longest_step(0.0, 5.0) == (0.05 if name == "dmv20" else 0.001)
    assert METHODS[name].longest_step(0.0, 1e4) == (0.25e-4 if name.startswith("dmv") else 0.001)
    body, rest = RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], [0.0, 0.0, 0.0])
    chart = MovingChart(body, rest, method=name)
    np.testing.assert_array_equal(chart.at(2**62).attitude_xyzw, rest.attitude_xyzw)


@pytest.mark.parametrize("method", ["dmv20", "dmv4", "rkmk4"])
def test_a_nanosecond_at_a_time_is_the_whole(method: str):
    """However small a part of a step each of them is."""
    body, start = RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], [3.0, 0.5, -0.9])
    times = np.arange(1, 2001)
    [state] = MovingChart(body, start, method=method, max_step=2.0).at(times)[-1:].body_rate
    [whole] = MovingChart(body, start, method=method, max_step=0.01).at([2000]).body_rate
    np.testing.assert_allclose(state, whole, rtol=0, atol=1e-14)
    assert np.abs(state - start.body_rate).max() > 1e-7


def test_a_nanosecond_at_a_time_is_the_whole_on_any_group():
    group = SO(4)
    lagrangian = Lagrangian(group, mass_matrix(np.diag([0.4, 0.6, 0.8, 1.0]), group.generators))
    start, times = GroupState(group.identity, np.linspace(0.1, 0.9, 6)), np.arange(1, 501)
    by_and_by = GroupMovingChart(lagrangian, start, max_step=2.0).at(times).element[-1]
    whole = GroupMovingChart(lagrangian, start, max_step=2.0).at([500]).element[-1]
    np.testing.assert_allclose(by_and_by, whole, rtol=0, atol=1e-13)
