"""Every rotation that is not steady: the body rate on its polhode, and the attitude about the momentum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache

import numpy as np

from lie_rigid_body.arithmetic.decimals import PI, Vector
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form.circular_wave import CircularWave
from lie_rigid_body.motion.closed_form.clock import Clock, EndlessClock
from lie_rigid_body.motion.closed_form.elliptic_integrals import complete_first
from lie_rigid_body.motion.closed_form.herpolhode import mean_rate
from lie_rigid_body.motion.closed_form.hyperbolic_wave import HyperbolicWave
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.placement import Start, world
from lie_rigid_body.motion.closed_form.polhode import Polhode
from lie_rigid_body.motion.closed_form.principal_frame import PrincipalFrame
from lie_rigid_body.motion.closed_form.wave import Wave


@dataclass(frozen=True)
class GeneralMotion:
    """The motion in a `PrincipalFrame`, with n = (N₁ cn u, ±N₂ sn u, N₃ dn u) the unit momentum in it.

    The attitude is W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗ conj(F): F takes the frame to the body, b(n) is the shortest rotation
    from e₃ to n, smooth because n₃ > 0, and ψ its turn about the momentum, with ψ′ = (2H/l + ω₃)/(1 + n₃). W is fixed
    by the start.

    Attributes
    ----------
    polhode_clock, half_turn_clock : Clock
        The phase of u, and half of ψ's mean growth.
    wave : Wave
    rate_amplitudes, direction_amplitudes : 3 numbers
        Of ω in rad/s, the second with its sign, and of n.
    slopes : 2 numbers
        N₁ and N₂, in proportion.
    sense : number
        ±1, the sense of the frame.
    axes : 3 rows of 3 numbers
        Columns are the frame's axes in the body frame.
    world : 4 numbers
        W.
    frame : 4 numbers
        conj(F).
    """

    polhode_clock: Clock | EndlessClock
    half_turn_clock: Clock
    wave: Wave
    rate_amplitudes: Triple
    direction_amplitudes: Triple
    slopes: tuple[Number, Number]
    sense: Number
    axes: tuple[Triple, Triple, Triple]
    world: Quadruple
    frame: Quadruple

    @classmethod
    def of(cls, frame: PrincipalFrame, polhode: Polhode, attitude_xyzw: Sequence[float]) -> GeneralMotion:
        """The motion from a frame, its polhode and the attitude at the start."""
        periods, sense = Periods.of(polhode), float(frame.sense)
        clock, wave = _clock_and_wave(polhode, periods)
        directions = [j * a / polhode.momentum for j, a in zip(frame.moments, polhode.amplitudes, strict=True)]
        axes, conjugate = _rows_and_quaternion(frame.axes)
        x, y, z, w = attitude_xyzw
        return cls(
            polhode_clock=clock,
            half_turn_clock=Clock.of(mean_rate(frame, polhode, periods) / 2, Decimal(0), 2 * PI),
            wave=wave,
            rate_amplitudes=_signed(polhode.amplitudes, frame.sense),
            direction_amplitudes=_signed(directions, frame.sense),
            slopes=_proportional(directions[0], directions[1]),
            sense=sense,
            axes=axes,
            world=world(_start(frame, polhode, wave, clock), conjugate, (x, y, z, w), sense),
            frame=conjugate,
        )


def _signed(components: Sequence[Decimal], sense: int = 1) -> Triple:
    """Each rounded once, the second with the sign of the sense."""
    return float(components[0]), float(sense * components[1]), float(components[2])


def _proportional(x: Decimal, y: Decimal) -> tuple[float, float]:
    widest = max(abs(x), abs(y))
    return float(x / widest), float(y / widest)


def _start(frame: PrincipalFrame, polhode: Polhode, wave: Wave, clock: Clock | EndlessClock) -> Start:
    direction = [j * w / polhode.momentum for j, w in zip(frame.moments, frame.rate, strict=True)]
    across = _proportional(direction[0], frame.sense * direction[1])
    return Start(wave, clock.begin(), _signed(direction), across)


@lru_cache(maxsize=32)
def _rows_and_quaternion(axes: tuple[Vector, Vector, Vector]) -> tuple[tuple[Triple, Triple, Triple], Quadruple]:
    """The matrix of which these are the columns, and conj(F)."""
    first, second, third = (_signed(row) for row in zip(*axes, strict=True))
    x, y, z, w = quaternion.conjugate(quaternion.from_matrix(np.array([first, second, third]))).tolist()
    return (first, second, third), (x, y, z, w)


def _clock_and_wave(polhode: Polhode, periods: Periods) -> tuple[Clock | EndlessClock, Wave]:
    """The wave whose nome is at most exp(−π), and the clock of its phase."""
    if 2 * polhode.m1 >= 1:
        scale = PI / (2 * periods.real)
        return Clock.of(scale * polhode.speed, scale * polhode.start, 2 * PI), CircularWave.of(periods)
    scale = PI / (2 * complete_first(polhode.m))
    if polhode.m1 == 0:
        return EndlessClock.of(scale * polhode.speed, scale * polhode.start), HyperbolicWave.of(periods)
    period = 4 * scale * periods.real
    return Clock.of(scale * polhode.speed, scale * polhode.start, period), HyperbolicWave.of(periods)
