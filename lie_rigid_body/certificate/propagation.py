"""Sensitivity of the attitude to the initial body rate, along the exact motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import ClosedForm

_PROBE: Final = 2.0**-30
"""Change of the initial body rate, relative to its norm."""
_TIMES: Final = 257
"""Number of states along the motion."""


@dataclass(frozen=True)
class Propagation:
    """States of the exact motion, and the sensitivity of their attitude to the initial body rate.

    Parameters
    ----------
    times : ndarray, shape (K,)
        s
    states : State
        Of shapes (K, 4) and (K, 3).
    gains : ndarray, shape (K,)
        G: largest attitude change up to each time per change of the initial rate relative to Ω, rad.
    """

    times: Array
    states: State
    gains: Array

    @classmethod
    def of(cls, body: RigidBody, start: State, duration: float, fastest: float) -> Propagation:
        """The propagation along a motion, by differences of the closed form.

        Parameters
        ----------
        body : RigidBody
        start : State
        duration : float
            s
        fastest : float
            Bound Ω of the body rate, rad/s.
        """
        t_ns = np.linspace(0.0, duration * 1e9, _TIMES).astype(np.int64)
        speed = float(so3.norm(start.body_rate))
        probes = start.body_rate + _PROBE * speed * np.vstack([np.eye(3), -np.eye(3)])
        rates = np.vstack([start.body_rate, probes])
        starts = State.trusted(np.tile(start.attitude_xyzw, (len(rates), 1)), rates)
        moved = ClosedForm(body, starts).at(t_ns)
        states = State.trusted(moved.attitude_xyzw[0].copy(), moved.body_rate[0].copy())  # views would keep all bodies'
        turned = quaternion.multiply(quaternion.conjugate(states.attitude_xyzw), moved.attitude_xyzw[1:])
        gains = so3.norm(quaternion.log(turned)).max(axis=0) / _PROBE
        scale = fastest / speed if speed > 0.0 else 1.0
        times = np.asarray(1e-9 * t_ns, dtype=np.float64)
        return cls(times, states, np.asarray(scale * np.maximum.accumulate(gains), dtype=np.float64))

    def gain(self, t: Array) -> Array:
        """Largest attitude change up to times t, s, per relative change of initial rate, rad, shape (N,)."""
        return np.asarray(self.gains[np.minimum(np.searchsorted(self.times, t), len(self.gains) - 1)])

    def growth(self, turns: Array) -> Array:
        """Largest factor by which a disturbance grows over turns, rad: the smaller of exp(turn) and 1 + G."""
        return np.asarray(np.minimum(np.exp(np.minimum(turns, 700.0)), 1.0 + self.gains[-1]))
