"""The polhode: the closed path of the body rate in the body, and the course of the motion along it.

In a `PrincipalFrame` the body rate is ω(u) = (A₁ cn u, ±A₂ sn u, A₃ dn u) with u = λt + u₀ and the sign that of the
frame's sense; cf. L. D. Landau, E. M. Lifshitz, Mechanics, 3rd ed., §37, eqs. 37.8-37.10. Departures: the order of the
moments is reversed below the separatrix instead of exchanging the axes in the formulas; every constant is a product
of sums of terms of one sign, so that nothing cancels; and the parameter is kept as its complement m1 = 1 − m, got
from an exact determinant.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from lie_rigid_body.arithmetic.decimals import Vector, root, working_precision
from lie_rigid_body.motion.closed_form.elliptic_integrals import symmetric_first
from lie_rigid_body.motion.closed_form.exact import separatrix_determinant
from lie_rigid_body.motion.closed_form.principal_axes import PHASE_DIGITS, PrincipalAxes
from lie_rigid_body.motion.closed_form.principal_frame import PrincipalFrame


@dataclass(frozen=True)
class Polhode:
    """Constants of a motion that is not steady.

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
        """The polhode of a frame, given `exact.separatrix_determinant` of the same start."""
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
    principal: PrincipalAxes, inertia: list[list[float]], body_rate: list[float]
) -> tuple[PrincipalFrame, Polhode]:
    """The principal frame and the polhode of a motion that is not steady, to the precision in force.

    Parameters
    ----------
    principal : PrincipalAxes
        Those of the inertia.
    inertia : 3 rows of 3
        kg m², body frame.
    body_rate : 3 numbers
        The initial ω, rad/s, body frame.
    """
    determinant = separatrix_determinant(inertia, body_rate)
    x, y, z = (Decimal(component) for component in body_rate)
    frame = PrincipalFrame.of(principal, (x, y, z), about_largest=determinant >= 0)
    return frame, Polhode.of(frame, determinant)
