"""The frame and the units in which a torque-free motion is stepped.

Axes are the principal ones, the one of the intermediate moment second, in a cyclic order of the body's own, so that
the frame is right-handed and a body given by its principal moments needs no arithmetic to change frames. The unit of
momentum is that of the motion and the unit of time the inverse of its largest body rate, so that every number is of
order 1 whatever the body.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, getcontext, localcontext
from typing import Final, TypeAlias

from lie_rigid_body.mechanics import RigidBody, State

Vector: TypeAlias = tuple[Decimal, Decimal, Decimal]
Matrix: TypeAlias = list[list[Decimal]]

_DIGITS: Final = 60


def working_precision() -> AbstractContextManager[Context]:
    """Decimal arithmetic of many digits and unlimited range, inside a ``with`` block."""
    return localcontext(Context(prec=_DIGITS, Emin=MIN_EMIN, Emax=MAX_EMAX))


@dataclass(frozen=True)
class SpinningFrame:
    """Constants of a motion in its own frame and units.

    Attributes
    ----------
    axes : 3 vectors
        Unit principal axes in the body frame, right-handed, that of the intermediate moment second.
    diagonal : bool
        Whether the axes are the body's own in a cyclic order.
    inverse_moments : tuple of 3 Decimal
        e₁, e₂, e₃: body rates per momentum.
    momentum : tuple of 3 Decimal
        The unit vector n of the initial body momentum, in this frame.
    twice_energy : Decimal
        2H = Σ eⱼnⱼ².
    m1, m3 : Decimal
        Squares of n₁ and n₃ where n₂ = 0, which every motion passes, or comes arbitrarily near to.
    fastest : Decimal
        The largest body rate, rad/s: the unit of rates.
    """

    axes: tuple[Vector, Vector, Vector]
    diagonal: bool
    inverse_moments: Vector
    momentum: Vector
    twice_energy: Decimal
    m1: Decimal
    m3: Decimal
    fastest: Decimal

    @classmethod
    def of(cls, body: RigidBody, start: State) -> SpinningFrame:
        """The frame of a motion, in the decimal precision in force."""
        tensor = [[Decimal(entry) for entry in row] for row in body.inertia.tolist()]
        moments, axes, diagonal = _principal(tensor)
        rate = [Decimal(component) for component in start.body_rate.tolist()]
        total = [sum((a * b for a, b in zip(row, rate, strict=True)), Decimal(0)) for row in tensor]
        size = sum((x * x for x in total), Decimal(0)).sqrt()
        if size == 0:
            momentum: Vector = (Decimal(0), Decimal(0), Decimal(1))
        else:
            momentum = _vector([_dot(axis, total) / size for axis in axes])
        return cls._scaled(axes, diagonal, moments, momentum, size)

    @classmethod
    def _scaled(
        cls, axes: tuple[Vector, Vector, Vector], diagonal: bool, moments: Vector, momentum: Vector, size: Decimal
    ) -> SpinningFrame:
        e1, e2, e3 = (1 / moment for moment in moments)
        a, b, c = (component * component for component in momentum)
        if e1 == e3:  # a sphere: every direction will do
            m1, m3 = a, b + c
        else:
            # (2H − e₃)/(e₁ − e₃) and (e₁ − 2H)/(e₁ − e₃), where nothing cancels
            m1 = a + b * (e2 - e3) / (e1 - e3)
            m3 = c + b * (e1 - e2) / (e1 - e3)
        fastest = (e1 * e1 * m1 + e3 * e3 * m3).sqrt()
        scaled = (e1 / fastest, e2 / fastest, e3 / fastest)
        energy = scaled[0] * m1 + scaled[2] * m3
        return cls(axes, diagonal, scaled, momentum, energy, m1, m3, size * fastest)


def _principal(tensor: Matrix) -> tuple[Vector, tuple[Vector, Vector, Vector], bool]:
    """Moments and axes, the intermediate second, the others so that the frame is right-handed."""
    values, vectors = _diagonalised(tensor)
    middle = sorted(range(3), key=lambda i: values[i])[1]
    order = ((middle - 1) % 3, middle, (middle + 1) % 3)
    axes = tuple(_vector([vectors[row][i] for row in range(3)]) for i in order)
    diagonal = all(tensor[i][j] == 0 for i, j in ((0, 1), (0, 2), (1, 2)))
    return _vector([values[i] for i in order]), (axes[0], axes[1], axes[2]), diagonal


def _diagonalised(tensor: Matrix) -> tuple[list[Decimal], Matrix]:
    """Moments and a rotation with the axes as columns, by Jacobi's plane rotations, the largest product first."""
    a = [list(row) for row in tensor]
    v = [[Decimal(int(i == j)) for j in range(3)] for i in range(3)]
    negligible = Decimal(1).scaleb(-2 * getcontext().prec)
    while True:
        p, q = max(((0, 1), (0, 2), (1, 2)), key=lambda pq: a[pq[0]][pq[1]] ** 2 / (a[pq[0]][pq[0]] * a[pq[1]][pq[1]]))
        if a[p][q] ** 2 <= negligible * a[p][p] * a[q][q]:
            return [a[i][i] for i in range(3)], v
        g = _plane_rotation(a, p, q)
        a = _product(_transposed(g), _product(a, g))
        v = _product(v, g)


def _plane_rotation(a: Matrix, p: int, q: int) -> Matrix:
    """The rotation G in the plane of two axes, by at most 45°, that makes (GᵀAG)[p][q] zero."""
    double, difference = 2 * a[p][q], a[q][q] - a[p][p]
    root = (double * double + difference * difference).sqrt()
    tangent = double / (difference + root.copy_sign(difference)) if difference else Decimal(1).copy_sign(double)
    cosine = 1 / (1 + tangent * tangent).sqrt()
    g = [[Decimal(int(i == j)) for j in range(3)] for i in range(3)]
    g[p][p] = g[q][q] = cosine
    g[p][q], g[q][p] = tangent * cosine, -tangent * cosine
    return g


def _transposed(a: Matrix) -> Matrix:
    return [list(column) for column in zip(*a, strict=True)]


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [[sum((row[k] * b[k][j] for k in range(3)), Decimal(0)) for j in range(3)] for row in a]


def _vector(values: list[Decimal]) -> Vector:
    x, y, z = values
    return x, y, z


def _dot(a: Vector, b: list[Decimal]) -> Decimal:
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))
