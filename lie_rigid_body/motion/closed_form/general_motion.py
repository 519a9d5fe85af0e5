"""Every rotation that is not steady: the body rate on its polhode, and the attitude about the momentum."""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import Decimal

import numpy as np

from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.closed_form import double_double
from lie_rigid_body.motion.closed_form.circular_wave import CircularWave
from lie_rigid_body.motion.closed_form.clock import Clock, EndlessClock
from lie_rigid_body.motion.closed_form.double_double import Array, DoubleDouble
from lie_rigid_body.motion.closed_form.herpolhode import mean_rate
from lie_rigid_body.motion.closed_form.hyperbolic_wave import HyperbolicWave
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.polhode import Polhode
from lie_rigid_body.motion.closed_form.precision import PI
from lie_rigid_body.motion.closed_form.principal_frame import PrincipalFrame
from lie_rigid_body.motion.closed_form.wave import Crest, Wave


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
    rate_amplitudes, direction_amplitudes : ndarray, shape (3,)
        Of ω in rad/s, the second with its sign, and of n.
    slopes : tuple of 2 float
        N₁ and N₂, in proportion.
    sense : float
        ±1, the sense of the frame.
    axes : ndarray, shape (3, 3)
        Columns are the frame's axes in the body frame.
    world : ndarray, shape (4,)
        W.
    frame : ndarray, shape (4,)
        conj(F).
    """

    polhode_clock: Clock | EndlessClock
    half_turn_clock: Clock
    wave: Wave
    rate_amplitudes: Array
    direction_amplitudes: Array
    slopes: tuple[float, float]
    sense: float
    axes: Array
    world: Array
    frame: Array

    @classmethod
    def of(cls, frame: PrincipalFrame, polhode: Polhode, attitude_xyzw: Array) -> GeneralMotion:
        """The motion from an attitude (frame and polhode hold the rest of the start)."""
        periods = Periods.of(polhode)
        clock, wave = _clock_and_wave(polhode, periods)
        axes = np.array([[float(entry) for entry in axis] for axis in frame.axes]).T
        signs = (1, frame.sense, 1)
        directions = [j * a / polhode.momentum for j, a in zip(frame.moments, polhode.amplitudes, strict=True)]
        motion = cls(
            polhode_clock=clock,
            half_turn_clock=Clock.of(mean_rate(frame, polhode, periods) / 2, Decimal(0), 2 * PI),
            wave=wave,
            rate_amplitudes=np.array([float(s * a) for s, a in zip(signs, polhode.amplitudes, strict=True)]),
            direction_amplitudes=np.array([float(s * a) for s, a in zip(signs, directions, strict=True)]),
            slopes=(float(directions[0] / max(directions[:2])), float(directions[1] / max(directions[:2]))),
            sense=float(frame.sense),
            axes=axes,
            world=np.array([0.0, 0.0, 0.0, 1.0]),
            frame=quaternion.conjugate(quaternion.from_matrix(axes)),
        )
        unturned = motion.states(double_double.from_integers(np.zeros(1, dtype=np.int64))).attitude_xyzw[0]
        return replace(motion, world=quaternion.multiply(attitude_xyzw, quaternion.conjugate(unturned)))

    def states(self, time: DoubleDouble) -> State:
        """The states at these nanoseconds, shape (N,)."""
        phase, parity = self.polhode_clock.folded_phase(time)
        crest = self.wave.at(phase)
        half_turn, rest = self.half_turn_clock.phase(time)
        turn = half_turn + (rest + 0.5 * self.sense * self._libration(crest))
        shape = (parity * crest.cn, parity * crest.sn, crest.dn)
        untilted = _turn_and_untilt(turn, *(a * f for a, f in zip(self.direction_amplitudes, shape, strict=True)))
        attitude = quaternion.multiply(quaternion.multiply(self.world, untilted), self.frame)
        rate = [a * f for a, f in zip(self.rate_amplitudes, shape, strict=True)]
        body_rate = np.stack([row[0] * rate[0] + row[1] * rate[1] + row[2] * rate[2] for row in self.axes], axis=-1)
        return State.trusted(quaternion.normalize(attitude), body_rate)

    def _libration(self, crest: Crest) -> Array:
        """ψ less its mean growth, times the sense: the precession's libration less n's azimuth, in one arctangent."""
        x, y = self.slopes[0] * crest.cn, self.slopes[1] * crest.sn
        sine = crest.sine * x - crest.cosine * y
        cosine = crest.cosine * x + crest.sine * y
        return np.asarray(np.arctan2(sine, cosine) + crest.drift)


def _clock_and_wave(polhode: Polhode, periods: Periods) -> tuple[Clock | EndlessClock, Wave]:
    """The wave whose nome is at most exp(−π), and the clock of its phase."""
    if 2 * polhode.m1 >= 1:
        scale = PI / (2 * periods.real)
        return Clock.of(scale * polhode.speed, scale * polhode.start, 2 * PI), CircularWave.of(periods)
    scale = PI / (2 * periods.imaginary)
    if polhode.m1 == 0:
        return EndlessClock.of(scale * polhode.speed, scale * polhode.start), HyperbolicWave.of(periods)
    period = 4 * scale * periods.real
    return Clock.of(scale * polhode.speed, scale * polhode.start, period), HyperbolicWave.of(periods)


def _turn_and_untilt(half_turn: Array, n1: Array, n2: Array, n3: Array) -> Array:
    """exp(ψ e₃) ⊗ conj(b(n)) from ψ/2 and n, shape (N, 4), with b = (−n₂, n₁, 0, 1 + n₃)/√(2 + 2n₃)."""
    s, c = np.sin(half_turn), np.cos(half_turn)
    scale = 1.0 / np.sqrt(2.0 + 2.0 * n3)
    upright = (1.0 + n3) * scale
    return np.stack([(c * n2 + s * n1) * scale, (s * n2 - c * n1) * scale, s * upright, c * upright], axis=-1)
