"""The numbers that tell a motion's course without following it: regime, period, precession and flips."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Final, Literal, TypeAlias

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.exact import is_steady
from lie_rigid_body.motion.closed_form.herpolhode import precession_rate
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.polhode import Polhode, frame_and_polhode
from lie_rigid_body.motion.closed_form.principal_axes import digits_for, principal_axes
from lie_rigid_body.motion.closed_form.principal_frame import PrincipalFrame

Regime: TypeAlias = Literal["rest", "steady", "about_largest", "about_smallest", "separatrix"]

SUDDEN_RAD: Final = math.pi / 6.0
"""Where the momentum comes nearer than this to the intermediate axis, a body seems to spin steadily between flips."""
LINGERING: Final = 0.01
"""And if it lingers there, as for 1 − m below this; the even circling of a nearly symmetric top has no flips."""


@dataclass(frozen=True)
class Flips:
    """When the body rate along the intermediate axis changes its sign, so that this axis turns over.

    Attributes
    ----------
    interval_s : float
        Half a period; infinite on the separatrix.
    first_s : float
        The first one after the start; infinite if none comes.
    nearest_angle_rad : float
        How near the momentum comes to the intermediate axis between two of them: near 0, the body spins about it
        for a while, and turns over suddenly.
    sudden : bool
        Whether that is nearer than ``SUDDEN_RAD``, and 1 − m below ``LINGERING``: Dzhanibekov's effect.
    """

    interval_s: float
    first_s: float
    nearest_angle_rad: float
    sudden: bool


@dataclass(frozen=True)
class Circulation:
    """The course of a motion that is not steady.

    Attributes
    ----------
    axis : tuple of 3 float
        Unit vector in the body frame, at an acute angle with the momentum: the principal axis which the body rate
        circles; on the separatrix, where the body rate tends to the intermediate axis, that of the largest moment.
    separatrix_distance : float
        1 − m, the complementary parameter of the elliptic functions: 0 on the separatrix, 1 for a symmetric top and
        for small wobbles about the axis.
    period_s : float
        Of the body rate; infinite on the separatrix.
    precession_rate_rad_s : float
        Mean rate at which the axis circles the momentum; positive.
    advance_per_period_rad : float
        The angle about the momentum by which the attitude after one period differs from that before, counted with
        the axis' whole turns; infinite on the separatrix.
    tilt_min_rad, tilt_max_rad : float
        Between which the angle from the momentum to the axis swings.
    flips : Flips or None
        None if two moments are equal.
    """

    axis: tuple[float, float, float]
    separatrix_distance: float
    period_s: float
    precession_rate_rad_s: float
    advance_per_period_rad: float
    tilt_min_rad: float
    tilt_max_rad: float
    flips: Flips | None


@dataclass(frozen=True)
class MotionConstants:
    """A regime, and the course of the motion unless it is steady."""

    regime: Regime
    circulation: Circulation | None

    @classmethod
    def of(cls, body: RigidBody, start: State) -> MotionConstants:
        """The constants of the motion of a body from a start of one instant, each rounded once."""
        inertia, rate = body.inertia.tolist(), start.body_rate.tolist()
        with working_precision(digits_for([entry for row in inertia for entry in row])):
            if is_steady(inertia, rate):
                return cls("steady" if any(rate) else "rest", None)
            frame, polhode = frame_and_polhode(principal_axes(inertia), inertia, rate)
            return cls(_regime(frame, polhode), _circulation(frame, polhode))


def _regime(frame: PrincipalFrame, polhode: Polhode) -> Regime:
    if polhode.m1 == 0:
        return "separatrix"
    return "about_largest" if frame.sense > 0 else "about_smallest"


def _circulation(frame: PrincipalFrame, polhode: Polhode) -> Circulation:
    periods = Periods.of(polhode)
    period = 4 * periods.real / polhode.speed
    precession = precession_rate(frame, polhode, periods)
    n1, n2, n3 = (j * a for j, a in zip(frame.moments, polhode.amplitudes, strict=True))
    # u = 0 and u = K
    tilts = sorted((_angle(n1, n3), _angle(n2, n3 * polhode.m1.sqrt())))
    x, y, z = frame.axes[2]
    return Circulation(
        axis=(float(x), float(y), float(z)),
        separatrix_distance=float(polhode.m1),
        period_s=float(period),
        precession_rate_rad_s=float(precession),
        advance_per_period_rad=float(precession * period),
        tilt_min_rad=tilts[0],
        tilt_max_rad=tilts[1],
        flips=_flips(polhode, periods, _angle(n3 * polhode.m1.sqrt(), n2)) if polhode.m else None,
    )


def _flips(polhode: Polhode, periods: Periods, nearest_angle: float) -> Flips:
    """The zeros of sn u, at the multiples of 2K."""
    start, interval = polhode.start, 2 * periods.real
    first = -start if start < 0 else interval - start
    return Flips(
        interval_s=float(interval / polhode.speed),
        first_s=float(first / polhode.speed),
        nearest_angle_rad=nearest_angle,
        sudden=nearest_angle < SUDDEN_RAD and float(polhode.m1) < LINGERING,
    )


def _angle(across: Decimal, along: Decimal) -> float:
    """The angle in [0, ½π] from these components, whatever their size."""
    size = max(across, along)
    return math.atan2(float(across / size), float(along / size))
