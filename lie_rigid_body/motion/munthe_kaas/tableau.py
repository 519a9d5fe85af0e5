"""Explicit Runge–Kutta tableaus that check themselves."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Final, TypeAlias

Row: TypeAlias = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """Coefficients of an explicit Runge–Kutta method.

    Parameters
    ----------
    name : str
        The public name of the stepper built on it.
    order : int
        Order of accuracy, 1 to 4.
    a : tuple of tuple of Fraction
        Row i holds the i weights of the earlier stages; strictly lower triangular.
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
    a: tuple[Row, ...]
    b: Row

    def __post_init__(self) -> None:
        if any(len(row) != stage for stage, row in enumerate(self.a)) or len(self.a) != len(self.b):
            raise ValueError(f"tableau {self.name}: not strictly lower triangular with one weight a stage")
        for label, order, total, wanted in self._conditions():
            if order <= self.order and total != wanted:
                raise ValueError(f"tableau {self.name}: order condition {label} gives {total}, not {wanted}")

    @property
    def c(self) -> Row:
        """Nodes: the row sums of ``a``."""
        return tuple(sum(row, Fraction(0)) for row in self.a)

    def _conditions(self) -> list[tuple[str, int, Fraction, Fraction]]:
        """The eight order conditions up to order 4 as (label, order, sum, wanted)."""
        b, c = self.b, self.c
        ac = self._apply(c)
        return [
            ("Σb", 1, sum(b, Fraction(0)), Fraction(1)),
            ("Σbc", 2, _dot(b, c), Fraction(1, 2)),
            ("Σbc²", 3, _dot(b, _power(c, 2)), Fraction(1, 3)),
            ("ΣbAc", 3, _dot(b, ac), Fraction(1, 6)),
            ("Σbc³", 4, _dot(b, _power(c, 3)), Fraction(1, 4)),
            ("ΣbcAc", 4, _dot(b, tuple(x * y for x, y in zip(c, ac, strict=True))), Fraction(1, 8)),
            ("ΣbAc²", 4, _dot(b, self._apply(_power(c, 2))), Fraction(1, 12)),
            ("ΣbAAc", 4, _dot(b, self._apply(ac)), Fraction(1, 24)),
        ]

    def _apply(self, values: Row) -> Row:
        return tuple(_dot(row, values[: len(row)]) for row in self.a)


def _dot(left: Row, right: Row) -> Fraction:
    return sum((x * y for x, y in zip(left, right, strict=True)), Fraction(0))


def _power(values: Row, exponent: int) -> Row:
    return tuple(v**exponent for v in values)


_HALF: Final = Fraction(1, 2)

EULER: Final = Tableau("rkmk1", 1, ((),), (Fraction(1),))
"""Lie–Euler: the forward Euler method in the chart."""

MIDPOINT: Final = Tableau("rkmk2", 2, ((), (_HALF,)), (Fraction(0), Fraction(1)))
"""The explicit midpoint rule (Runge 1895)."""

CLASSICAL: Final = Tableau(
    "rkmk4",
    4,
    ((), (_HALF,), (Fraction(0), _HALF), (Fraction(0), Fraction(0), Fraction(1))),
    (Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6)),
)
"""The classical fourth-order method (Kutta 1901)."""
