"""The motions of rigid bodies by discrete Moser–Veselov steps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic import decimals
from lie_rigid_body.arithmetic.double_double import from_decimal
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.motion.moser_veselov.layout import (
    ALPHA,
    ATTITUDE,
    DIFFERENCES,
    ENERGY,
    INVERSE_MOMENTS,
    M1,
    M3,
    MOMENTUM,
    RATES,
    SCALED_NANOSECOND,
    SPATIAL_MOMENTUM,
    STATE_SIZE,
    STEP_LENGTH,
    P,
    Q,
    store,
)
from lie_rigid_body.motion.moser_veselov.loop import LOOP, SAMPLE_SIZE
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, CyclicFrame, ScaledMotion, rotated
from lie_rigid_body.motion.motion import InitialConditions, alike
from lie_rigid_body.motion.time_steps import longest_step

LaterTerms: TypeAlias = tuple[list[float], list[float]]

_EXACT_TERMS: Final = 3
"""Number of coefficients of β computed in decimals; the later ones are doubles."""
_FEWEST_TERMS: Final = 2
"""Smallest number of coefficients that the kernels read; missing ones are 0."""


def motion_constants(motions: Sequence[ScaledMotion], order: int) -> list[list[float]]:
    """The constants of each motion for steps of an even order, as `layout` says; the spatial momentum is left at 0.

    Decimal arithmetic is that of the precision in force.
    """
    terms = order // 2
    exact = [Invariants.of(motion) for motion in motions]
    later = _in_doubles(exact, terms) if motions and terms > _EXACT_TERMS else [([], [])] * len(motions)
    return [
        _placed(motion, _series(invariants, terms, rest))
        for motion, invariants, rest in zip(motions, exact, later, strict=True)
    ]


def rounded(values: Iterable[Decimal]) -> list[tuple[float, float]]:
    """The numbers as double-doubles."""
    return [from_decimal(value) for value in values]


def _placed(motion: ScaledMotion, series: list[float]) -> list[float]:
    """The vector of constants, with the pairs of the series at its end."""
    e1, e2, e3 = motion.inverse_moments
    n1, n2, n3 = (component * component for component in motion.momentum)
    e12, e13, e23 = e1 - e2, e1 - e3, e2 - e3
    numbers: dict[int, Sequence[Decimal]] = {
        SCALED_NANOSECOND: [decimals.NANOSECOND * motion.fastest],
        INVERSE_MOMENTS: [e1, e2, e3],
        P: [e23 * (e12 * n2 + e13 * n3)],
        Q: [e12 * (e13 * n1 + e23 * n2)],
        M1: [motion.m1],
        M3: [motion.m3],
        # of terms that are small near an axis, and cancel on the separatrix only
        ENERGY: [e12 * n1 - e23 * n3],
        RATES: [e * motion.fastest for e in motion.inverse_moments],
        DIFFERENCES: [e12, e13, e23],
    }
    constants = [*[0.0] * ALPHA, *series]
    for place, values in numbers.items():
        store(constants, place, rounded(values))
    return constants


def _series(motion: Invariants[Decimal], terms: int, later: LaterTerms) -> list[float]:
    """The pairs of α and β by turns: decimal terms first, then the later ones; α ends one term earlier."""
    alpha, beta = (rounded(first) for first in preprocessed_inertia(motion, min(terms, _EXACT_TERMS)))
    for coefficients, more in zip((alpha, beta), later, strict=True):
        coefficients += [(value, 0.0) for value in more]
        coefficients += [(0.0, 0.0)] * (max(terms, _FEWEST_TERMS) - len(coefficients))
    return [part for pairs in zip(alpha, beta, strict=True) for pair in pairs for part in pair]


def _in_doubles(motions: Sequence[Invariants[Decimal]], terms: int) -> list[LaterTerms]:
    """The coefficients after the exact ones, of each motion."""
    rows = np.array([[float(number) for number in vars(motion).values()] for motion in motions])
    if len(motions) == 1:  # the same in numbers, as an operation on an array takes longer to start
        alpha, beta = preprocessed_inertia(Invariants[float](*rows[0].tolist()), terms)
        return [(alpha[_EXACT_TERMS - 1 :], beta[_EXACT_TERMS:])]
    columns = preprocessed_inertia(Invariants[Array](*rows.T), terms)
    alphas, betas = np.array(columns[0][_EXACT_TERMS - 1 :]), np.array(columns[1][_EXACT_TERMS:])
    return list(zip(alphas.T.tolist(), betas.T.tolist(), strict=True))


LARGEST_TURN: Final = 0.25
"""Largest rotation angle in a step, rad: there the series of the highest order end in round-off."""


class MoserVeselovIntegrator:
    """The motion of one body by discrete Moser–Veselov steps; an `Integrator`.

    Parameters
    ----------
    frame : CyclicFrame
    motion : ScaledMotion
    constants : list of float
        Constants of the motion, without the spatial momentum; see `motion_constants`.
    attitude_xyzw : list of float
        At the start, world from body.
    max_step : float
        Largest step that is asked for, s.

    Attributes
    ----------
    start : list of float
        The state at time 0; see `layout`.
    constants : list of float
        Constants of the motion; see `layout`.
    largest_step : float
        s
    """

    __slots__ = ("_frame", "constants", "largest_step", "start")

    def __init__(
        self,
        frame: CyclicFrame,
        motion: ScaledMotion,
        constants: list[float],
        attitude_xyzw: list[float],
        max_step: float,
    ) -> None:
        attitude = frame.inward(attitude_xyzw)
        self.start = [0.0] * STATE_SIZE
        store(self.start, MOMENTUM, rounded(motion.momentum))
        store(self.start, ATTITUDE, rounded(attitude))
        self.start[STEP_LENGTH] = -1.0  # no step yet
        self.constants = list(constants)
        store(self.constants, SPATIAL_MOMENTUM, rounded(rotated(attitude, motion.momentum)))
        self.largest_step = longest_step(max_step, LARGEST_TURN, float(motion.fastest))
        self._frame = frame

    def require_short_steps(self, state: list[float], span_ns: int) -> None:
        """Accept every step: the largest is short enough."""

    def advance(self, state: list[float], spans: Integers, counts: Integers, work: int) -> tuple[Array, Array]:
        """Move a state, in place, through N samples; see `Integrator`."""
        out = np.empty((len(spans), SAMPLE_SIZE))
        LOOP.run(state, self.constants, spans, counts, out, work)
        return self._frame.outward(out[:, :4], out[:, 4:])


def moser_veselov_integrators(starts: InitialConditions, max_step: float, order: int) -> list[MoserVeselovIntegrator]:
    """The motions of B bodies from their starts, by steps of an even order.

    Bodies of equal inertia share their axes, and those of equal rate as well the constants of their motion.
    """
    found: dict[int, MoserVeselovIntegrator] = {}
    with decimals.working_precision(DIGITS):
        motions = list(_motions(starts))
        constants = motion_constants([motion for _, motion, _ in motions], order)
        for (frame, motion, same), numbers in zip(motions, constants, strict=True):
            for i in same:
                attitude = starts.states.attitude_xyzw[i].tolist()
                found[i] = MoserVeselovIntegrator(frame, motion, numbers, attitude, max_step)
    return [found[i] for i in range(len(found))]


def _motions(starts: InitialConditions) -> Iterator[tuple[CyclicFrame, ScaledMotion, list[int]]]:
    """Each distinct motion but for its attitude, and which of the bodies have it."""
    inertia, rate = starts.bodies.inertia, starts.states.body_rate
    for body in alike(inertia, range(len(inertia))):
        frame = CyclicFrame.of(inertia[body[0]].tolist())
        for same in alike(rate, body):
            yield frame, ScaledMotion.about(frame, rate[same[0]].tolist()), same
