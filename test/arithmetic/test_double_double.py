from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body.motion.closed_form import double_double
from lie_rigid_body.motion.closed_form.double_double import DoubleDouble
from lie_rigid_body.motion.closed_form.precision import PI

RANDOM = np.random.default_rng(20)
SIZE = 300
INT64 = st.integers(-(2**63), 2**63 - 1)


def numbers(size: int = SIZE) -> np.ndarray:
    return RANDOM.normal(size=size) * 10.0 ** RANDOM.uniform(-20, 20, size=size)


def pairs(size: int = SIZE) -> DoubleDouble:
    hi = numbers(size)
    return DoubleDouble(hi, hi * RANDOM.uniform(-0.5, 0.5, size=size) * 2.0**-53)


def exact(x: DoubleDouble) -> list[Fraction]:
    return [Fraction(float(h)) + Fraction(float(lo)) for h, lo in zip(*np.broadcast_arrays(x.hi, x.lo), strict=True)]


def test_sums_and_products_of_doubles_lose_nothing():
    a, b = numbers(), numbers()
    fractions = [(Fraction(x), Fraction(y)) for x, y in zip(a.tolist(), b.tolist(), strict=True)]
    assert exact(double_double.two_sum(a, b)) == [x + y for x, y in fractions]
    assert exact(double_double.two_product(a, b)) == [x * y for x, y in fractions]
    small, large = np.minimum(abs(a), abs(b)), np.maximum(abs(a), abs(b))
    assert exact(double_double.fast_two_sum(large, small)) == [
        x + y for x, y in zip(*map(exact_list, (large, small)), strict=True)
    ]


def exact_list(a: np.ndarray) -> list[Fraction]:
    return [Fraction(x) for x in a.tolist()]


def test_a_sum_of_double_doubles_keeps_104_bits_of_the_larger():
    a, b = pairs(), pairs()
    for x, y, s in zip(exact(a), exact(b), exact(double_double.add(a, b)), strict=True):
        assert abs(s - (x + y)) <= max(abs(x), abs(y)) * Fraction(2) ** -104


def test_a_product_of_double_doubles_keeps_102_bits():
    a, b = pairs(), pairs()
    for x, y, p in zip(exact(a), exact(b), exact(double_double.multiply(a, b)), strict=True):
        assert abs(p - x * y) <= abs(x * y) * Fraction(2) ** -102


@settings(max_examples=200, deadline=None)
@given(INT64)
def test_integers_of_64_bits_are_exact(n: int):
    assert exact(double_double.from_integers(np.array([n], dtype=np.int64))) == [n]


@pytest.mark.parametrize("n", [-(2**63), 2**63 - 1, 2**53 + 1, -(2**53) - 1, 2**32, -1, 0])
def test_integers_at_the_limits_are_exact(n: int):
    assert exact(double_double.from_integers(np.array([n], dtype=np.int64))) == [n]


@settings(max_examples=200, deadline=None)
@given(INT64, st.floats(-0.5, 0.5))
def test_the_remainder_differs_by_an_integer_and_is_at_most_a_half(n: int, part: float):
    x = double_double.add(double_double.from_integers(np.array([n], dtype=np.int64)), pair(part))
    (before,), (after,) = exact(x), exact(double_double.remainder(x))
    assert (before - after).denominator == 1
    assert abs(after) <= Fraction(1, 2) + Fraction(2) ** -53


def pair(x: float) -> DoubleDouble:
    return DoubleDouble(np.array([x]), np.zeros(1))


def test_a_decimal_is_rounded_to_32_digits():
    hi, lo = double_double.from_decimal(PI)
    with mp.workdps(60):
        assert abs(mpf(float(hi)) + mpf(float(lo)) - mp.pi) < mpf(2) ** -106
