"""What the steps of a motion need to know, whatever their length and the attitude at the start.

The series have the most to say about an error that repeats from step to step. So their first three coefficients come
from decimal arithmetic, and the others, which x⁶ makes small, from doubles.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.spinning_frame import SpinningFrame

Array: TypeAlias = NDArray[np.float64]
Rest: TypeAlias = tuple[list[float], list[float]]

_NANOSECOND: Final = Decimal("1e-9")
_EXACT_TERMS: Final = 3
_FEWEST_TERMS: Final = 2


@dataclass(frozen=True)
class MotionConstants:
    """Numbers of a motion in the units of its frame, hi and lo by turns.

    Attributes
    ----------
    frame : list of float
        One nanosecond; e₁, e₂, e₃; P, Q; m₁, m₃; 2H − e₂.
    rates : list of float
        The body rates of n₁, n₂, n₃ in rad/s.
    differences : list of float
        e₁ − e₂, e₁ − e₃, e₂ − e₃.
    series : list of float
        Those of α and β by turns.
    """

    frame: list[float]
    rates: list[float]
    differences: list[float]
    series: list[float]


def motion_constants(frames: Sequence[SpinningFrame], order: int) -> list[MotionConstants]:
    """Those of motions in their frames, for steps of an even order, in the decimal precision in force."""
    terms = order // 2
    exact = [Invariants.of(frame) for frame in frames]
    rests = _in_doubles(exact, terms) if frames and terms > _EXACT_TERMS else [([], [])] * len(frames)
    return [
        MotionConstants(
            pairs(_of_frame(frame)),
            pairs(e * frame.fastest for e in frame.inverse_moments),
            pairs(_differences(frame)),
            _series(motion, terms, rest),
        )
        for frame, motion, rest in zip(frames, exact, rests, strict=True)
    ]


def pairs(values: Iterable[Decimal]) -> list[float]:
    """Each number as hi and lo."""
    found: list[float] = []
    for value in values:
        hi = float(value)
        found += [hi, float(value - Decimal(hi))]
    return found


def _of_frame(frame: SpinningFrame) -> list[Decimal]:
    e1, e2, e3 = frame.inverse_moments
    n1, n2, n3 = (component * component for component in frame.momentum)
    p = (e2 - e3) * ((e1 - e2) * n2 + (e1 - e3) * n3)
    q = (e1 - e2) * ((e1 - e3) * n1 + (e2 - e3) * n2)
    # of terms that are small near the axis, and cancel on the separatrix only
    above = (e1 - e2) * n1 - (e2 - e3) * n3
    return [_NANOSECOND * frame.fastest, e1, e2, e3, p, q, frame.m1, frame.m3, above]


def _differences(frame: SpinningFrame) -> list[Decimal]:
    e1, e2, e3 = frame.inverse_moments
    return [e1 - e2, e1 - e3, e2 - e3]


def _series(motion: Invariants[Decimal], terms: int, rest: Rest) -> list[float]:
    """The pairs of α and β by turns: decimals first, then the rest; α ends one term earlier."""
    alpha, beta = (pairs(first) for first in preprocessed_inertia(motion, min(terms, _EXACT_TERMS)))
    for coefficients, more in zip((alpha, beta), rest, strict=True):
        coefficients += [part for value in more for part in (value, 0.0)]
        coefficients += [0.0] * (2 * max(terms, _FEWEST_TERMS) - len(coefficients))
    return [c for k in range(0, len(beta), 2) for c in (alpha[k], alpha[k + 1], beta[k], beta[k + 1])]


def _in_doubles(motions: Sequence[Invariants[Decimal]], terms: int) -> list[Rest]:
    """The coefficients after the exact ones, of each motion."""
    rows = np.array([[float(number) for number in vars(motion).values()] for motion in motions])
    if len(motions) == 1:  # the same in numbers, as an operation on an array takes longer to start
        alpha, beta = preprocessed_inertia(Invariants[float](*rows[0].tolist()), terms)
        return [(alpha[_EXACT_TERMS - 1 :], beta[_EXACT_TERMS:])]
    columns = preprocessed_inertia(Invariants[Array](*rows.T), terms)
    alphas, betas = np.array(columns[0][_EXACT_TERMS - 1 :]), np.array(columns[1][_EXACT_TERMS:])
    return list(zip(alphas.T.tolist(), betas.T.tolist(), strict=True))
