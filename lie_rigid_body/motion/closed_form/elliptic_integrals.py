"""Elliptic integrals of real arguments to the decimal precision in force, free of cancellation.

Everything is written in the complementary parameter m1 = 1 − m, which loses no digit next to a separatrix.

References
----------
B. C. Carlson, "Numerical computation of real or complex elliptic integrals", Numer. Algorithms 10 (1995) 13.
NIST Digital Library of Mathematical Functions (DLMF), https://dlmf.nist.gov, chapter 19.
"""

from __future__ import annotations

from decimal import Decimal, getcontext

from lie_rigid_body.arithmetic.decimals import PI, root


def _round_off() -> Decimal:
    return Decimal(1).scaleb(-getcontext().prec)


def symmetric_first(x: Decimal, y: Decimal, z: Decimal) -> Decimal:
    """Carlson's R_F(x, y, z), by duplication (Carlson 1995, algorithm of sec. 2; DLMF 19.36.1).

    Parameters
    ----------
    x, y, z : Decimal
        Not negative, at most one of them 0.
    """
    mean = (x + y + z) / 3
    spread = max(abs(mean - x), abs(mean - y), abs(mean - z))
    # the neglected eighth order of the series is below round-off once spread⁸ is
    narrow = Decimal(1).scaleb(-(getcontext().prec + 7) // 8)
    while spread > narrow * mean:
        rx, ry, rz = x.sqrt(), y.sqrt(), z.sqrt()
        shift = rx * (ry + rz) + ry * rz
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4
        mean, spread = (mean + shift) / 4, spread / 4
    dx, dy = 1 - x / mean, 1 - y / mean
    dz = -dx - dy
    e2, e3 = dx * dy - dz * dz, dx * dy * dz
    linear = e3 / 14 - e2 / 10
    square = e2 * e2 / 24 - 3 * e2 * e3 / 44 + 3 * e3 * e3 / 104
    cube = e2 * e2 * e3 / 16 - 5 * e2**3 / 208
    return (1 + linear + square + cube) / mean.sqrt()


def complete_first(m1: Decimal) -> Decimal:
    """K by the arithmetic-geometric mean (DLMF 19.8.5), for m1 in (0, 1]."""
    a, g = Decimal(1), root(m1)
    round_off = _round_off()
    while (a - g) ** 2 > round_off * a * a:
        a, g = (a + g) / 2, root(a * g)
    return PI / (a + g)


def mean_third(n1: Decimal, m1: Decimal) -> Decimal:
    """(1 − n) Π(n|m)/K, by the arithmetic-geometric mean (DLMF 19.8.6, 19.8.7), for 0 ≤ n < 1.

    It is the mean of (1 − n)/(1 − n sn²u) over a period, hence in (0, 1]. For n > m as many
    digits are lost as √((1 − m)/(1 − n)) has.

    Parameters
    ----------
    n1, m1 : Decimal
        1 − n and 1 − m, both in (0, 1].
    """
    a, g, p = Decimal(1), root(m1), root(n1)
    term = total = Decimal(1)
    round_off = _round_off()
    while abs(term) > round_off * total:
        square, product = p * p, a * g
        term *= (square - product) / (square + product) / 2
        total += term
        p = (square + product) / (2 * p)
        a, g = (a + g) / 2, root(product)
    return n1 + (1 - n1) * total / 2
