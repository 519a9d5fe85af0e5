"""Pairs of doubles against exact fractions and mpmath, the same bits in floats and in arrays."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body.motion.closed_form import pairs
from lie_rigid_body.motion.closed_form.arctangent import arctangent
from lie_rigid_body.motion.closed_form.pairs import Pair


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


def as_mp(pair: Pair) -> mpf:
    return mpf(float(pair[0])) + mpf(float(pair[1]))


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
        assert abs(as_mp(angle) - mp.atan(as_mp(tangent))) <= mpf(2) ** -66
    assert_same_in_arrays(angle, arctangent(in_array(tangent)))
