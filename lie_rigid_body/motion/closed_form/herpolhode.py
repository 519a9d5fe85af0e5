"""The mean turn of the body about its angular momentum."""

from __future__ import annotations

from decimal import Decimal

from lie_rigid_body.arithmetic.decimals import PI
from lie_rigid_body.motion.closed_form.elliptic_integrals import mean_third
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.polhode import Polhode
from lie_rigid_body.motion.closed_form.principal_frame import PrincipalFrame


def mean_rate(frame: PrincipalFrame, polhode: Polhode, periods: Periods) -> Decimal:
    """Mean of ψ′, rad/s, where the attitude is a fixed rotation, then ψ about the momentum, then the tilt of n.

    n turns about the third axis by half a turn for every 2K of u; ψ is the precession angle of that axis less this.
    """
    return precession_rate(frame, polhode, periods) - frame.sense * PI * polhode.speed / (2 * periods.real)


def precession_rate(frame: PrincipalFrame, polhode: Polhode, periods: Periods) -> Decimal:
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
