"""Ordinary motions: those whose constants come out right in double-double, without decimals.

A motion is ordinary if sizes are such that no product overflows or underflows, and it keeps away from the separatrix:
1 − m ≥ 2⁻¹⁰. Then nothing cancels but l² − 2HJ₂, by a factor of at most 2¹¹, and every iteration takes a number of
steps that is known beforehand. The rates that time multiplies come out to 2⁻⁸⁴ of the body rate, 5e-16 rad in
1e10 rad. With products of inertia, the moments must also differ, and the body rate must not be along a principal axis
by all but a little: see `coupled_frame`. Each body is judged by its own numbers, in plain doubles, so that it is judged
the same alone and in any ensemble.

One arithmetic serves both, for the bits must be the same. By the cost of each operation, decimals of 40 digits would be
about as fast for one body, but several times slower for many, as they cannot be taken as arrays.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.numbers import Number, Triple

Verdict: TypeAlias = Any
"""A bool, or an array of them."""

NEAREST: Final = 2.0**-10
"""1 − m of the motions nearest to the separatrix."""

_FLATTEST: Final = 1e3
"""Ratio of moments."""

_LIGHTEST, _HEAVIEST = 1e-20, 1e20
_SLOWEST, _FASTEST = 1e-20, 1e5

_SUM_RATIOS: Final = (2.5, 8.0, 30.0, 120.0)
"""Of (1 − ν)/√m1, above each of which the sum in the mean precession takes a step more."""
_LARGEST_RATIO: Final = 400.0


class Shape(NamedTuple):
    """What the computation branches on; the same for all that are computed at once.

    Attributes
    ----------
    hyperbolic : bool
        Whether m > ½.
    steps : int
        Those of the sum in the mean precession.
    """

    hyperbolic: bool
    steps: int


def about_largest(j: Triple, w: Triple) -> Verdict:
    """Whether the momentum circulates about the axis of the largest moment, from ascending moments; to round-off."""
    return j[2] * (j[2] - j[1]) * (w[2] * w[2]) > j[0] * (j[1] - j[0]) * (w[0] * w[0])


def judged(j: Triple, w: Triple, sense: Number) -> tuple[Verdict, Verdict, Any]:
    """Whether a motion is ordinary, whether m > ½, and the steps of `Shape`.

    Parameters
    ----------
    j, w : 3 numbers
        Moments and the sizes of the initial ω, in the order of a `PrincipalFrame`.
    sense : number
        ±1, its sense.
    """
    (j1, j2, j3), (w1, w2, w3) = j, w
    d21, d31, d32 = sense * (j2 - j1), sense * (j3 - j1), sense * (j3 - j2)
    q1, q2, q3 = j1 * (w1 * w1), j2 * (w2 * w2), j3 * (w3 * w3)
    c1, c2, c3 = d21 * q2 + d31 * q3, d32 * q3 - d21 * q1, d31 * q1 + d32 * q2
    whole, complement = d32 * c1, d31 * c2
    one, swollen = j1 * d32, j1 * d32 + j3 * d21
    # squares of (1 − ν)/√m1 and of 1, times the same
    spread, unit = swollen * swollen * whole, one * one * complement
    steps: Any = 3
    for ratio in _SUM_RATIOS:
        steps = steps + (spread > ratio * ratio * unit)
    fits = (c3 > 0.0) & (whole > 0.0) & (complement >= NEAREST * whole)
    return fits & (spread < _LARGEST_RATIO**2 * unit) & _is_of_ordinary_size(j, w), 2.0 * complement < whole, steps


def _is_of_ordinary_size(j: Triple, w: Triple) -> Verdict:
    j1, _, j3 = j
    fits: Verdict = True
    for moment in j:
        fits = fits & (moment >= _LIGHTEST) & (moment <= _HEAVIEST)
    for rate in w:
        fits = fits & ((rate >= _SLOWEST) | (rate == 0.0)) & (rate <= _FASTEST)
    return fits & (j1 <= _FLATTEST * j3) & (j3 <= _FLATTEST * j1)
