"""Growth of errors along the exact motion of a scenario."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.motion.description import MotionConstants
from lie_rigid_body.motion.error_growth import ErrorGrowth

_NODES: Final = 257
"""Number of states along the motion, or along one of its periods."""
_ASIDE: Final = 2.0**-30 * np.array([0.61, -0.53, 0.59])
"""Change of the initial body rate, relative to its size, that takes it off a steady rotation, where errors of the rate
would seem not to grow; a growth by more than its inverse makes every limit its cap."""


class Propagation(NamedTuple):
    """States of the exact motion, the growth of errors between them, and its largest factor up to the end."""

    states: State
    growth: ErrorGrowth
    largest_growth: float

    @classmethod
    def of(cls, body: RigidBody, start: State, duration: float, fastest: float) -> Propagation:
        """The propagation along a motion of ``duration`` seconds, of which ``fastest``, rad/s, bounds the body rate."""
        near = State(start.attitude_xyzw, start.body_rate + _ASIDE * so3.norm(start.body_rate))
        circulation = MotionConstants.of(body, near).circulation
        # energy and momentum do not tell a state from that half a period later
        period = duration if circulation is None else min(duration, 0.5 * circulation.period_s)
        t_ns = np.linspace(0.0, period * 1e9, _NODES).astype(np.int64)
        states = ClosedForm(body, near).at(t_ns)
        growth = ErrorGrowth.of(body, np.asarray(1e-9 * t_ns), states, fastest)
        return cls(states, growth, growth.largest(body, fastest, duration))
