"""The arctangent in pairs."""

from __future__ import annotations

from decimal import Decimal
from functools import lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.motion.closed_form.double_double import Array, Number
from lie_rigid_body.motion.closed_form.pairs import ONE, Pair, add, divide, multiply, subtract
from lie_rigid_body.motion.closed_form.precision import working_precision

_PARTS: Final = 32


def arctangent(tangent: Pair) -> Pair:
    """The arctangent of a number in [0, 1], to 1e-21: the nearest of a table, and the rest by a power series."""
    nearest, entry = _entry(tangent[0])
    rest = divide(subtract(tangent, (nearest, 0.0)), add(ONE, multiply(tangent, (nearest, 0.0))))
    square = rest[0] * rest[0]
    cubic = rest[0] * square * (-1 / 3 + square * (1 / 5 + square * (-1 / 7 + square / 9)))
    return add(entry, (rest[0], rest[1] + cubic))


def _entry(tangent: Number) -> tuple[Number, Pair]:
    """The number k/32 nearest to this one, and its arctangent."""
    hi, lo = _table()
    if isinstance(tangent, float):
        k = round(_PARTS * tangent)
        return k / _PARTS, (hi[k], lo[k])
    places = np.rint(_PARTS * tangent).astype(np.intp)
    return places / _PARTS, (_columns()[0][places], _columns()[1][places])


@lru_cache(maxsize=1)
def _columns() -> tuple[Array, Array]:
    hi, lo = _table()
    return np.array(hi), np.array(lo)


@lru_cache(maxsize=1)
def _table() -> tuple[list[float], list[float]]:
    """atan(k/32): from one to the next it grows by atan(32/(1024 + k(k + 1)))."""
    with working_precision(40):
        angles = [Decimal(0)]
        for k in range(_PARTS):
            angles.append(angles[-1] + _series(Decimal(_PARTS) / (_PARTS * _PARTS + k * (k + 1))))
        return [float(a) for a in angles], [float(a - Decimal(float(a))) for a in angles]


def _series(x: Decimal) -> Decimal:
    return sum(((-1) ** n * x ** (2 * n + 1) / (2 * n + 1) for n in range(14)), Decimal(0))
