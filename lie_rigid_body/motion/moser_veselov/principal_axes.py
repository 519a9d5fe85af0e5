"""Principal moments and axes to many digits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, getcontext
from typing import TypeAlias

Vector: TypeAlias = tuple[Decimal, Decimal, Decimal]
Matrix: TypeAlias = list[list[Decimal]]


@dataclass(frozen=True)
class PrincipalAxes:
    """The principal axes of a body, that of the intermediate moment second, in a cyclic order of the body's own.

    Attributes
    ----------
    tensor : 3 rows
        The inertia in the body frame, kg m².
    moments : tuple of 3 Decimal
        kg m²
    axes : 3 vectors
        Of unit length, in the body frame, right-handed.
    diagonal : bool
        Whether the axes are the body's own.
    """

    tensor: Matrix
    moments: Vector
    axes: tuple[Vector, Vector, Vector]
    diagonal: bool

    @classmethod
    def of(cls, inertia: Sequence[Sequence[float]]) -> PrincipalAxes:
        """Those of an inertia tensor, in the decimal precision in force."""
        tensor = [[Decimal(entry) for entry in row] for row in inertia]
        values, columns = _diagonalised(tensor)
        middle = sorted(range(3), key=lambda i: values[i])[1]
        first, last = (middle - 1) % 3, (middle + 1) % 3
        diagonal = all(tensor[i][j] == 0 for i, j in ((0, 1), (0, 2), (1, 2)))
        moments = values[first], values[middle], values[last]
        return cls(tensor, moments, (columns[first], columns[middle], columns[last]), diagonal)


def _diagonalised(tensor: Matrix) -> tuple[list[Decimal], list[Vector]]:
    """Moments and the axes of a right-handed frame, by Jacobi's plane rotations, the largest product first."""
    moments = [tensor[i][i] for i in range(3)]
    products = [tensor[1][2], tensor[2][0], tensor[0][1]]
    one, zero = Decimal(1), Decimal(0)
    axes: list[Vector] = [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
    negligible = Decimal(1).scaleb(-2 * getcontext().prec)
    while True:
        # squares of the products of inertia, each relative to the moments of its two axes
        sizes = [products[r] ** 2 / (moments[r - 2] * moments[r - 1]) for r in range(3)]
        r = max(range(3), key=lambda i: sizes[i])
        if sizes[r] <= negligible:
            return moments, axes
        _rotate(moments, products, axes, r)


def _rotate(moments: list[Decimal], products: list[Decimal], axes: list[Vector], r: int) -> None:
    """Turn the two axes other than the r-th, by at most 45°, so that their product of inertia vanishes."""
    p, q = (r + 1) % 3, (r + 2) % 3
    double, difference = 2 * products[r], moments[q] - moments[p]
    root = (double * double + difference * difference).sqrt()
    tangent = double / (difference + root.copy_sign(difference)) if difference else Decimal(1).copy_sign(double)
    cosine = 1 / (1 + tangent * tangent).sqrt()
    sine = tangent * cosine
    change = tangent * products[r]
    moments[p], moments[q] = moments[p] - change, moments[q] + change
    products[r] = Decimal(0)
    products[q], products[p] = cosine * products[q] - sine * products[p], sine * products[q] + cosine * products[p]
    (a, b, c), (d, e, f) = axes[p], axes[q]
    axes[p] = cosine * a - sine * d, cosine * b - sine * e, cosine * c - sine * f
    axes[q] = sine * a + cosine * d, sine * b + cosine * e, sine * c + cosine * f
