"""Rotation about a fixed axis: the spherical body, spin about a principal axis, and rest."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.closed_form.clock import Clock
from lie_rigid_body.motion.closed_form.double_double import Array, DoubleDouble
from lie_rigid_body.motion.closed_form.precision import PI, dot


@dataclass(frozen=True)
class SteadyMotion:
    """The motion q₀ exp(ωt).

    Attributes
    ----------
    start : State
    axis : ndarray, shape (3,)
        Unit vector along ω in the body frame, or 0 at rest.
    half_turn : Clock
        Half the rotation angle, modulo 2π, because the attitude is a path on the double cover.
    """

    start: State
    axis: Array
    half_turn: Clock

    @classmethod
    def of(cls, start: State) -> SteadyMotion:
        """The steady motion from a start."""
        x, y, z = (Decimal(float(component)) for component in start.body_rate)
        speed = dot((x, y, z), (x, y, z)).sqrt()
        axis = np.array([float(component / speed) if speed else 0.0 for component in (x, y, z)])
        return cls(start, axis, Clock.of(speed / 2, Decimal(0), 2 * PI))

    def states(self, time: DoubleDouble) -> State:
        """The states at these nanoseconds, shape (N,)."""
        half = self.half_turn.phase(time).hi
        sine = np.sin(half)
        turn = np.stack([*(component * sine for component in self.axis), np.cos(half)], axis=-1)
        attitude = quaternion.normalize(quaternion.multiply(self.start.attitude_xyzw, turn))
        return State.trusted(attitude, np.tile(self.start.body_rate, (len(half), 1)))
