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


def carlson_rf(x: Decimal, y: Decimal, z: Decimal) -> Decimal:
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
        rx = x.sqrt()
        ry = y.sqrt()
        rz = z.sqrt()
        shift = rx * (ry + rz) + ry * rz
        x = (x + shift) / 4
        y = (y + shift) / 4
        z = (z + shift) / 4
        mean = (mean + shift) / 4
        spread /= 4
    dx = 1 - x / mean
    dy = 1 - y / mean
    dz = -dx - dy
    e2 = dx * dy - dz * dz
    e3 = dx * dy * dz
    linear = e3 / 14 - e2 / 10
    square = e2 * e2 / 24 - 3 * e2 * e3 / 44 + 3 * e3 * e3 / 104
    cube = e2 * e2 * e3 / 16 - 5 * e2**3 / 208
    return (1 + linear + square + cube) / mean.sqrt()


def ellipk_complement(m1: Decimal) -> Decimal:
    """K(m) by the arithmetic-geometric mean (DLMF 19.8.5), for m1 = 1 − m in (0, 1]."""
    a = Decimal(1)
    g = root(m1)
    round_off = _round_off()
    while (a - g) ** 2 > round_off * a * a:
        product = a * g
        a = (a + g) / 2
        g = root(product)
    return PI / (a + g)


def mean_ellippi(n1: Decimal, m1: Decimal) -> Decimal:
    """(1 − n) Π(n|m)/K, by the arithmetic-geometric mean (DLMF 19.8.6, 19.8.7), for 0 ≤ n < 1.

    It is the mean of (1 − n)/(1 − n sn²u) over a period, hence in (0, 1]. For n > m as many
    digits are lost as √((1 − m)/(1 − n)) has.

    Parameters
    ----------
    n1, m1 : Decimal
        1 − n and 1 − m, both in (0, 1].
    """
    a = Decimal(1)
    g = root(m1)
    p = root(n1)
    term = Decimal(1)
    total = Decimal(1)
    round_off = _round_off()
    while abs(term) > round_off * total:
        square = p * p
        product = a * g
        term *= (square - product) / (square + product) / 2
        total += term
        p = (square + product) / (2 * p)
        a = (a + g) / 2
        g = root(product)
    return n1 + (1 - n1) * total / 2
