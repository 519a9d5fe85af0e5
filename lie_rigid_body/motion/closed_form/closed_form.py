"""The closed form as a motion: states at any times from a body and a start."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form import double_double
from lie_rigid_body.motion.closed_form.exact import is_steady
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.polhode import frame_and_polhode
from lie_rigid_body.motion.closed_form.precision import working_precision
from lie_rigid_body.motion.closed_form.principal_axes import digits_for
from lie_rigid_body.motion.closed_form.steady_motion import SteadyMotion
from lie_rigid_body.motion.motion import nanoseconds, require_body_and_start

_BLOCK: Final = 8192
"""Samples taken at once: their temporaries then stay in a processor's cache."""


class ClosedForm:
    """Torque-free motion by its exact solution in theta functions.

    The constants of a motion are computed once, in decimal arithmetic of 64 digits or more; a state costs a fixed
    number of elementwise operations, whatever the time. The errors do not grow with time: the body and the start are
    taken as exactly the given doubles, and phases are reduced in double-double.

    Parameters
    ----------
    body : RigidBody
    start : State
        Of one instant: shapes (4,) and (3,).

    Raises
    ------
    InputError
        If the body is no RigidBody, or the start no State of one instant.
    """

    __slots__ = ("_motion",)

    def __init__(self, body: RigidBody, start: State) -> None:
        require_body_and_start(body, start)
        self._motion = _motion(body.inertia.tolist(), start)

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        The attitude is the continuous path on the unit quaternions that begins at the start's, whatever times are
        asked for. A batch gives the bits of its rows.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start, of either sign, in any order.

        Returns
        -------
        State
            Of shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.

        Raises
        ------
        InputError
            If the times are not integers, or not of at most one axis.
        """
        times = nanoseconds(t_ns)
        flat = np.atleast_1d(times)
        attitude, rate = np.empty((len(flat), 4)), np.empty((len(flat), 3))
        for begin in range(0, len(flat), _BLOCK):
            block = slice(begin, begin + _BLOCK)
            states = self._motion.states(double_double.from_integers(flat[block]))
            attitude[block], rate[block] = states.attitude_xyzw, states.body_rate
        states = State.trusted(attitude, rate)
        return states if times.ndim else states[0]


def _motion(inertia: list[list[float]], start: State) -> SteadyMotion | GeneralMotion:
    rate = start.body_rate.tolist()
    with working_precision(digits_for([entry for row in inertia for entry in row])):
        if is_steady(inertia, rate):
            return SteadyMotion.of(start)
        frame, polhode = frame_and_polhode(inertia, rate)
        return GeneralMotion.of(frame, polhode, start.attitude_xyzw)
