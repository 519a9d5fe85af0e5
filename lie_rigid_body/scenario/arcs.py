"""Energy and momentum along each free motion between two kicks of a scenario, beside those of the exact motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.mechanics import State
from lie_rigid_body.scenario.definition import Scenario


def arc_changes(scenario: Scenario, t_ns: Integers, states: State) -> Iterator[tuple[Array, Array]]:
    """Changes of the kinetic energy, J, and of the world momentum, kg m²/s, since the begin of each state's arc.

    Parameters
    ----------
    scenario : Scenario
    t_ns : ndarray of int64, shape (N,)
        Times since the start, ns.
    states : State
        Of N instants, of unit quaternions.

    Yields
    ------
    tuple of ndarray, shape (N, 1) or (N, 3)
        Changes, and what the exact motion has at the begins.
    """
    kicks = scenario.kick_schedule()
    arcs, which = np.unique(kicks.arcs(t_ns), return_inverse=True)
    begins = scenario.exact_motion().at(kicks.begins_ns(arcs))
    body = scenario.body()
    for kept in (body.kinetic_energy, body.angular_momentum):
        wanted = kept(begins).reshape(len(arcs), -1)[which]
        yield kept(states).reshape(len(wanted), -1) - wanted, wanted


def largest_of_arcs(scenario: Scenario) -> tuple[float, float]:
    """Largest kinetic energy, J, and size of the momentum, kg m²/s, right after the start or a kick."""
    body = scenario.body()
    starts = scenario.arc_starts()
    largest = np.linalg.norm(body.body_momentum(starts), axis=1).max()
    return float(body.kinetic_energy(starts).max()), float(largest)
