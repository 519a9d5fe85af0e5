"""Double-double arithmetic against exact fractions and mpmath: on floats, on arrays and compiled the same bits."""

from __future__ import annotations

from fractions import Fraction
from importlib.util import find_spec

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body.arithmetic import double_double
from lie_rigid_body.arithmetic.decimals import PI
from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.compilation import compiler

RANDOM = np.random.default_rng(20)
SIZE = 300
INT64 = st.integers(-(2**63), 2**63 - 1)


def numbers(size: int = SIZE) -> np.ndarray:
    return RANDOM.normal(size=size) * 10.0 ** RANDOM.uniform(-20, 20, size=size)


def pairs(size: int = SIZE) -> DoubleDouble:
    hi = numbers(size)
    return hi, hi * RANDOM.uniform(-0.5, 0.5, size=size) * 2.0**-53


def exact(x: DoubleDouble) -> list[Fraction]:
    return [Fraction(float(h)) + Fraction(float(lo)) for h, lo in zip(*np.broadcast_arrays(*x), strict=True)]


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


@given(INT64)
def test_integers_of_64_bits_are_exact(n: int):
    assert exact(double_double.from_integers(np.array([n], dtype=np.int64))) == [n]


@pytest.mark.parametrize("n", [-(2**63), 2**63 - 1, 2**53 + 1, -(2**53) - 1, 2**32, -1, 0])
def test_integers_at_the_limits_are_exact(n: int):
    assert exact(double_double.from_integers(np.array([n], dtype=np.int64))) == [n]


@given(INT64, st.floats(-0.5, 0.5))
def test_the_remainder_differs_by_an_integer_and_is_at_most_a_half(n: int, part: float):
    x = double_double.add(double_double.from_integers(np.array([n], dtype=np.int64)), pair(part))
    (before,), (after,) = exact(x), exact(double_double.remainder(x))
    assert (before - after).denominator == 1
    assert abs(after) <= Fraction(1, 2) + Fraction(2) ** -53


def pair(x: float) -> DoubleDouble:
    return np.array([x]), np.zeros(1)


def test_a_decimal_is_rounded_to_32_digits():
    hi, lo = double_double.from_decimal(PI)
    with mp.workdps(60):
        assert abs(mpf(float(hi)) + mpf(float(lo)) - mp.pi) < mpf(2) ** -106


def fraction(pair: DoubleDouble) -> Fraction:
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


PARTS = st.floats(1e-12, 1e12)
LOWS = st.floats(-0.5, 0.5)


@given(PARTS, LOWS, PARTS, LOWS, st.booleans())
def test_operations_keep_100_bits_on_floats_and_arrays(a: float, rest: float, b: float, other: float, negative: bool):
    b = -b if negative else b
    x, y = (a, a * rest * 2.0**-53), (b, b * other * 2.0**-53)
    p, q, ulp = fraction(x), fraction(y), Fraction(2) ** -100
    for operation, truth, size in (
        (double_double.add, p + q, max(abs(p), abs(q)) * 2),
        (double_double.subtract, p - q, max(abs(p), abs(q)) * 2),
        (double_double.multiply, p * q, abs(p * q)),
        (double_double.divide, p / q, abs(p / q)),
    ):
        result = operation(x, y)
        assert abs(fraction(result) - truth) <= size * ulp
        assert_same_in_arrays(result, operation(in_array(x), in_array(y)))
    root = double_double.square_root(x)
    assert abs(fraction(root) ** 2 - p) <= 2 * p * ulp


def in_array(pair: DoubleDouble) -> DoubleDouble:
    return np.full(9, pair[0]), np.full(9, pair[1])


def assert_same_in_arrays(pair: DoubleDouble, many: DoubleDouble) -> None:
    for part, column in zip(pair, many, strict=True):
        np.testing.assert_array_equal(column, np.full(9, part))


def test_the_root_of_nothing_is_nothing():
    assert double_double.square_root((0.0, 0.0)) == (0.0, 0.0)


def every_operation(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """The results of all operations on pairs, hi and lo by turns, into the columns of ``out``."""
    for i in range(len(a)):
        x, y = (a[i, 0], a[i, 1]), (b[i, 0], b[i, 1])
        results = (
            double_double.add(x, y),
            double_double.subtract(x, y),
            double_double.multiply(x, y),
            double_double.divide(x, y),
            double_double.square_root((abs(x[0]), x[1])),
        )
        for k in range(5):
            out[i, 2 * k], out[i, 2 * k + 1] = results[k]


@pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed")
def test_compiled_code_gives_the_same_bits(monkeypatch):
    a, b = np.stack(pairs(), axis=-1), np.stack(pairs(), axis=-1)
    plain, found = np.empty((SIZE, 10)), np.empty((SIZE, 10))
    every_operation(a, b, plain)
    # the loop is this test's own, and nothing to keep
    monkeypatch.setattr(compiler, "cache_folder", lambda *_: None)
    run = compiler.compiled(every_operation, (a, b, found))
    assert run is not None
    run(a, b, found)
    np.testing.assert_array_equal(found, plain)
