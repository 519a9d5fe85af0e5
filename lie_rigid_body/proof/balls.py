"""Vectors and quaternions of balls, and the way from balls back to doubles, rounded outward.

A ball is an `flint.arb`: a midpoint and a radius. An operation on balls gives a ball that holds every result of the
same operation on numbers of them: F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic, IEEE Trans. Comput. 66 (2017), 1281-1292.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from typing import Final, TypeAlias

from flint import arb, fmpq

MAX_FLOAT: Final = sys.float_info.max

Balls: TypeAlias = tuple[arb, ...]
"""A vector (3 balls) or a quaternion (4 balls, scalar last)."""

Integers: TypeAlias = tuple[tuple[int, int], tuple[int, int]]
"""A ball exactly: mantissa and exponent of two, of its midpoint and of its radius."""


class UndecidedError(ArithmeticError):
    """Balls are too wide to tell what a formula depends on."""


def integers(x: arb) -> Integers:
    """A ball as the integers that it is made of, of which ``arb`` makes one that holds it, whatever the precision."""
    m, e = x.mid().man_exp()
    r, s = x.rad().man_exp()
    return (int(m), int(e)), (int(r), int(s))


def dot(a: Balls, b: Balls) -> arb:
    """Scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def norm(a: Balls) -> arb:
    """Euclidean norm. A sum of squares is not negative, though the ball of a number near 0 says it may be."""
    return dot(a, a).nonnegative_part().sqrt()


def scaled(factor: arb, a: Balls) -> Balls:
    """Every component times a factor."""
    return tuple(factor * x for x in a)


def added(a: Balls, b: Balls) -> Balls:
    """Sum by components."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def cross(a: Balls, b: Balls) -> Balls:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def product(p: Balls, q: Balls) -> Balls:
    """Hamilton's product of quaternions x y z w."""
    vector = added(added(scaled(p[3], q[:3]), scaled(q[3], p[:3])), cross(p[:3], q[:3]))
    return (*vector, p[3] * q[3] - dot(p[:3], q[:3]))


def conjugate(q: Balls) -> Balls:
    """The inverse of a unit quaternion."""
    return (-q[0], -q[1], -q[2], q[3])


def rotation(vector: Balls) -> Balls:
    """The unit quaternion of a rotation vector, exp(vector/2)."""
    angle = norm(vector)
    if angle == 0:
        return (arb(0), arb(0), arb(0), arb(1))
    return (*scaled((angle / 2).sin() / angle, vector), (angle / 2).cos())


def rotated(q: Balls, vector: Balls) -> Balls:
    """A vector turned by a unit quaternion."""
    return product(product(q, (*vector, arb(0))), conjugate(q))[:3]


def sign(ball: arb) -> int:
    """1 or −1, of every number of a ball.

    Raises
    ------
    UndecidedError
        If the ball holds 0: the precision is too low.
    """
    if ball > 0:
        return 1
    if ball < 0:
        return -1
    raise UndecidedError


def exact(values: Sequence[fmpq]) -> Balls:
    """Rational numbers as balls of the present precision."""
    return tuple(arb(value) for value in values)


def widest(a: Balls) -> arb:
    """The largest radius of the components, times two; not finite where a component is not."""
    width = max((x.rad() for x in a), key=lambda radius: radius.upper())
    return 2 * width if all(x.is_finite() for x in a) else arb("inf")


def at_most(ball: arb) -> float:
    """The least double that no number of a ball exceeds; infinite where the ball is not finite."""
    if not ball.is_finite():
        return math.inf
    mantissa, exponent = (int(part) for part in ball.upper().man_exp())
    value = Fraction(mantissa) * Fraction(2) ** exponent
    if abs(value) > MAX_FLOAT:
        return math.inf if value > 0 else -MAX_FLOAT
    nearest = float(value)
    return math.nextafter(nearest, math.inf) if Fraction(nearest) < value else nearest


def at_least(ball: arb) -> float:
    """The largest double that every number of a ball reaches; minus infinity where the ball is not finite."""
    return 0.0 - at_most(-ball)  # of 0 it is not -0.0
