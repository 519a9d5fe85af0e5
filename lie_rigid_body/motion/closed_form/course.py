"""The state of a general motion from its phases: the attitude about the momentum, and the body rate.

The attitude is W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗ conj(F), as `GeneralMotion` says, with b(n) proportional to
(−n₂, n₁, 0, 1 + n₃), and ψ/2 the sum of its mean growth and half of the libration less n's azimuth. Of this difference,
which stays within a quarter turn of 0, the sine and cosine S and C are known but for a factor; those of its half are
as S to C + √(S² + C²), and no arctangent is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, magnitude, sqrt
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.placement import multiply
from lie_rigid_body.motion.closed_form.samples import Sample
from lie_rigid_body.motion.closed_form.wave import Crest

_NEGLIGIBLE: Final = 1e-307


class Course(NamedTuple):
    """What a sample takes of a `GeneralMotion` beside its clocks and its wave.

    Attributes
    ----------
    sense : number
    slopes : 2 numbers
    directions : 3 numbers
    attitude : 4 columns of 4 numbers
        W ⊗ · ⊗ conj(F).
    rates : 3 rows of 3 numbers
        Those of the axes, times the amplitudes of the rate.
    """

    sense: Number
    slopes: tuple[Number, Number]
    directions: Triple
    attitude: tuple[Quadruple, Quadruple, Quadruple, Quadruple]
    rates: tuple[Triple, Triple, Triple]


def course_row(motion: GeneralMotion) -> list[Number]:
    """The numbers of a `Course` in a row, of one motion or of many."""
    x, y, z, w = motion.world
    # W times i, j, k and 1
    turned_world = ((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z), (x, y, z, w))
    a, b, c, d = (multiply(column, motion.frame) for column in turned_world)
    r1, r2, r3 = motion.rate_amplitudes
    p, q, r = ((x * r1, y * r2, z * r3) for x, y, z in motion.axes)
    return [motion.sense, *motion.slopes, *motion.direction_amplitudes, *a, *b, *c, *d, *p, *q, *r]


@kernel
def course(row: Sequence[Number], k: int) -> Course:
    """The course that stands in a row from a place on."""
    first, second = (quadruple(row, k + 6), quadruple(row, k + 10)), (quadruple(row, k + 14), quadruple(row, k + 18))
    rates = (triple(row, k + 22), triple(row, k + 25), triple(row, k + 28))
    attitude = (first[0], first[1], second[0], second[1])
    return Course(row[k], (row[k + 1], row[k + 2]), triple(row, k + 3), attitude, rates)


@kernel
def triple(row: Sequence[Number], k: int) -> Triple:
    """The three numbers in a row from a place on."""
    return row[k], row[k + 1], row[k + 2]


@kernel
def quadruple(row: Sequence[Number], k: int) -> Quadruple:
    """The four numbers in a row from a place on."""
    return row[k], row[k + 1], row[k + 2], row[k + 3]


@kernel
def state(course: Course, crest: Crest, half_turn: DoubleDouble) -> Sample:
    """The state at a crest of the wave, from half of ψ without the libration that the crest tells, in turns."""
    s, c = half_turn_with_libration(course, crest, half_turn)
    n1, n2, n3 = course.directions
    n1, n2, upright = n1 * crest.cn, n2 * crest.sn, 1.0 + n3 * crest.dn
    x, y, z, w = turned(course.attitude, (c * n2 + s * n1, s * n2 - c * n1, s * upright, c * upright))
    size = 1.0 / sqrt((x * x + y * y) + (z * z + w * w))
    r1, r2, r3 = course.rates
    f = (crest.cn, crest.sn, crest.dn)
    return x * size, y * size, z * size, w * size, dot(r1, f), dot(r2, f), dot(r3, f)


@kernel
def half_turn_with_libration(course: Course, crest: Crest, half_turn: DoubleDouble) -> tuple[Number, Number]:
    """Proportional to the sine and the cosine of ψ/2."""
    x, y = course.slopes[0] * crest.cn, course.slopes[1] * crest.sn
    across = crest.sine * x - crest.cosine * y
    along = crest.cosine * x + crest.sine * y
    # positive, but its square may be too small for a double, or even itself
    along = along + _NEGLIGIBLE
    scale = 1.0 / (along + magnitude(across))
    across, along = across * scale, along * scale
    s, c = course.sense * across, along + sqrt(along * along + across * across)
    sine, cosine = sine_cosine(half_turn)
    return sine * c + cosine * s, cosine * c - sine * s


@kernel
def turned(columns: tuple[Quadruple, Quadruple, Quadruple, Quadruple], p: Quadruple) -> Quadruple:
    """A matrix times a quadruple."""
    a, b, c, d = columns
    x, y, z, w = p
    return (
        (a[0] * x + b[0] * y) + (c[0] * z + d[0] * w),
        (a[1] * x + b[1] * y) + (c[1] * z + d[1] * w),
        (a[2] * x + b[2] * y) + (c[2] * z + d[2] * w),
        (a[3] * x + b[3] * y) + (c[3] * z + d[3] * w),
    )


@kernel
def dot(a: Triple, b: Triple) -> Number:
    """The sum of the products."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
