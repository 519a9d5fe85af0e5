"""A motion in steps across kicks."""

from __future__ import annotations

import copy
from collections.abc import Callable

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.kicks import KickedMotion, Kicks
from lie_rigid_body.motion.motion import Motion, Samples
from lie_rigid_body.motion.time_steps import require_order


class KickedSteps(KickedMotion):
    """A kicked motion that takes steps, and so goes through rising times only.

    The last attitude of an arc is rounded to doubles before the next arc begins with it.

    Parameters
    ----------
    kicks : Kicks
    start : State
        State at time 0, of one instant.
    free : callable
        ``free(start)`` makes the free motion from a state on.
    """

    def __init__(self, kicks: Kicks, start: State, free: Callable[[State], Motion]) -> None:
        super().__init__(kicks, start)
        self._free = free
        # replaced as a whole, never changed: a copy of the motion goes on by itself, and a signal finds all or none
        self._reached = 0, free(start), 0

    def _samples(self, t_ns: Integers) -> Samples:
        arc, motion, reached_ns = self._reached
        require_order(t_ns, reached_ns)

        def motion_of(wanted: int) -> Motion:
            nonlocal arc, motion
            motion = copy.copy(motion)
            while arc < wanted:
                end = motion.at(self._kicks.begin_ns(arc + 1) - self._kicks.begin_ns(arc))
                arc += 1
                motion = self._free(State.trusted(end.attitude_xyzw, self._kicks.rate(arc)))
            return motion

        samples = self._by_arcs(t_ns, motion_of)
        self._reached = arc, motion, int(t_ns[-1]) if len(t_ns) else reached_ns
        return samples
