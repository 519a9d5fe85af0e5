"""Condition numbers of momentum, energy and body rate along a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor


@dataclass(frozen=True)
class ConditionNumbers:
    """Condition numbers, at least 1: amplification of a relative error of the rate, or of the momentum.

    A body given by its principal moments has the first three 1: there a momentum's component is as exact as the
    rate's. Products of inertia cancel in Mω, the more the slenderer the body.

    Parameters
    ----------
    momentum : float
        Of reading the momentum off a rate, ‖abs(M) abs(ω)‖/‖Mω‖.
    energy : float
        Of reading the energy off a rate, from abs(ω)·abs(M) abs(ω)/2H and ‖ω‖‖Mω‖/2H.
    inverse : float
        Of computing a rate from a momentum, I₃/I₁.
    energy_of_momentum, rate_of_momentum : float
        Of an error of the momentum in any direction: ‖ω‖‖π‖/2H for the energy, ‖π‖/(I₁Ω) for the rate relative to Ω.
    """

    momentum: float = 1.0
    energy: float = 1.0
    inverse: float = 1.0
    energy_of_momentum: float = 1.0
    rate_of_momentum: float = 1.0

    @classmethod
    def of(cls, body: RigidBody, states: State, rate_bound: float) -> ConditionNumbers:
        """The largest along the states of a motion whose body rate is bounded by ``rate_bound``, rad/s."""
        rates, momenta = states.body_rate, body.body_momentum(states)
        speeds, sizes = so3.norm(rates), so3.norm(momenta)
        twice_energy = 2.0 * body.kinetic_energy(states)
        if rate_bound == 0.0 or twice_energy.min() == 0.0:
            return cls()
        smallest, _, largest = (float(moment) for moment in body.principal_moments)
        by_rate = _largest(sizes / (smallest * rate_bound))
        by_energy = _largest(speeds * sizes / twice_energy)
        if np.count_nonzero(body.inertia) <= len(body.inertia):
            return cls(energy_of_momentum=by_energy, rate_of_momentum=by_rate)
        parts = apply_tensor(np.abs(body.inertia), np.abs(rates))
        return cls(
            _largest(so3.norm(parts) / sizes),
            max(by_energy, _largest(np.sum(np.abs(rates) * parts, axis=-1) / twice_energy)),
            largest / smallest,
            by_energy,
            by_rate,
        )


def _largest(values: Array) -> float:
    return max(1.0, float(np.max(values)))
