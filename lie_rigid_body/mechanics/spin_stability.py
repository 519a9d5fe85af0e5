"""What becomes of a small disturbance of a steady spin about a principal axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from lie_rigid_body.mechanics.top import equal_moments

Verdict: TypeAlias = Literal["stable", "unstable", "neutral"]


@dataclass(frozen=True)
class SpinStability:
    """Stability of the spin about one principal axis.

    Attributes
    ----------
    verdict : str
        ``stable``: a disturbance circles the axis; ``unstable``: it grows exponentially; ``neutral``: neither, as an
        equal moment makes the neighbouring spins steady too.
    spin_rate_rad_s : float
        The spin for which the rates hold; they are proportional to it.
    growth_rate_1_s : float
        λ of the growth exp(λt), 0 unless unstable.
    wobble_rate_rad_s : float
        Angular frequency, in the body, at which a disturbance circles the axis; 0 unless stable.
    """

    verdict: Verdict
    spin_rate_rad_s: float
    growth_rate_1_s: float
    wobble_rate_rad_s: float

    @classmethod
    def of(cls, moments: Sequence[float], axis: int, spin_rate: float) -> SpinStability:
        """Linearised Euler equations: a disturbance obeys δ″ = −Ω² (I−J)(I−K)/(JK) δ (L. D. Landau, E. M. Lifshitz,
        Mechanics, §37).

        Parameters
        ----------
        moments : sequence of 3 float
            kg m².
        axis : int
            The index of the axis of the spin.
        spin_rate : float
            Ω, rad/s, not negative.
        """
        own = moments[axis]
        other, third = (moment for i, moment in enumerate(moments) if i != axis)
        if equal_moments(own, other) or equal_moments(own, third):
            return cls("neutral", spin_rate, 0.0, 0.0)
        square = (own / other - 1.0) * (own / third - 1.0)
        rate = spin_rate * math.sqrt(abs(square))
        return cls("unstable", spin_rate, rate, 0.0) if square < 0.0 else cls("stable", spin_rate, 0.0, rate)
