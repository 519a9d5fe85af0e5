"""Questions only exact arithmetic answers: is the rotation steady, and on which side of the separatrix.

Doubles are integers times a power of two, and the answers do not change with the scale of inertia or rate, so Python's
integers are enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

Vector = tuple[int, int, int]


def integers(values: Sequence[float]) -> tuple[list[int], int]:
    """The values as integers over one common denominator.

    Returns
    -------
    numerators : list of int
    denominator : int
        A power of two.
    """
    ratios = [float(value).as_integer_ratio() for value in values]
    common = max(denominator for _, denominator in ratios)
    return [numerator * (common // denominator) for numerator, denominator in ratios], common


def _dot(a: Sequence[int], b: Sequence[int]) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Sequence[int], b: Sequence[int]) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def is_steady(inertia: Sequence[Sequence[float]], rate: Sequence[float]) -> bool:
    """Whether ω × Mω is exactly zero, so that the body turns about a fixed axis for ever.

    Parameters
    ----------
    inertia : sequence of 3 rows
        M, body frame.
    rate : sequence of 3
        ω, body frame.
    """
    entries, _ = integers([entry for row in inertia for entry in row])
    omega, _ = integers(rate)
    momentum = [_dot(entries[3 * i : 3 * i + 3], omega) for i in range(3)]
    return _cross(omega, momentum) == (0, 0, 0)


def separatrix_determinant(inertia: Sequence[Sequence[float]], rate: Sequence[float]) -> Decimal:
    """det(2H·M − l²·1), with 2H = ω·Mω and l = |Mω|, rounded once.

    With principal moments I₁ ≤ I₂ ≤ I₃ it is (2H I₁ − l²)(2H I₂ − l²)(2H I₃ − l²). For a rotation that is not steady
    its first factor is negative and its last positive, so it has the sign of l² − 2H I₂: positive when the momentum
    circulates about axis 3, negative when about axis 1, and zero exactly on the separatrix.
    """
    entries, inertia_scale = integers([entry for row in inertia for entry in row])
    omega, rate_scale = integers(rate)
    momentum = [_dot(entries[3 * i : 3 * i + 3], omega) for i in range(3)]
    energy, square = _dot(omega, momentum), _dot(momentum, momentum)
    rows = [[energy * entries[3 * i + j] - (square if i == j else 0) for j in range(3)] for i in range(3)]
    determinant = _dot(rows[0], _cross(rows[1], rows[2]))
    return Decimal(determinant) / Decimal(inertia_scale * rate_scale) ** 6
