"""Double-double arithmetic on single numbers against exact fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.motion.moser_veselov import double_double as dd

RNG = np.random.default_rng(2)
PAIRS = [
    dd.fast_two_sum(float(hi), float(lo))
    for hi, lo in zip(RNG.normal(size=80) * 10.0 ** RNG.uniform(-8, 8, 80), RNG.normal(size=80) * 1e-25, strict=True)
]


def exact(pair: tuple[float, float]) -> Fraction:
    return Fraction(pair[0]) + Fraction(pair[1])


@pytest.mark.parametrize(("a", "b"), list(zip(PAIRS[::2], PAIRS[1::2], strict=True)))
def test_operations_are_right_to_thirty_digits(a, b):
    x, y = exact(a), exact(b)
    assert exact(dd.two_sum(a[0], b[0])) == Fraction(a[0]) + Fraction(b[0])
    assert exact(dd.two_product(a[0], b[0])) == Fraction(a[0]) * Fraction(b[0])
    larger = Fraction(2) ** -104 * max(abs(x), abs(y))
    assert abs(exact(dd.add(a, b)) - (x + y)) <= larger
    assert abs(exact(dd.subtract(a, b)) - (x - y)) <= larger
    assert abs(exact(dd.multiply(a, b)) / (x * y) - 1) <= Fraction(2) ** -102
    assert abs(exact(dd.divide(a, b)) / (x / y) - 1) <= Fraction(2) ** -100
    with mp.workdps(60):
        positive = a if a[0] > 0.0 else (-a[0], -a[1])
        hi, lo = dd.square_root(positive)
        root = mp.sqrt(mpf(positive[0]) + mpf(positive[1]))
        assert abs((mpf(hi) + mpf(lo)) / root - 1) < mpf(2) ** -100
