"""The motion of a rigid body by discrete Moser–Veselov steps."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.decimals import NANOSECOND, working_precision
from lie_rigid_body.arithmetic.double_double import ZERO, DoubleDouble, from_decimal
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, CyclicFrame, DimensionlessMotion, rotated
from lie_rigid_body.motion.moser_veselov.records import PowerSeries, Step, StepperConstants, StepperState, Three
from lie_rigid_body.motion.motion import exact_inertia

MAX_TURN: Final = 0.25
"""Largest rotation angle in a step, rad: there the series of the highest order end in round-off."""

MAX_ORDER: Final = 20
"""Largest order of a step."""

_EXACT_TERMS: Final = 3
"""Number of coefficients of β computed in decimals; the later ones are doubles."""


class MoserVeselovIntegrator:
    """The motion of one body by discrete Moser–Veselov steps of an even order; an `Integrator`.

    Attributes
    ----------
    start : StepperState
        The state at time 0.
    constants : StepperConstants
        Constants of the motion.
    fastest : float
        The largest body rate of the motion, rad/s.
    """

    __slots__ = ("_frame", "constants", "fastest", "start")

    def __init__(self, body: RigidBody, start: State, order: int) -> None:
        with working_precision(DIGITS):
            self._frame = CyclicFrame.of(exact_inertia(body))
            motion = DimensionlessMotion.of(self._frame, start.body_rate.tolist())
            attitude = self._frame.inward(start.attitude_xyzw.tolist())
            x, y, z, w = map(from_decimal, attitude)
            self.constants = stepper_constants(motion, order, rotated(attitude, motion.momentum))
            zeros = (ZERO, ZERO, ZERO)
            none_yet = Step((-1.0, 0.0), zeros, zeros, ZERO, zeros)
            self.start = StepperState(_three(motion.momentum), (x, y, z, w), 0.0, none_yet)
            self.fastest = float(motion.fastest)

    def compile(self) -> bool:
        """Compile the steps; see `Integrator`."""
        return LOOP.compile(self.start, self.constants)

    def require_short_steps(self, state: StepperState, step: float) -> None:
        """Accept every step: the largest is short enough."""

    def advance(self, state: StepperState, spans: Integers, counts: Integers) -> tuple[StepperState, Array, Array]:
        """Move a state through N samples; see `Integrator`."""
        out = np.empty((len(spans), 7))
        state = LOOP.run(state, self.constants, spans, counts, out)
        attitude, rate = self._frame.outward(out[:, :4], out[:, 4:])
        return state, attitude, rate


def stepper_constants(motion: DimensionlessMotion, order: int, world_momentum: Iterable[Decimal]) -> StepperConstants:
    """The constants of a motion for steps of an even order, by decimal arithmetic of the precision in force."""
    e1, e2, e3 = motion.inverse_moments
    n1, n2, n3 = (component * component for component in motion.momentum)
    e12 = e1 - e2
    e13 = e1 - e3
    e23 = e2 - e3
    alpha, beta = _series(Invariants.of(motion), order // 2)
    return StepperConstants(
        nanosecond=from_decimal(NANOSECOND * motion.fastest),
        inverse_moments=_three(motion.inverse_moments),
        differences=_three((e12, e13, e23)),
        p=from_decimal(e23 * (e12 * n2 + e13 * n3)),
        q=from_decimal(e12 * (e13 * n1 + e23 * n2)),
        m1=from_decimal(motion.m1),
        m3=from_decimal(motion.m3),
        # of terms that are small near an axis, and cancel on the separatrix only
        energy=from_decimal(e12 * n1 - e23 * n3),
        world_momentum=_three(world_momentum),
        rates=_three(e * motion.fastest for e in motion.inverse_moments),
        alpha=alpha,
        beta=beta,
    )


def _three(values: Iterable[Decimal]) -> Three:
    a, b, c = map(from_decimal, values)
    return a, b, c


def _series(motion: Invariants, terms: int) -> tuple[PowerSeries, PowerSeries]:
    """The series of α and β: decimal terms first, then the later ones in doubles; α ends one term earlier."""
    in_doubles = Invariants(*map(float, motion))
    exact = preprocessed_inertia(motion, min(terms, _EXACT_TERMS))
    later = preprocessed_inertia(in_doubles, terms)
    alpha, beta = (
        _power_series([*map(from_decimal, decimals), *((value, 0.0) for value in doubles[len(decimals) :])])
        for decimals, doubles in zip(exact, later, strict=True)
    )
    return alpha, beta


def _power_series(coefficients: list[DoubleDouble]) -> PowerSeries:
    """The series of some coefficients, and of zeros after them."""
    first, second, *later = coefficients + [ZERO] * (MAX_ORDER // 2 - len(coefficients))
    a, b, c, d, e, f, g, h = (float(hi) for hi, _ in reversed(later))
    return PowerSeries(first, second, (a, b, c, d, e, f, g, h))
