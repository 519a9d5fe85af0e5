"""The constants of a motion: what its steps need to know, whatever their length and the attitude at the start.

An error of the series of α and β repeats at every step, and adds up. So their first three coefficients come from
decimal arithmetic; the others, which x⁶ makes small, are computed in doubles.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic.double_double import from_decimal
from lie_rigid_body.arrays import Array
from lie_rigid_body.motion.moser_veselov.layout import (
    ALPHA,
    DIFFERENCES,
    ENERGY,
    INVERSE_MOMENTS,
    M1,
    M3,
    NANOSECOND,
    RATES,
    P,
    Q,
)
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import ScaledMotion

LaterTerms: TypeAlias = tuple[list[float], list[float]]

_NANOSECOND: Final = Decimal("1e-9")
"""A nanosecond in seconds."""
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


def hi_lo(values: Iterable[Decimal]) -> list[float]:
    """The numbers as double-doubles, hi and lo by turns."""
    return [part for value in values for part in from_decimal(value)]


def _placed(motion: ScaledMotion, series: list[float]) -> list[float]:
    """The vector of constants, with the pairs of the series at its end."""
    e1, e2, e3 = motion.inverse_moments
    n1, n2, n3 = (component * component for component in motion.momentum)
    e12, e13, e23 = e1 - e2, e1 - e3, e2 - e3
    numbers: dict[int, Sequence[Decimal]] = {
        NANOSECOND: [_NANOSECOND * motion.fastest],
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
        constants[place : place + 2 * len(values)] = hi_lo(values)
    return constants


def _series(motion: Invariants[Decimal], terms: int, later: LaterTerms) -> list[float]:
    """The pairs of α and β by turns: decimal terms first, then the later ones; α ends one term earlier."""
    alpha, beta = (hi_lo(first) for first in preprocessed_inertia(motion, min(terms, _EXACT_TERMS)))
    for coefficients, more in zip((alpha, beta), later, strict=True):
        coefficients += [part for value in more for part in (value, 0.0)]
        coefficients += [0.0] * (2 * max(terms, _FEWEST_TERMS) - len(coefficients))
    return [c for k in range(0, len(beta), 2) for c in (alpha[k], alpha[k + 1], beta[k], beta[k + 1])]


def _in_doubles(motions: Sequence[Invariants[Decimal]], terms: int) -> list[LaterTerms]:
    """The coefficients after the exact ones, of each motion."""
    rows = np.array([[float(number) for number in vars(motion).values()] for motion in motions])
    if len(motions) == 1:  # the same in numbers, as an operation on an array takes longer to start
        alpha, beta = preprocessed_inertia(Invariants[float](*rows[0].tolist()), terms)
        return [(alpha[_EXACT_TERMS - 1 :], beta[_EXACT_TERMS:])]
    columns = preprocessed_inertia(Invariants[Array](*rows.T), terms)
    alphas, betas = np.array(columns[0][_EXACT_TERMS - 1 :]), np.array(columns[1][_EXACT_TERMS:])
    return list(zip(alphas.T.tolist(), betas.T.tolist(), strict=True))
