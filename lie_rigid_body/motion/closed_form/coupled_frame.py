"""Principal frames of ordinary motions whose inertia has products: of one in floats, of many in arrays.

The double-precision decomposition is refined once: what it is wrong by, ε, becomes ε² (T. Ogita, K. Aishima, "Iterative
refinement for symmetric eigenvalue decomposition", Japan J. Indust. Appl. Math. 35 (2018) 1007, algorithm 1).
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple, cast

import numpy as np

from lie_rigid_body.arithmetic.double_double import (
    ONE,
    ZERO,
    DoubleDouble,
    add,
    choose,
    divide,
    multiply,
    scaled,
    subtract,
)
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, magnitude
from lie_rigid_body.motion.closed_form.ordinary import Shape, Verdict, about_largest, judged
from lie_rigid_body.motion.closed_form.ordinary_motion import OrdinaryFrame

Matrix = tuple[Triple, Triple, Triple]
Vector = tuple[DoubleDouble, DoubleDouble, DoubleDouble]

APART: Final = 2.0**-10
"""The least difference of two moments, of the largest: the refinement divides by it."""

_LEAST_TILT: Final = 1e-8
"""Between the body rate and a principal axis, so that its transverse components keep their digits."""


class Coupled(NamedTuple):
    """A body and its rate, with the decomposition of its inertia in doubles.

    Attributes
    ----------
    inertia : 3 rows of 3 numbers
    moments : 3 numbers
        Ascending.
    axes : 3 columns of 3 numbers
        Right-handed.
    rate : 3 numbers
    """

    inertia: Matrix
    moments: Triple
    axes: Matrix
    rate: Triple

    def sense(self) -> Number:
        """That of the frame."""
        return choose(about_largest(self.moments, self._sizes()), ONE, (-1.0, 0.0))[0]

    def judged(self) -> tuple[Verdict, Verdict, Verdict]:
        """See `ordinary.judged`."""
        (least, middle, most), (a, b, c) = self.moments, self._sizes()
        sense = self.sense()
        up = sense > 0.0
        (j1, j3), (w1, w3) = choose(up, (least, most), (most, least)), choose(up, (a, c), (c, a))
        fits, hyperbolic, steps = judged((j1, middle, j3), (w1, b, w3), sense)
        fits = fits & (middle - least >= APART * most) & (most - middle >= APART * most)
        return fits & (w1 * w1 + b * b >= _LEAST_TILT**2 * (w3 * w3)), hyperbolic, steps

    def frame(self) -> OrdinaryFrame:
        """The frame, to 30 digits."""
        moments, axes = self._refined()
        rate = _exactly(self.rate)
        components = [_dot(axis, rate) for axis in axes]
        sense = self.sense()
        up = sense > 0.0
        first, third = choose(up, components[0], components[2]), choose(up, components[2], components[0])
        s1, s3 = (choose(w[0] < 0.0, (-1.0, 0.0), ONE)[0] for w in (first, third))
        s2 = sense * s1 * s3
        columns = [
            [sign * choose(up, p, q)[0] for p, q in zip(*pair, strict=True)]
            for sign, pair in ((s1, (axes[0], axes[2])), (s2, (axes[1], axes[1])), (s3, (axes[2], axes[0])))
        ]
        rows = tuple((a, b, c) for a, b, c in zip(*columns, strict=True))
        return OrdinaryFrame(
            moments=(choose(up, moments[0], moments[2]), moments[1], choose(up, moments[2], moments[0])),
            rate=(scaled(first, s1), scaled(components[1], s2), scaled(third, s3)),
            sense=sense,
            axes=(rows[0], rows[1], rows[2]),
            frame=_conjugate_quaternion((rows[0], rows[1], rows[2])),
        )

    def _sizes(self) -> Triple:
        x, y, z = self.rate
        a, b, c = (magnitude(axis[0] * x + axis[1] * y + axis[2] * z) for axis in self.axes)
        return a, b, c

    def _refined(self) -> tuple[Vector, list[Vector]]:
        """Moments and axes."""
        rows, axes = [_exactly(row) for row in self.inertia], [_exactly(axis) for axis in self.axes]
        images = [_exact_image(rows, axis) for axis in axes]
        entries: dict[tuple[int, int], DoubleDouble] = {}
        defects: dict[tuple[int, int], DoubleDouble] = {}
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
            entries[i, j] = entries[j, i] = _dot(axes[i], images[j])
            defects[i, j] = defects[j, i] = subtract(ONE if i == j else ZERO, _dot(axes[i], axes[j]))
        m0, m1, m2 = (divide(entries[i, i], subtract(ONE, defects[i, i])) for i in range(3))
        moments = (m0, m1, m2)
        refined = []
        for j in range(3):
            shares = [
                0.5 * defects[j, j][0]
                if i == j
                else (entries[i, j][0] + moments[j][0] * defects[i, j][0]) / (moments[j][0] - moments[i][0])
                for i in range(3)
            ]
            x, y, z = (_combined([axis[k] for axis in self.axes], shares) for k in range(3))
            p, q, r = axes[j]
            refined.append((add(p, (x, 0.0)), add(q, (y, 0.0)), add(r, (z, 0.0))))
        return moments, refined


def _combined(components: list[Number], shares: list[Number]) -> Number:
    return components[0] * shares[0] + components[1] * shares[1] + components[2] * shares[2]


def _exactly(vector: Triple) -> Vector:
    x, y, z = vector
    return (x, 0.0), (y, 0.0), (z, 0.0)


def _exact_image(rows: list[Vector], vector: Vector) -> Vector:
    x, y, z = (_dot(row, vector) for row in rows)
    return x, y, z


def _dot(a: Vector, b: Vector) -> DoubleDouble:
    return add(add(multiply(a[0], b[0]), multiply(a[1], b[1])), multiply(a[2], b[2]))


def _conjugate_quaternion(rows: Matrix) -> Quadruple:
    """conj(F), one after the other where there are many."""
    entries = [entry for row in rows for entry in row]
    if isinstance(entries[0], float):
        return _quaternion_of_one(*cast(list[float], entries))
    x, y, z, w = np.array([_quaternion_of_one(*row) for row in np.stack(entries, axis=-1).tolist()]).T
    return x, y, z, w


def _quaternion_of_one(
    xx: float, xy: float, xz: float, yx: float, yy: float, yz: float, zx: float, zy: float, zz: float
) -> tuple[float, float, float, float]:
    """The inverse of a rotation matrix as a quaternion; see `lie.quaternion.from_matrix`."""
    rows = (
        (1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz),
        (xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx),
        (xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy),
        (zy - yz, xz - zx, yx - xy, 1.0 + xx + yy + zz),
    )
    x, y, z, w = max(enumerate(rows), key=lambda numbered: numbered[1][numbered[0]])[1]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return -x / length, -y / length, -z / length, w / length


def one_coupled(
    inertia: list[list[float]], moments: list[float], axes: list[list[float]], rate: list[float]
) -> tuple[OrdinaryFrame, Shape] | None:
    """The frame and the shape of one motion, or None if it is not ordinary."""
    body = coupled(inertia, moments, axes, rate)
    fits, hyperbolic, steps = body.judged()
    return (body.frame(), Shape(hyperbolic, steps)) if fits else None


def coupled(inertia: Any, moments: Any, axes: Any, rate: Any) -> Coupled:
    """From nests of numbers with the indices first; the columns of ``axes`` are the axes."""
    first, second, third = (tuple(row) for row in inertia)
    a, b, c = zip(*axes, strict=True)
    return Coupled((first, second, third), tuple(moments), (a, b, c), tuple(rate))
