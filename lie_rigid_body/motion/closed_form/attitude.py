"""The numbers that a motion is given by, and the attitude and body rate of a general one from its phases.

The attitude is W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗ conj(F), as `GeneralMotion` says, with b(n) proportional to (−n₂, n₁, 0, 1
+ n₃). ψ is the precession angle of the third axis about the momentum less the azimuth of n about that axis. So ψ = Ωt ±
(Θ − φ) with its mean rate Ω, the libration Θ and the azimuth φ of (N₁ cn u, N₂ sn u). Θ and φ lie in the same quadrant,
so their difference stays within a quarter turn of 0. Its sine and cosine are known but for a factor, S and C; those of
its half are as S to C + √(S² + C²), and no arctangent is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, each, magnitude, quadruple, sqrt, triple
from lie_rigid_body.compilation import kernel
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock
from lie_rigid_body.motion.closed_form.jacobi import EllipticValues, Libration, Theta

# Numbers are floats of one motion, or arrays with an element for each of many.

Members: TypeAlias = NDArray[np.intp]
"""Indices of motions in an ensemble, shape (B,)."""

Sample: TypeAlias = tuple[Number, Number, Number, Number, Number, Number, Number]
"""A state: attitude x y z w and body rate, rad/s."""

_NEGLIGIBLE: Final = 1e-307
"""Added to C to avoid 0/0 where it underflows: without effect on any result."""


class GeneralMotion(NamedTuple):
    """A motion that is not steady, in its `PrincipalFrame`.

    With n = (N₁ cn u, ±N₂ sn u, N₃ dn u) the unit momentum in the frame, the attitude is W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗
    conj(F). F takes the frame to the body. b(n) is the shortest rotation from e₃ to n, smooth because n₃ > 0, and ψ its
    turn about the momentum, with ψ′ = (2H/l + ω₃)/(1 + n₃). W is fixed by the start.

    Attributes
    ----------
    phase_clock : PhaseClock or EndlessClock
        The phase of the theta functions, in proportion to u.
    half_turn_rate : DoubleDouble
        Rate of half of ψ's mean growth, turns/ns.
    theta : RealTheta or ImaginaryTheta
        The elliptic functions of u, and the libration of ψ.
    rate_amplitudes, direction_amplitudes : 3 numbers
        Amplitudes of ω, rad/s, and of n; the second ones with the sign of the sense.
    transverse : 2 numbers
        N₁ and N₂, in proportion.
    sense : number
        ±1: that of the frame.
    axes : 3 rows of 3 numbers
        Columns are the frame's axes in the body frame.
    world_xyzw : 4 numbers
        W.
    frame_xyzw : 4 numbers
        conj(F).
    """

    phase_clock: PhaseClock | EndlessClock
    half_turn_rate: DoubleDouble
    theta: Theta
    rate_amplitudes: Triple
    direction_amplitudes: Triple
    transverse: tuple[Number, Number]
    sense: Number
    axes: tuple[Triple, Triple, Triple]
    world_xyzw: Quadruple
    frame_xyzw: Quadruple


class SteadyMotion(NamedTuple):
    """A rotation about a fixed axis, q₀ exp(ωt): a spherical body, a spin about a principal axis, or rest.

    Attributes
    ----------
    half_turn_rate : DoubleDouble
        Rate of half the rotation angle, turns/ns; the attitude is a path on the double cover.
    attitude : 4 numbers
        q₀.
    across : 4 numbers
        q₀ ⊗ a, where a is the unit vector along ω in the body frame, or 0 at rest.
    body_rate : 3 numbers
        ω, rad/s, body frame.
    """

    half_turn_rate: DoubleDouble
    attitude: Quadruple
    across: Quadruple
    body_rate: Triple


BodyMotion: TypeAlias = GeneralMotion | SteadyMotion


class AttitudeConstants(NamedTuple):
    """The numbers of a `GeneralMotion` that its samples take, besides clocks and elliptic functions.

    Attributes
    ----------
    sense : number
    transverse : 2 numbers
        N₁ and N₂, in proportion.
    directions : 3 numbers
        N₁, ±N₂, N₃.
    attitude : 4 columns of 4 numbers
        The matrix of p ↦ W ⊗ p ⊗ conj(F).
    rates : 3 rows of 3 numbers
        The frame's axes in the body frame times the amplitudes of the rate.
    """

    sense: Number
    transverse: tuple[Number, Number]
    directions: Triple
    attitude: tuple[Quadruple, Quadruple, Quadruple, Quadruple]
    rates: tuple[Triple, Triple, Triple]

    @classmethod
    def of(cls, motion: GeneralMotion) -> AttitudeConstants:
        """The constants of one motion, or of many."""
        x, y, z, w = motion.world_xyzw
        # W ⊗ i, W ⊗ j, W ⊗ k and W
        turned_world = ((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z), (x, y, z, w))
        a, b, c, d = (product(column, motion.frame_xyzw) for column in turned_world)
        r1, r2, r3 = motion.rate_amplitudes
        p, q, r = ((x * r1, y * r2, z * r3) for x, y, z in motion.axes)
        return cls(motion.sense, motion.transverse, motion.direction_amplitudes, (a, b, c, d), (p, q, r))


_SENSE, _TRANSVERSE, _DIRECTIONS, _ATTITUDE, _RATES = 0, 1, 3, 6, 22


@kernel
def attitude_constants(row: Sequence[Number], k: int) -> AttitudeConstants:
    """The constants that stand in a row from place k on."""
    attitude = (
        quadruple(row, k + _ATTITUDE),
        quadruple(row, k + _ATTITUDE + 4),
        quadruple(row, k + _ATTITUDE + 8),
        quadruple(row, k + _ATTITUDE + 12),
    )
    rates = (triple(row, k + _RATES), triple(row, k + _RATES + 3), triple(row, k + _RATES + 6))
    transverse = (row[k + _TRANSVERSE], row[k + _TRANSVERSE + 1])
    return AttitudeConstants(row[k + _SENSE], transverse, triple(row, k + _DIRECTIONS), attitude, rates)


@kernel
def sample(constants: AttitudeConstants, values: EllipticValues, half_turn: DoubleDouble) -> Sample:
    """The state from the elliptic functions and ½ψ without ½(Θ − φ), or its part that the values give, in turns."""
    s, c = half_turn_with_libration(constants, values, half_turn)
    # n₁, n₂ and 1 + n₃
    n1, n2, n3 = constants.directions
    n1, n2, upright = n1 * values.cn, n2 * values.sn, 1.0 + n3 * values.dn
    # exp(ψ e₃) ⊗ conj(b(n)), proportional to (0, 0, s, c) ⊗ (n₂, −n₁, 0, 1 + n₃), between W and conj(F)
    x, y, z, w = turned(constants.attitude, (c * n2 + s * n1, s * n2 - c * n1, s * upright, c * upright))
    size = 1.0 / sqrt((x * x + y * y) + (z * z + w * w))
    # ω = Σ axis · amplitude · (cn, sn, dn)
    r1, r2, r3 = constants.rates
    f = (values.cn, values.sn, values.dn)
    return x * size, y * size, z * size, w * size, dot(r1, f), dot(r2, f), dot(r3, f)


@kernel
def half_turn_with_libration(
    constants: AttitudeConstants, values: EllipticValues, half_turn: DoubleDouble
) -> tuple[Number, Number]:
    """The sine and the cosine of ½ψ, times a common positive factor."""
    # S = sin(Θ − φ) and C = cos(Θ − φ) from those of Θ and of φ, each in proportion
    x, y = constants.transverse[0] * values.cn, constants.transverse[1] * values.sn
    across = values.sine * x - values.cosine * y
    along = values.cosine * x + values.sine * y
    # positive, but its square may be too small for a double, or even itself
    along = along + _NEGLIGIBLE
    scale = 1.0 / (along + magnitude(across))
    across, along = across * scale, along * scale
    # tan ½x = S/(C + √(S² + C²))
    s, c = constants.sense * across, along + sqrt(along * along + across * across)
    # the sum of the two angles
    sine, cosine = sine_cosine(half_turn)
    return sine * c + cosine * s, cosine * c - sine * s


@kernel
def turned(columns: tuple[Quadruple, Quadruple, Quadruple, Quadruple], p: Quadruple) -> Quadruple:
    """A 4×4 matrix, given by its columns, times a quadruple."""
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
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def world_rotation(
    libration: Libration,
    direction: Triple,
    transverse: tuple[Number, Number],
    sense: Number,
    frame_xyzw: Quadruple,
    attitude_xyzw: Quadruple,
) -> Quadruple:
    """W of a `GeneralMotion`, for which it begins at an attitude.

    Parameters
    ----------
    libration : Libration
        Θ at the start.
    direction : 3 numbers
        n at the start, the unit momentum in the frame.
    transverse : 2 numbers
        n₁ and ±n₂, the sign that of the sense, in proportion: their azimuth is φ.
    sense : number
        ±1: that of the frame.
    frame_xyzw : 4 numbers
        conj(F).
    attitude_xyzw : 4 numbers
        At the start.
    """
    sine, cosine, drift = libration
    x, y = transverse
    # ψ = ±(Θ − φ), as its mean growth begins at 0
    half_turn = 0.5 * sense * (each(math.atan2, sine * x - cosine * y, cosine * x + sine * y) + drift)
    untilted = _turn_and_untilt(each(math.sin, half_turn), each(math.cos, half_turn), *direction)
    x, y, z, w = product(untilted, frame_xyzw)
    size = sqrt(x * x + y * y + z * z + w * w)
    return product(attitude_xyzw, (-x / size, -y / size, -z / size, w / size))


def _turn_and_untilt(s: Number, c: Number, n1: Number, n2: Number, n3: Number) -> Quadruple:
    """exp(ψ e₃) ⊗ conj(b(n)) from the sine and cosine of ½ψ."""
    scale = 1.0 / sqrt(2.0 + 2.0 * n3)
    upright = (1.0 + n3) * scale
    return (c * n2 + s * n1) * scale, (s * n2 - c * n1) * scale, s * upright, c * upright
