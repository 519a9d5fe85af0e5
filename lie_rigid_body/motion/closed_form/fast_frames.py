"""Principal frames of regular motions, in double-double: of one motion in floats, of many in arrays.

A motion is regular if the fast tier gets its constants right. Sizes are such that no product overflows or underflows,
and it keeps away from the separatrix, 1 − m ≥ 2⁻¹⁰. Then nothing cancels but l² − 2HJ₂, by a factor of at most 2¹¹, and
every iteration takes a number of steps that is known beforehand. With products of inertia the moments must also differ,
and the body rate must not be along a principal axis by all but a little. Each motion is judged by its own numbers, in
plain doubles, so that it is judged the same alone and in any ensemble.

The decomposition of an inertia with products, in doubles, is refined once: its error ε becomes ε² (T. Ogita,
K. Aishima, "Iterative refinement for symmetric eigenvalue decomposition", Japan J. Indust. Appl. Math. 35 (2018) 1007,
algorithm 1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, TypeAlias

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
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, magnitude, sign
from lie_rigid_body.lie.quaternion import shepperd_matrix

Condition: TypeAlias = Any
"""A bool of one motion, or an array of them."""

Matrix: TypeAlias = tuple[Triple, Triple, Triple]
Vector: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble]

_NEAREST: Final = 2.0**-10
"""Smallest 1 − m of a regular motion."""

_MOMENT_RATIO: Final = 1e3
"""Largest ratio of the moments of a regular motion."""

_LEAST_MOMENT, _GREATEST_MOMENT = 1e-20, 1e20
_LEAST_RATE, _GREATEST_RATE = 1e-20, 1e5

_SUM_RATIOS: Final = (2.5, 8.0, 30.0, 120.0)
"""Thresholds of (1 − ν)/√m1: above each, the sum in the mean precession takes one more step."""
_GREATEST_RATIO: Final = 400.0

_MOMENT_GAP: Final = 2.0**-10
"""Smallest difference of two moments, relative to the largest, with products of inertia: the refinement divides by
it."""

_LEAST_TILT: Final = 1e-8
"""Smallest angle, rad, between ω and a principal axis, with products of inertia: the transverse components keep their
digits."""


Classification: TypeAlias = tuple[Condition, Condition, Any]
"""Whether a motion is regular, and what its computation branches on: whether m > ½, and the number of steps of the sum
in the mean precession."""


class FastFrame(NamedTuple):
    """A `PrincipalFrame` in double-double.

    Attributes
    ----------
    moments, rate : 3 DoubleDouble
    sense : number
    axes : 3 rows of 3 numbers
        Columns are the frame's axes in the body frame.
    frame_xyzw : 4 numbers
        conj(F) of `GeneralMotion`.
    """

    moments: Vector
    rate: Vector
    sense: Number
    axes: Matrix
    frame_xyzw: Quadruple


def _about_largest(j: Triple, w: Triple) -> Condition:
    """Whether the momentum circulates about the axis of the largest moment, from ascending moments; to round-off."""
    # l² > 2HJ₂
    return j[2] * (j[2] - j[1]) * (w[2] * w[2]) > j[0] * (j[1] - j[0]) * (w[0] * w[0])


def _classified(j: Triple, w: Triple, sense: Number) -> Classification:
    """The class of a motion from the moments, the sizes of the initial ω and the sense of its `PrincipalFrame`."""
    (j1, j2, j3), (w1, w2, w3) = j, w
    d21, d31, d32 = sense * (j2 - j1), sense * (j3 - j1), sense * (j3 - j2)
    q1, q2, q3 = j1 * (w1 * w1), j2 * (w2 * w2), j3 * (w3 * w3)
    c1, c2, c3 = d21 * q2 + d31 * q3, d32 * q3 - d21 * q1, d31 * q1 + d32 * q2
    # m1 is their quotient
    whole, complement = d32 * c1, d31 * c2
    # 1 − ν is their quotient
    one, swollen = j1 * d32, j1 * d32 + j3 * d21
    # squares of (1 − ν)/√m1 and of 1, times the same
    spread, unit = swollen * swollen * whole, one * one * complement
    steps = 3 + sum(spread > ratio * ratio * unit for ratio in _SUM_RATIOS)
    regular = (c3 > 0.0) & (whole > 0.0) & (complement >= _NEAREST * whole)
    regular = regular & (spread < _GREATEST_RATIO**2 * unit) & _is_of_regular_size(j, w)
    return regular, 2.0 * complement < whole, steps


def _is_of_regular_size(j: Triple, w: Triple) -> Condition:
    j1, _, j3 = j
    fits: Condition = (j1 <= _MOMENT_RATIO * j3) & (j3 <= _MOMENT_RATIO * j1)
    for moment in j:
        fits = fits & (moment >= _LEAST_MOMENT) & (moment <= _GREATEST_MOMENT)
    for rate in w:
        fits = fits & ((rate >= _LEAST_RATE) | (rate == 0.0)) & (rate <= _GREATEST_RATE)
    return fits


class DiagonalBody(NamedTuple):
    """A body of diagonal inertia and its rate, in the order of the frame's axes: their numbers are exact.

    Attributes
    ----------
    order : 3 numbers
        Indices of these axes in the body frame.
    moments, rate : 3 numbers
    sense : number
        Sense of the frame, ±1.
    """

    order: Triple
    moments: Triple
    rate: Triple
    sense: Number

    @classmethod
    def of(cls, diagonal: Triple, rate: Triple) -> DiagonalBody:
        """The body of one motion, or of many, from components in the body frame."""
        axes: list[tuple[Number, ...]] = [(diagonal[i], 0.0 * rate[i] + i, rate[i]) for i in range(3)]
        for i in (0, 1, 0):
            falls = axes[i + 1][0] < axes[i][0]
            axes[i], axes[i + 1] = choose(falls, axes[i + 1], axes[i]), choose(falls, axes[i], axes[i + 1])
        (j1, _, w1), (j2, _, _), (j3, _, w3) = axes
        ascends = _about_largest((j1, j2, j3), (magnitude(w1), 0.0, magnitude(w3)))
        axes[0], axes[2] = choose(ascends, axes[0], axes[2]), choose(ascends, axes[2], axes[0])
        moments, order, rates = zip(*axes, strict=True)
        return cls(order, moments, rates, choose(ascends, ONE, (-1.0, 0.0))[0])

    def classified(self) -> Classification:
        """The class of the motion, or of each."""
        w1, w2, w3 = self.rate
        return _classified(self.moments, (magnitude(w1), magnitude(w2), magnitude(w3)), self.sense)

    def frame(self) -> FastFrame:
        """The frame of the motion, or of each."""
        (i, j, k), (w1, w2, w3) = self.order, self.rate
        first, third = sign(w1), sign(w3)
        # right-handed: the order is cyclic where this product is 2, and not where it is −2
        second = first * third * (0.5 * (j - i) * (k - j) * (k - i))
        x, y, z = ((first * (i == row) + 0.0, second * (j == row) + 0.0, third * (k == row) + 0.0) for row in range(3))
        rate = _exactly((magnitude(w1), second * w2, magnitude(w3)))
        return FastFrame(_exactly(self.moments), rate, self.sense, (x, y, z), _conjugate_quaternion((x, y, z)))


class CoupledBody(NamedTuple):
    """A body with products of inertia and its rate, with the decomposition of its inertia in doubles.

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
        """The sense of the frame."""
        return choose(_about_largest(self.moments, self._sizes()), ONE, (-1.0, 0.0))[0]

    def classified(self) -> Classification:
        """The class of the motion, or of each."""
        (least, middle, most), (a, b, c) = self.moments, self._sizes()
        sense = self.sense()
        up = sense > 0.0
        (j1, j3), (w1, w3) = choose(up, (least, most), (most, least)), choose(up, (a, c), (c, a))
        regular, hyperbolic, steps = _classified((j1, middle, j3), (w1, b, w3), sense)
        regular = regular & (middle - least >= _MOMENT_GAP * most) & (most - middle >= _MOMENT_GAP * most)
        return regular & (w1 * w1 + b * b >= _LEAST_TILT**2 * (w3 * w3)), hyperbolic, steps

    def frame(self) -> FastFrame:
        """The frame of the motion, or of each, to 30 digits."""
        moments, axes = self._refined()
        sense, rate = self.sense(), _exactly(self.rate)
        up = sense > 0.0
        w1, w2, w3 = _ordered(up, [_dot(axis, rate) for axis in axes])
        # ω₁ ≥ 0 and ω₃ > 0, and a right-handed frame
        s1, s3 = (choose(w[0] < 0.0, (-1.0, 0.0), ONE)[0] for w in (w1, w3))
        s2 = sense * s1 * s3
        entries = (_ordered(up, components) for components in zip(*axes, strict=True))
        x, y, z = ((s1 * a[0], s2 * b[0], s3 * c[0]) for a, b, c in entries)
        return FastFrame(
            moments=_ordered(up, moments),
            rate=(scaled(w1, s1), scaled(w2, s2), scaled(w3, s3)),
            sense=sense,
            axes=(x, y, z),
            frame_xyzw=_conjugate_quaternion((x, y, z)),
        )

    def _sizes(self) -> Triple:
        """|ω₁|, |ω₂| and |ω₃| along the principal axes."""
        x, y, z = self.rate
        a, b, c = (magnitude(axis[0] * x + axis[1] * y + axis[2] * z) for axis in self.axes)
        return a, b, c

    def _refined(self) -> tuple[Vector, list[Vector]]:
        """Moments and axes in double-double: with X the axes in doubles, S = XᵀMX and R = 1 − XᵀX.

        The moments are Sᵢᵢ/(1 − Rᵢᵢ), and X goes to X + XE with Eᵢᵢ = ½Rᵢᵢ and
        Eᵢⱼ = (Sᵢⱼ + Jⱼ Rᵢⱼ)/(Jⱼ − Jᵢ) (Ogita and Aishima, algorithm 1).
        """
        rows, axes = [_exactly(row) for row in self.inertia], [_exactly(axis) for axis in self.axes]
        images = [[_dot(row, axis) for row in rows] for axis in axes]
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
            x, y, z = (a * shares[0] + b * shares[1] + c * shares[2] for a, b, c in zip(*self.axes, strict=True))
            p, q, r = axes[j]
            refined.append((add(p, (x, 0.0)), add(q, (y, 0.0)), add(r, (z, 0.0))))
        return moments, refined


def _ordered(up: Condition, ascending: Sequence[DoubleDouble]) -> Vector:
    """What belongs to ascending moments in the order of the frame's axes, which is the same where its sense is 1."""
    first, second, third = ascending
    return choose(up, first, third), second, choose(up, third, first)


def _exactly(vector: Triple) -> Vector:
    x, y, z = vector
    return (x, 0.0), (y, 0.0), (z, 0.0)


def _dot(a: Sequence[DoubleDouble], b: Sequence[DoubleDouble]) -> DoubleDouble:
    return add(add(multiply(a[0], b[0]), multiply(a[1], b[1])), multiply(a[2], b[2]))


def _conjugate_quaternion(rows: Matrix) -> Quadruple:
    """conj(F), one after the other where there are many."""
    if isinstance(rows[0][0], float):
        return _quaternion_of_one(rows)
    x, y, z, w = np.array([_quaternion_of_one(each) for each in np.moveaxis(np.array(rows), -1, 0).tolist()]).T
    return x, y, z, w


def _quaternion_of_one(matrix: Any) -> tuple[float, float, float, float]:
    """The inverse of a rotation matrix as a quaternion; see `lie.quaternion.from_matrix`."""
    rows = shepperd_matrix(matrix)
    x, y, z, w = rows[max(range(4), key=lambda i: rows[i][i])]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return -x / length, -y / length, -z / length, w / length
