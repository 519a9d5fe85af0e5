"""Explicit Runge–Kutta tableaus that check themselves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, TypeAlias

Row: TypeAlias = tuple[Fraction, ...]


@dataclass(frozen=True)
class ChainTableau:
    """Coefficients of an explicit Runge–Kutta method in which each stage needs only the one before.

    Parameters
    ----------
    name : str
        The public name of the stepper built on it.
    order : int
        Order of accuracy, 1 to 4.
    a : tuple of Fraction
        For each stage the weight of the slope before it, which also is its node c; 0 for the first.
    b : tuple of Fraction
        Weights of the stages.

    Raises
    ------
    ValueError
        If the coefficients do not fulfil the order conditions of the order claimed.

    References
    ----------
    E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., sec. II.2, table 2.2.
    """

    name: str
    order: int
    a: Row
    b: Row

    def __post_init__(self) -> None:
        if len(self.a) != len(self.b) or self.a[0]:
            raise ValueError(f"tableau {self.name}: not one weight a stage, or one before the first")
        for label, order, total, wanted in self._conditions():
            if order <= self.order and total != wanted:
                raise ValueError(f"tableau {self.name}: order condition {label} gives {total}, not {wanted}")

    def _conditions(self) -> Iterator[tuple[str, int, Fraction, Fraction]]:
        """The eight order conditions up to order 4 as (label, order, sum, wanted)."""
        c = self.a
        square = tuple(x**2 for x in c)
        ac = self._applied(c)
        for label, order, inverse, weights in (
            ("Σb", 1, 1, tuple(Fraction(1) for _ in c)),
            ("Σbc", 2, 2, c),
            ("Σbc²", 3, 3, square),
            ("ΣbAc", 3, 6, ac),
            ("Σbc³", 4, 4, tuple(x**3 for x in c)),
            ("ΣbcAc", 4, 8, tuple(x * y for x, y in zip(c, ac, strict=True))),
            ("ΣbAc²", 4, 12, self._applied(square)),
            ("ΣbAAc", 4, 24, self._applied(ac)),
        ):
            total = sum((x * y for x, y in zip(self.b, weights, strict=True)), Fraction(0))
            yield label, order, total, Fraction(1, inverse)

    def _applied(self, values: Row) -> Row:
        """The matrix A, of which ``a`` is all that is not 0, times values of the stages."""
        return tuple(weight * value for weight, value in zip(self.a, (Fraction(0), *values[:-1]), strict=True))


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
