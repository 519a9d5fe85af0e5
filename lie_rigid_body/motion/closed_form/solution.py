"""The closed form as a motion: few samples in floats, more on arrays, by the same formulas, with the same bits."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arithmetic.double_double import from_integer, from_integers
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.constants import motion_of
from lie_rigid_body.motion.motion import Samples, require_one, states_at

MAX_SAMPLES_IN_FLOATS: Final = 16
"""Largest number of samples computed one by one, in floats, which is faster than on arrays."""

_SAMPLES_AT_ONCE: Final = 8192
"""Number of samples on arrays whose temporaries fit into a processor's cache."""


class ClosedForm:
    """Torque-free motion by its exact solution in theta functions.

    The constants of a motion are computed once, in decimal arithmetic of 50 digits or more. A state costs a fixed
    number of elementwise operations, whatever the time. The errors do not grow with time: the body and the start are
    taken as exactly the given doubles, and phases are reduced in double-double.

    Parameters
    ----------
    body : RigidBody
    start : State
        State at time 0, of one instant.

    Raises
    ------
    InputError
        If the body is no RigidBody, or the start no State of one instant.

    References
    ----------
    E. Celledoni, F. Fassò, N. Säfström, A. Zanna, "The exact computation of the free rigid body motion and its use in
    splitting methods", SIAM J. Sci. Comput. 30 (2008) 2084.
    """

    __slots__ = ("_motion", "_start")

    def __init__(self, body: RigidBody, start: State) -> None:
        require_one(body, start)
        self._start = start
        self._motion = motion_of(body, start)

    def __repr__(self) -> str:
        return call_repr(self, {"attitude_xyzw": self._start.attitude_xyzw, "body_rate": self._start.body_rate})

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        The attitude is the continuous path on the unit quaternions that begins at the start's, whatever times are
        asked for. A state has the same bits alone and among others.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start, of either sign, in any order.

        Returns
        -------
        State
            Shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.

        Raises
        ------
        InputError
            If the times are not integers, or not of at most one axis.
        """
        return states_at(self._start, t_ns, self._samples)

    def _samples(self, t_ns: Integers) -> Samples:
        """Attitudes and body rates at N times, shapes (N, 4) and (N, 3)."""
        attitude = np.empty((len(t_ns), 4))
        rate = np.empty((len(t_ns), 3))
        if len(t_ns) <= MAX_SAMPLES_IN_FLOATS:
            for i, t in enumerate(t_ns.tolist()):
                sample = self._motion.sample(from_integer(t))
                attitude[i] = sample[:4]
                rate[i] = sample[4:]
            return attitude, rate
        for begin in range(0, len(t_ns), _SAMPLES_AT_ONCE):
            some = slice(begin, begin + _SAMPLES_AT_ONCE)
            sample = self._motion.sample(from_integers(t_ns[some]))
            for k in range(4):
                attitude[some, k] = sample[k]
            for k in range(3):
                rate[some, k] = sample[4 + k]
        return attitude, rate
