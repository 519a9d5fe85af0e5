"""Rotation about a fixed axis: the spherical body, spin about a principal axis, and rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from lie_rigid_body.arithmetic.decimals import PI, dot
from lie_rigid_body.arithmetic.numbers import Quadruple, Triple
from lie_rigid_body.motion.closed_form.clock import Clock


@dataclass(frozen=True)
class SteadyMotion:
    """The motion q₀ exp(ωt).

    Attributes
    ----------
    attitude : 4 numbers
        q₀.
    rate : 3 numbers
        ω, rad/s, body frame.
    axis : 3 numbers
        Unit vector along ω in the body frame, or 0 at rest.
    half_turn : Clock
        Half the rotation angle, modulo 2π, because the attitude is a path on the double cover.
    """

    attitude: Quadruple
    rate: Triple
    axis: Triple
    half_turn: Clock

    @classmethod
    def of(cls, body_rate: Sequence[float], attitude_xyzw: Sequence[float]) -> SteadyMotion:
        """The steady motion of a rate, from an attitude."""
        x, y, z = (Decimal(component) for component in body_rate)
        speed = dot((x, y, z), (x, y, z)).sqrt()
        a, b, c = (float(component / speed) if speed else 0.0 for component in (x, y, z))
        rate = (body_rate[0], body_rate[1], body_rate[2])
        qx, qy, qz, qw = attitude_xyzw
        return cls((qx, qy, qz, qw), rate, (a, b, c), Clock.of(speed / 2, Decimal(0), 2 * PI))
