"""The constants of motions in decimals, of any body and start: polhode, periods, and the mean precession.

In a `PrincipalFrame` the body rate is ω(u) = (A₁ cn u, ±A₂ sn u, A₃ dn u) with u = λt + u₀ and the sign that of the
frame's sense; cf. L. D. Landau, E. M. Lifshitz, Mechanics, 3rd ed., §37, eqs. 37.8-37.10. Departures: the order of the
moments is reversed below the separatrix instead of exchanging the axes in the formulas. Every constant is a product of
sums of terms of one sign, so that nothing cancels. The parameter is kept as its complement m1 = 1 − m, from an exact
determinant.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.decimals import PI, Vector, dot, root, working_precision
from lie_rigid_body.arithmetic.numbers import Quadruple, Triple, quadruple, triple
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form.attitude import (
    BodyMotion,
    GeneralMotion,
    Members,
    SteadyMotion,
    world_rotation,
)
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock
from lie_rigid_body.motion.closed_form.decimal_frames import (
    PHASE_DIGITS,
    PrincipalAxes,
    PrincipalFrame,
    Tensor,
    digits_for,
    is_steady,
    principal_axes,
    separatrix_determinant,
)
from lie_rigid_body.motion.closed_form.elliptic_integrals import complete_first, mean_third, symmetric_first
from lie_rigid_body.motion.closed_form.jacobi import ImaginaryTheta, RealTheta, Theta
from lie_rigid_body.motion.motion import InitialConditions, alike

_INFINITY: Final = Decimal("Infinity")


@dataclass(frozen=True)
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
    speed : Decimal
        λ = du/dt, 1/s.
    characteristic : Decimal
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
    speed: Decimal
    characteristic: Decimal
    ratio: Decimal
    start: Decimal

    @classmethod
    def of(cls, frame: PrincipalFrame, determinant: Decimal) -> Polhode:
        """The polhode of a frame, from the `separatrix_determinant` of the same start."""
        (j1, j2, j3), (w1, w2, w3) = frame.moments, frame.rate
        d21, d31, d32 = abs(j2 - j1), abs(j3 - j1), abs(j3 - j2)
        # |l² − 2HJ₁|, |l² − 2HJ₃| and, from the exact determinant, |l² − 2HJ₂|
        c1 = j2 * d21 * w2 * w2 + j3 * d31 * w3 * w3
        c3 = j1 * d31 * w1 * w1 + j2 * d32 * w2 * w2
        c2 = abs(determinant) / (c1 * c3)
        amplitudes = (root(c3 / (j1 * d31)), root(c3 / (j2 * d32)), root(c1 / (j3 * d31)))
        cn, sn, dn = w1 / amplitudes[0], frame.sense * w2 / amplitudes[1], w3 / amplitudes[2]
        return cls(
            amplitudes=amplitudes,
            momentum=root((j1 * w1) ** 2 + (j2 * w2) ** 2 + (j3 * w3) ** 2),
            m=d21 * c3 / (d32 * c1),
            m1=d31 * c2 / (d32 * c1),
            speed=root(d32 * c1 / (j1 * j2 * j3)),
            characteristic=j3 * d21 / (j1 * d32),
            ratio=j3 * c1 / (j1 * c3),
            start=_inverse_sn(sn, cn, dn),
        )


def _inverse_sn(sn: Decimal, cn: Decimal, dn: Decimal) -> Decimal:
    """The u in [−K, K] of these elliptic functions (DLMF 19.25.31)."""
    with working_precision(PHASE_DIGITS):
        return sn * symmetric_first(cn * cn, dn * dn, Decimal(1))


def frame_and_polhode(
    principal: PrincipalAxes, inertia: Tensor, body_rate: Sequence[float]
) -> tuple[PrincipalFrame, Polhode]:
    """The principal frame and the polhode of a motion that is not steady, to the precision in force.

    Parameters
    ----------
    principal : PrincipalAxes
        Principal axes of the inertia.
    inertia : 3 rows of 3
        kg m², body frame.
    body_rate : 3 numbers
        The initial ω, rad/s, body frame.
    """
    determinant = separatrix_determinant(inertia, body_rate)
    x, y, z = (Decimal(component) for component in body_rate)
    frame = PrincipalFrame.of(principal, (x, y, z), about_largest=determinant >= 0)
    return frame, Polhode.of(frame, determinant)


@dataclass(frozen=True)
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
            real=complete_first(polhode.m1) if polhode.m1 else _INFINITY,
            pole=_inverse_sc(polhode.characteristic, polhode.m),
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
        return symmetric_first(inverse_square, inverse_square + m, inverse_square + 1)


def precession_rate(frame: PrincipalFrame, polhode: Polhode) -> Decimal:
    """Mean rate, rad/s, at which the third axis circles the momentum.

    Its angle obeys ψ_E′ = l/J₃ + l (J₃ − J₁)/(J₁J₃) / (1 − ν sn²u) (Landau, Lifshitz, Mechanics, eq. 37.15 rewritten).
    The mean of 1/(1 − ν sn²u), Π(ν)/K with ν ≤ 0, goes over to a characteristic N = (m − ν)/(1 − ν) in [m, 1)
    (M. Abramowitz, I. A. Stegun, eq. 17.7.15), where every term is positive.
    """
    j1, _, j3 = frame.moments
    swing = abs(j3 - j1) / (j1 * j3)
    share = 1 / (1 + polhode.ratio)
    third = mean_third(polhode.m1 / (1 + polhode.characteristic), polhode.m1) if polhode.m1 else Decimal(0)
    return polhode.momentum * (1 / j3 + frame.sense * swing * (share + (1 - share) * third))


def _mean_turn_rate(frame: PrincipalFrame, polhode: Polhode, periods: Periods) -> Decimal:
    """Mean of ψ′ of `GeneralMotion`, rad/s.

    ψ is the precession angle of the third axis less the azimuth of n, which makes half a turn for every 2K of u.
    """
    return precession_rate(frame, polhode) - frame.sense * PI * polhode.speed / (2 * periods.real)


def real_theta(periods: Periods) -> RealTheta:
    """The elliptic functions of a polhode's periods for m ≤ ½."""
    decay, codecay = (math.exp(-math.pi * float(x / periods.real)) for x in (periods.pole, periods.copole))
    return RealTheta.of(decay * codecay, decay, codecay, -math.expm1(-math.pi * float(periods.pole / periods.real)))


def imaginary_theta(periods: Periods) -> ImaginaryTheta:
    """The elliptic functions of a polhode's periods for m > ½."""
    quarter = float(PI * periods.real / (2 * periods.imaginary))
    beta, cobeta = (float(PI * x / (2 * periods.imaginary)) for x in (periods.pole, periods.copole))
    drift = 0.0 if periods.real == _INFINITY else float(periods.pole / periods.real)
    return ImaginaryTheta.of(math.exp(-2.0 * quarter), quarter, math.sin(beta), math.sin(cobeta), drift)


def _clock_and_theta(polhode: Polhode, periods: Periods) -> tuple[PhaseClock | EndlessClock, Theta]:
    """The theta functions whose nome is at most exp(−π), and the clock of their phase."""
    if 2 * polhode.m1 >= 1:
        # ζ = πu/2K
        scale = PI / (2 * periods.real)
        return PhaseClock.of(scale * polhode.speed, scale * polhode.start, 2 * PI), real_theta(periods)
    # χ = πu/2K′
    scale = PI / (2 * complete_first(polhode.m))
    rate, start = scale * polhode.speed, scale * polhode.start
    clock = EndlessClock.of(rate, start) if polhode.m1 == 0 else PhaseClock.of(rate, start, 4 * scale * periods.real)
    return clock, imaginary_theta(periods)


def general_motion(frame: PrincipalFrame, polhode: Polhode, attitude_xyzw: Sequence[float]) -> GeneralMotion:
    """The motion from its frame, its polhode and the attitude at the start."""
    periods, sense = Periods.of(polhode), float(frame.sense)
    clock, theta = _clock_and_theta(polhode, periods)
    amplitudes = _over(polhode.momentum, frame.moments, polhode.amplitudes)
    initial = _over(polhode.momentum, frame.moments, frame.rate)
    transverse = _proportional(initial[0], frame.sense * initial[1])
    libration = theta.libration(clock.initial_phase())
    axes, conjugate = _rows_and_quaternion(frame.axes)
    x, y, z, w = attitude_xyzw
    return GeneralMotion(
        phase_clock=clock,
        half_turn_rate=PhaseClock.of(_mean_turn_rate(frame, polhode, periods) / 2, Decimal(0), 2 * PI).rate,
        theta=theta,
        rate_amplitudes=_rounded(polhode.amplitudes, frame.sense),
        direction_amplitudes=_rounded(amplitudes, frame.sense),
        transverse=_proportional(amplitudes[0], amplitudes[1]),
        sense=sense,
        axes=axes,
        world_xyzw=world_rotation(libration, _rounded(initial), transverse, sense, conjugate, (x, y, z, w)),
        frame_xyzw=conjugate,
    )


def _over(momentum: Decimal, moments: Vector, rate: Vector) -> list[Decimal]:
    """The unit momentum of a rate in the principal frame."""
    return [j * w / momentum for j, w in zip(moments, rate, strict=True)]


def _rounded(components: Sequence[Decimal], sense: int = 1) -> Triple:
    """Each component rounded once, the second with the sign of the sense."""
    return float(components[0]), float(sense * components[1]), float(components[2])


def _proportional(x: Decimal, y: Decimal) -> tuple[float, float]:
    widest = max(abs(x), abs(y))
    return float(x / widest), float(y / widest)


@lru_cache(maxsize=32)
def _rows_and_quaternion(axes: tuple[Vector, Vector, Vector]) -> tuple[tuple[Triple, Triple, Triple], Quadruple]:
    """The matrix of which these are the columns, and conj(F)."""
    first, second, third = (_rounded(row) for row in zip(*axes, strict=True))
    x, y, z, w = quaternion.conjugate(quaternion.from_matrix(np.array([first, second, third]))).tolist()
    return (first, second, third), (x, y, z, w)


def steady_motion(body_rate: Sequence[float], attitude_xyzw: Sequence[float]) -> SteadyMotion:
    """The steady motion of a rate, from an attitude."""
    x, y, z = (Decimal(component) for component in body_rate)
    speed = dot((x, y, z), (x, y, z)).sqrt()
    a, b, c = (float(component / speed) if speed else 0.0 for component in (x, y, z))
    attitude = quadruple(attitude_xyzw, 0)
    across = quaternion.product(attitude, (a, b, c, 0.0))
    return SteadyMotion(PhaseClock.of(speed / 2, Decimal(0), 2 * PI).rate, attitude, across, triple(body_rate, 0))


def decimal_motions(starts: InitialConditions, members: Members) -> Iterator[tuple[BodyMotion, Members]]:
    """The motions at these places of an ensemble, one by one; the principal axes of equal inertias once."""
    tensors, states = starts.bodies.inertia, starts.states
    for same in alike(tensors, members):
        inertia = tensors[same[0]].tolist()
        with working_precision(digits_for(inertia)):
            principal = principal_axes(inertia)
            motions = [
                _motion(principal, inertia, states.attitude_xyzw[i].tolist(), states.body_rate[i].tolist())
                for i in same
            ]
        yield from zip(motions, np.reshape(same, (-1, 1)), strict=True)


def _motion(principal: PrincipalAxes, inertia: Tensor, attitude: list[float], rate: list[float]) -> BodyMotion:
    if is_steady(inertia, rate):
        return steady_motion(rate, attitude)
    return general_motion(*frame_and_polhode(principal, inertia, rate), attitude)
