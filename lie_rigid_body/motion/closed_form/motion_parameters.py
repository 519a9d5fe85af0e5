"""Inputs of a motion, body and start, and the numbers in the formulas of its states.

Numbers are floats of one motion, or arrays with an element for each of many.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple
from lie_rigid_body.arrays import Array
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock
from lie_rigid_body.motion.closed_form.jacobi import Theta

Members: TypeAlias = NDArray[np.intp]
"""Places of motions in an ensemble, shape (B,)."""


class Starts(NamedTuple):
    """Bodies and their initial states.

    Attributes
    ----------
    inertia : ndarray, shape (B, 3, 3)
        kg m², body frame.
    moments : ndarray, shape (B, 3)
        Principal moments, ascending, in doubles.
    axes : ndarray, shape (B, 3, 3)
        Columns are the principal axes in the body frame, in doubles.
    attitude_xyzw : ndarray, shape (B, 4)
    body_rate : ndarray, shape (B, 3)
        rad/s.
    """

    inertia: Array
    moments: Array
    axes: Array
    attitude_xyzw: Array
    body_rate: Array

    def at(self, members: Members) -> Starts:
        """The starts of some members of the ensemble."""
        return Starts(*(column[members] for column in self))


class GeneralMotion(NamedTuple):
    """A motion that is not steady, in its `PrincipalFrame`.

    With n = (N₁ cn u, ±N₂ sn u, N₃ dn u) the unit momentum in the frame, the attitude is W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗
    conj(F). F takes the frame to the body. b(n) is the shortest rotation from e₃ to n, smooth because n₃ > 0, and ψ its
    turn about the momentum, with ψ′ = (2H/l + ω₃)/(1 + n₃). W is fixed by the start.

    Attributes
    ----------
    phase_clock : PhaseClock or EndlessClock
        The phase of the theta functions, in proportion to u.
    half_turn_clock : PhaseClock
        Half of ψ's mean growth, rad.
    theta : RealTheta or ImaginaryTheta
        The elliptic functions of u, and the libration of ψ.
    rate_amplitudes, direction_amplitudes : 3 numbers
        Amplitudes of ω, rad/s, and of n; the second ones with the sign of the sense.
    transverse : 2 numbers
        N₁ and N₂, in proportion.
    sense : number
        ±1: that of the frame.
    axes : 3 rows of 3 numbers
        Columns are the frame's axes in the body frame.
    world_xyzw : 4 numbers
        W.
    frame_xyzw : 4 numbers
        conj(F).
    """

    phase_clock: PhaseClock | EndlessClock
    half_turn_clock: PhaseClock
    theta: Theta
    rate_amplitudes: Triple
    direction_amplitudes: Triple
    transverse: tuple[Number, Number]
    sense: Number
    axes: tuple[Triple, Triple, Triple]
    world_xyzw: Quadruple
    frame_xyzw: Quadruple


class SteadyMotion(NamedTuple):
    """A rotation about a fixed axis, q₀ exp(ωt): a spherical body, a spin about a principal axis, or rest.

    Attributes
    ----------
    half_turn_rate : DoubleDouble
        Rate of half the rotation angle, turns/ns; the attitude is a path on the double cover.
    attitude : 4 numbers
        q₀.
    across : 4 numbers
        q₀ ⊗ a, where a is the unit vector along ω in the body frame, or 0 at rest.
    body_rate : 3 numbers
        ω, rad/s, body frame.
    """

    half_turn_rate: DoubleDouble
    attitude: Quadruple
    across: Quadruple
    body_rate: Triple


BodyMotion: TypeAlias = GeneralMotion | SteadyMotion
