"""Principal moments and axes to the decimal precision in force.

A moment wrong by 1e-16 turns the body by 1e-9 rad in 1e7 s at 1 rad/s, so the double-precision decomposition will not
do for the closed form.
"""

from __future__ import annotations

from decimal import Decimal, getcontext
from typing import NamedTuple

from lie_rigid_body.motion.closed_form.precision import COUPLED_DIGITS, DIGITS, root

Vector = tuple[Decimal, Decimal, Decimal]


class PrincipalAxes(NamedTuple):
    """Moments in ascending order, kg m², and their unit axes in the body frame (of either handedness)."""

    moments: Vector
    axes: tuple[Vector, Vector, Vector]


def digits_for(entries: list[float]) -> int:
    """Digits in which the moments of a tensor with these nine entries are told apart.

    A product of inertia of relative size ε splits equal moments by as little as ε², and the splitting is wanted to
    the full precision.
    """
    sizes = [Decimal(entry).adjusted() for entry in entries if entry != 0.0]
    return (DIGITS if len(sizes) == 3 else COUPLED_DIGITS) + 2 * (max(sizes) - min(sizes))


def principal_axes(inertia: list[list[float]]) -> PrincipalAxes:
    """Cyclic Jacobi rotations (G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., sec. 8.5).

    Each rotation is applied to every entry it concerns and no other, so blocks that are uncoupled stay exactly so.

    Parameters
    ----------
    inertia : 3 rows of 3
        Symmetric positive definite, kg m², body frame.
    """
    a = [[Decimal(entry) for entry in row] for row in inertia]
    v = [[Decimal(int(i == j)) for j in range(3)] for i in range(3)]
    tiny = Decimal(1).scaleb(-2 * getcontext().prec)
    while any(a[p][q] != 0 for p, q in ((0, 1), (0, 2), (1, 2))):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if a[p][q] ** 2 <= tiny * a[p][p] * a[q][q]:
                a[p][q] = a[q][p] = Decimal(0)
            else:
                _rotate(a, v, p, q)
    order = sorted(range(3), key=lambda i: a[i][i])
    first, second, third = ((v[0][i], v[1][i], v[2][i]) for i in order)
    return PrincipalAxes((a[order[0]][order[0]], a[order[1]][order[1]], a[order[2]][order[2]]), (first, second, third))


def _rotate(a: list[list[Decimal]], v: list[list[Decimal]], p: int, q: int) -> None:
    """One rotation in the plane of axes p and q that makes a[p][q] zero."""
    half_cotangent = (a[q][q] - a[p][p]) / (2 * a[p][q])
    t = 1 / (abs(half_cotangent) + root(half_cotangent * half_cotangent + 1))
    t = -t if half_cotangent < 0 else t
    c = 1 / root(t * t + 1)
    s, r = t * c, 3 - p - q
    a[p][p], a[q][q] = a[p][p] - t * a[p][q], a[q][q] + t * a[p][q]
    a[p][q] = a[q][p] = Decimal(0)
    a[r][p], a[r][q] = c * a[r][p] - s * a[r][q], s * a[r][p] + c * a[r][q]
    a[p][r], a[q][r] = a[r][p], a[r][q]
    for row in v:
        row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
