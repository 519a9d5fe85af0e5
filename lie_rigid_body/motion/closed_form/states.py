"""The four kinds of motion, each with the formula of its states.

- small modulus: m ≤ ½, elliptic functions by theta functions of real argument;
- large modulus: m > ½, by theta functions of imaginary argument;
- separatrix: m = 1, the same with a nome of 0 and a clock whose phase never returns;
- steady: rotation about a fixed axis, and rest.

The times are floats or arrays, and so are the numbers of the states; their bits are the same.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble, fast_two_sum, remainder, two_sum
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import sqrt
from lie_rigid_body.motion.closed_form.attitude import AttitudeConstants, Four, Sample
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock, turns_from_zero
from lie_rigid_body.motion.closed_form.jacobi import ImaginaryTheta, RealTheta


class SmallModulus(NamedTuple):
    """A motion with m ≤ ½.

    Attributes
    ----------
    clock : PhaseClock
        Of the phase ζ of the theta functions.
    theta : RealTheta
    half_turn_rate : DoubleDouble
        Rate of half of ψ's mean growth, turns/ns.
    attitude : AttitudeConstants
    """

    clock: PhaseClock
    theta: RealTheta
    half_turn_rate: DoubleDouble
    attitude: AttitudeConstants

    def sample(self, time: DoubleDouble) -> Sample:
        """The state at a time in ns."""
        s, c = sine_cosine(self.clock.turns(time))
        return self.attitude.sample(self.theta.values(s, c), turns_from_zero(self.half_turn_rate, time))


class LargeModulus(NamedTuple):
    """A motion with m > ½.

    Attributes
    ----------
    clock : PhaseClock or EndlessClock
        Of the phase χ of the theta functions.
    theta : ImaginaryTheta
    half_turn_rate : DoubleDouble
        Rate of half of ψ's mean growth, turns/ns.
    half_turn_per_phase : float
        Turns of half of ψ per unit of χ, besides what the theta functions give.
    attitude : AttitudeConstants
    """

    clock: PhaseClock | EndlessClock
    theta: ImaginaryTheta
    half_turn_rate: DoubleDouble
    half_turn_per_phase: float
    attitude: AttitudeConstants

    def sample(self, time: DoubleDouble) -> Sample:
        """The state at a time in ns."""
        # the theta functions serve for half a period, |χ| ≤ X; half a period later sn and cn have changed their signs
        phase, parity = self.clock.folded_phase(time)
        values = self.theta.values(phase).half_period_later(parity)
        hi, lo = turns_from_zero(self.half_turn_rate, time)
        total, error = two_sum(hi, self.half_turn_per_phase * phase[0])
        return self.attitude.sample(values, remainder(fast_two_sum(total, error + lo)))


class Steady(NamedTuple):
    """A rotation about a fixed axis, q₀ exp(ωt): a spherical body, a spin about a principal axis, or rest.

    Attributes
    ----------
    half_turn_rate : DoubleDouble
        Rate of half the rotation angle, turns/ns; the attitude is a path on the double cover.
    attitude : 4 floats
        q₀.
    across : 4 floats
        q₀ ⊗ a, where a is the unit vector along ω in the body frame, or 0 at rest.
    body_rate : 3 floats
        ω, rad/s, body frame.
    """

    half_turn_rate: DoubleDouble
    attitude: Four
    across: Four
    body_rate: tuple[float, ...]

    def sample(self, time: DoubleDouble) -> Sample:
        """The state at a time in ns: q₀ ⊗ (axis · sin ½ωt + cos ½ωt)."""
        s, c = sine_cosine(turns_from_zero(self.half_turn_rate, time))
        x, y, z, w = (p * c + q * s for p, q in zip(self.attitude, self.across, strict=True))
        size = 1.0 / sqrt((x * x + y * y) + (z * z + w * w))
        return (x * size, y * size, z * size, w * size, *self.body_rate)


BodyMotion: TypeAlias = SmallModulus | LargeModulus | Steady
