"""The constants of motions in decimals, of any body and start: polhode, periods, and the mean precession.

In a `PrincipalFrame` the body rate is ω(u) = (A₁ cn u, ±A₂ sn u, A₃ dn u) with u = λt + u₀ and the sign that of the
frame's sense; cf. L. D. Landau, E. M. Lifshitz, Mechanics, 3rd ed., §37, eqs. 37.8-37.10. Departures: the order of the
moments is reversed below the separatrix instead of exchanging the axes in the formulas. Every constant is a product of
sums of terms of one sign, so that nothing cancels. The parameter is kept as its complement m1 = 1 − m, from an exact
determinant.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import lru_cache
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic.decimals import PI, Tensor, Vector, dot, root, working_precision
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.attitude import AttitudeConstants, Four, Three, attitude_map, world_rotation
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock, half_turn_rate
from lie_rigid_body.motion.closed_form.elliptic_integrals import carlson_rf, ellipk_complement, mean_ellippi
from lie_rigid_body.motion.closed_form.frame import (
    PHASE_DIGITS,
    PrincipalFrame,
    digits_for,
    is_steady,
    principal_axes,
    separatrix_determinant,
)
from lie_rigid_body.motion.closed_form.jacobi import ImaginaryTheta, PeriodicPrecession, RealTheta
from lie_rigid_body.motion.closed_form.states import BodyMotion, LargeModulus, SmallModulus, Steady
from lie_rigid_body.motion.motion import exact_inertia

_INFINITY: Final = Decimal("Infinity")


@short_dataclass
class Polhode:
    """The closed path of the body rate in the body, and the motion along it.

    Attributes
    ----------
    amplitudes : tuple of 3 Decimal
        A₁, A₂, A₃, rad/s, all positive.
    momentum : Decimal
        l = |Mω|, kg m²/s.
    m, m1 : Decimal
        Parameter of the elliptic functions and its complement: m = 0 for symmetric tops, m1 = 0 on the separatrix.
    argument_rate : Decimal
        λ = du/dt, 1/s.
    negated_characteristic : Decimal
        −ν ≥ 0, with 1 + (−ν) sn²u proportional to 1 − n₃², for n the unit momentum in the body.
    ratio : Decimal
        −ν/m > 0, finite where m = 0.
    start : Decimal
        u₀, in [−K, K]. To ``PHASE_DIGITS``.
    """

    amplitudes: Vector
    momentum: Decimal
    m: Decimal
    m1: Decimal
    argument_rate: Decimal
    negated_characteristic: Decimal
    ratio: Decimal
    start: Decimal

    @property
    def is_far(self) -> bool:
        """Whether m ≤ ½: far from the separatrix."""
        return 2 * self.m1 >= 1

    @classmethod
    def of(cls, frame: PrincipalFrame, determinant: Decimal) -> Polhode:
        """The polhode of a frame, from the `separatrix_determinant` of the same start."""
        j1, j2, j3 = frame.moments
        w1, w2, w3 = frame.rate
        d21 = abs(j2 - j1)
        d31 = abs(j3 - j1)
        d32 = abs(j3 - j2)
        # |l² − 2HJ₁|, |l² − 2HJ₃| and, from the exact determinant, |l² − 2HJ₂|
        c1 = j2 * d21 * w2 * w2 + j3 * d31 * w3 * w3
        c3 = j1 * d31 * w1 * w1 + j2 * d32 * w2 * w2
        c2 = abs(determinant) / (c1 * c3)
        amplitudes = (root(c3 / (j1 * d31)), root(c3 / (j2 * d32)), root(c1 / (j3 * d31)))
        cn = w1 / amplitudes[0]
        sn = frame.sense * w2 / amplitudes[1]
        dn = w3 / amplitudes[2]
        return cls(
            amplitudes=amplitudes,
            momentum=root((j1 * w1) ** 2 + (j2 * w2) ** 2 + (j3 * w3) ** 2),
            m=d21 * c3 / (d32 * c1),
            m1=d31 * c2 / (d32 * c1),
            argument_rate=root(d32 * c1 / (j1 * j2 * j3)),
            negated_characteristic=j3 * d21 / (j1 * d32),
            ratio=j3 * c1 / (j1 * c3),
            start=_inverse_sn(sn, cn, dn),
        )


def _inverse_sn(sn: Decimal, cn: Decimal, dn: Decimal) -> Decimal:
    """The u in [−K, K] of these elliptic functions (DLMF 19.25.31)."""
    with working_precision(PHASE_DIGITS):
        return sn * carlson_rf(cn * cn, dn * dn, Decimal(1))


def frame_and_polhode(inertia: Tensor, body_rate: Sequence[float]) -> tuple[PrincipalFrame, Polhode]:
    """The principal frame and the polhode of a motion that is not steady.

    Parameters
    ----------
    inertia : 3 rows of 3
        kg m², body frame.
    body_rate : 3 numbers
        The initial ω, rad/s, body frame.
    """
    determinant = separatrix_determinant(inertia, body_rate)
    x, y, z = (Decimal(component) for component in body_rate)
    principal = principal_axes(inertia, digits_for(inertia))
    frame = PrincipalFrame.of(principal, (x, y, z), about_largest=determinant >= 0)
    return frame, Polhode.of(frame, determinant)


@short_dataclass
class Periods:
    """Quarter periods of a polhode's elliptic functions, and the places of a pole, in the unit of u.

    Attributes
    ----------
    real : Decimal
        K; infinite on the separatrix.
    pole : Decimal
        a in (0, K′] with sc(a|m1) = 1/√−ν. At u = ±ia, 1 − ν sn²u has its zeros, where the unit momentum n has n₃ = ±1.
        Infinite for a symmetric top. To ``PHASE_DIGITS``.
    copole : Decimal
        K′ − a, formed without the difference; sc(K′ − a|m1) = √(−ν/m). To ``PHASE_DIGITS``.
    """

    real: Decimal
    pole: Decimal
    copole: Decimal

    @classmethod
    def of(cls, polhode: Polhode) -> Periods:
        """The periods of a polhode."""
        return cls(
            real=ellipk_complement(polhode.m1) if polhode.m1 else _INFINITY,
            pole=_inverse_sc(polhode.negated_characteristic, polhode.m),
            copole=_inverse_sc(1 / polhode.ratio, polhode.m),
        )

    @property
    def imaginary(self) -> Decimal:
        """K′ to ``PHASE_DIGITS``."""
        return self.pole + self.copole


def _inverse_sc(inverse_square: Decimal, m: Decimal) -> Decimal:
    """The u > 0 with 1/sc²(u|1 − m) as given, from R_F(cs², ds², ns²) (DLMF 19.25.31)."""
    if inverse_square == 0 and m == 0:
        return _INFINITY
    with working_precision(PHASE_DIGITS):
        return carlson_rf(inverse_square, inverse_square + m, inverse_square + 1)


def precession_rate(frame: PrincipalFrame, polhode: Polhode) -> Decimal:
    """Mean rate, rad/s, at which the third axis circles the momentum.

    Its angle obeys ψ_E′ = l/J₃ + l (J₃ − J₁)/(J₁J₃) / (1 − ν sn²u) (Landau, Lifshitz, Mechanics, eq. 37.15 rewritten).
    The mean of 1/(1 − ν sn²u), Π(ν)/K with ν ≤ 0, goes over to a characteristic N = (m − ν)/(1 − ν) in [m, 1)
    (M. Abramowitz, I. A. Stegun, eq. 17.7.15), where every term is positive.
    """
    j1, _, j3 = frame.moments
    swing = abs(j3 - j1) / (j1 * j3)
    share = 1 / (1 + polhode.ratio)
    third = mean_ellippi(polhode.m1 / (1 + polhode.negated_characteristic), polhode.m1) if polhode.m1 else Decimal(0)
    return polhode.momentum * (1 / j3 + frame.sense * swing * (share + (1 - share) * third))


def motion_of(body: RigidBody, start: State) -> BodyMotion:
    """The motion of a body from a start of one instant."""
    inertia = exact_inertia(body)
    rate = start.body_rate.tolist()
    x, y, z, w = start.attitude_xyzw.tolist()
    with working_precision(digits_for(inertia)):
        if is_steady(inertia, rate):
            return _steady(rate, (x, y, z, w))
        return _general(*constants_of(inertia, tuple(rate)), (x, y, z, w))


def _steady(body_rate: Sequence[float], attitude: Four) -> Steady:
    rate = [Decimal(component) for component in body_rate]
    speed = dot(rate, rate).sqrt()
    a, b, c = (float(component / (speed or 1)) for component in rate)
    across = quaternion.product(attitude, (a, b, c, 0.0))
    return Steady(half_turn_rate(speed), attitude, across, tuple(body_rate))


Constants: TypeAlias = tuple[PrincipalFrame, Polhode, Periods, Decimal]
"""Frame, polhode and periods of a motion that is not steady, and the mean rate of ψ, rad/s."""


@lru_cache(maxsize=4)
def constants_of(inertia: Tensor, body_rate: Three) -> Constants:
    """The constants of a motion that is not steady, in the precision in force; those of the last ones are kept."""
    frame, polhode = frame_and_polhode(inertia, body_rate)
    periods = Periods.of(polhode)
    # of ψ: the precession angle of the third axis less the azimuth of n, which makes half a turn for every 2K of u
    azimuth_rate = frame.sense * PI * polhode.argument_rate / (2 * periods.real)
    return frame, polhode, periods, precession_rate(frame, polhode) - azimuth_rate


def _general(
    frame: PrincipalFrame, polhode: Polhode, periods: Periods, mean_rate: Decimal, attitude: Four
) -> BodyMotion:
    """The motion from its constants and the attitude at the start."""
    theta: Any = theta_functions(polhode, periods, FLOATS)
    if polhode.is_far:
        # ζ = πu/2K
        scale = PI / (2 * periods.real)
        period = 2 * PI
    else:
        # χ = πu/2K′
        scale = PI / (2 * ellipk_complement(polhode.m))
        period = 4 * scale * periods.real
    rate = scale * polhode.argument_rate
    start = scale * polhode.start
    clock: Any = PhaseClock.of(rate, start, period) if polhode.m1 else EndlessClock.of(rate, start)
    turning = half_turn_rate(mean_rate)
    placed = _attitude(frame, polhode, theta.periodic_precession(clock.initial_phase()), attitude)
    if polhode.is_far:
        return SmallModulus(clock, theta, turning, placed)
    return LargeModulus(clock, theta, turning, frame.sense * theta.drift / (4.0 * math.pi), placed)


class Arithmetic(NamedTuple):
    """The arithmetic of a kind of number: how to make one of a decimal, π, and functions."""

    of: Callable[[Decimal], Any]
    pi: Any
    exp: Callable[[Any], Any]
    expm1: Callable[[Any], Any]
    sine: Callable[[Any], Any]


FLOATS: Final = Arithmetic(float, math.pi, math.exp, math.expm1, math.sin)
"""Doubles, of which the samples are made."""


def theta_functions(polhode: Polhode, periods: Periods, arithmetic: Arithmetic) -> RealTheta | ImaginaryTheta:
    """The elliptic functions of a polhode, whose constants are numbers of some arithmetic."""
    places = periods.pole, periods.copole
    if polhode.is_far:
        exponents = [-arithmetic.pi * arithmetic.of(place / periods.real) for place in places]
        decay, codecay = map(arithmetic.exp, exponents)
        return RealTheta.of(decay * codecay, decay, codecay, -arithmetic.expm1(exponents[0]))
    sine, cosine = (arithmetic.sine(arithmetic.of(PI * place / (2 * periods.imaginary))) for place in places)
    quarter = arithmetic.of(PI * periods.real / (2 * periods.imaginary))
    return ImaginaryTheta.of(
        arithmetic.exp(-2 * quarter), quarter, sine, cosine, arithmetic.of(periods.pole / periods.real)
    )


def _attitude(
    frame: PrincipalFrame, polhode: Polhode, precession: PeriodicPrecession, attitude: Four
) -> AttitudeConstants:
    """The numbers from which phases give the attitude, which begins as it is given."""
    amplitudes = unit_momentum(frame, polhode, polhode.amplitudes)
    initial = unit_momentum(frame, polhode, frame.rate)
    rows = [_rounded(row) for row in zip(*frame.axes, strict=True)]
    x, y, z, w = quaternion.conjugate(quaternion.from_matrix(np.array(rows))).tolist()
    world = world_rotation(
        precession,
        _rounded(initial),
        _proportional(initial[0], frame.sense * initial[1]),
        frame.sense,
        (x, y, z, w),
        attitude,
    )
    r1, r2, r3 = _rounded(polhode.amplitudes, frame.sense)
    p, q, r = ((a * r1, b * r2, c * r3) for a, b, c in rows)
    return AttitudeConstants(
        sense=float(frame.sense),
        transverse=_proportional(amplitudes[0], amplitudes[1]),
        directions=_rounded(amplitudes, frame.sense),
        attitude=attitude_map(world, (x, y, z, w)),
        rates=(p, q, r),
    )


def unit_momentum(frame: PrincipalFrame, polhode: Polhode, rate: Vector) -> list[Decimal]:
    """The unit momentum of a rate in the principal frame."""
    return [j * w / polhode.momentum for j, w in zip(frame.moments, rate, strict=True)]


def _rounded(components: Sequence[Decimal], sense: int = 1) -> Three:
    """Each component rounded once, the second with the sign of the sense."""
    return float(components[0]), float(sense * components[1]), float(components[2])


def _proportional(x: Decimal, y: Decimal) -> tuple[float, float]:
    widest = max(abs(x), abs(y))
    return float(x / widest), float(y / widest)
