"""Explicit Runge–Kutta tableaus of the steppers; tests hold their order conditions."""

from __future__ import annotations

from fractions import Fraction
from typing import Final, NamedTuple, TypeAlias

Row: TypeAlias = tuple[Fraction, ...]


class ChainTableau(NamedTuple):
    """Coefficients of an explicit Runge–Kutta method in which each stage needs only the one before.

    Attributes
    ----------
    name : str
        The public name of the stepper built on it.
    order : int
        Order of accuracy.
    a : tuple of Fraction
        For each stage the weight of the slope before it, which also is its node c; 0 for the first.
    b : tuple of Fraction
        Weights of the stages.
    """

    name: str
    order: int
    a: Row
    b: Row


_HALF: Final = Fraction(1, 2)

EULER: Final = ChainTableau("rkmk1", 1, (Fraction(0),), (Fraction(1),))
"""Lie–Euler: the forward Euler method in the chart."""

MIDPOINT: Final = ChainTableau("rkmk2", 2, (Fraction(0), _HALF), (Fraction(0), Fraction(1)))
"""The explicit midpoint rule (Runge 1895)."""

CLASSICAL: Final = ChainTableau(
    "rkmk4",
    4,
    (Fraction(0), _HALF, _HALF, Fraction(1)),
    (Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6)),
)
"""The classical fourth-order method (Kutta 1901)."""
