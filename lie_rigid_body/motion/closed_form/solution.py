"""The closed form as a motion: states at any times from bodies and starts."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.evaluation import Ensemble
from lie_rigid_body.motion.closed_form.motion_parameters import Starts
from lie_rigid_body.motion.motion import (
    DEFAULT_MEMORY_LIMIT,
    WorkingMemory,
    batch_shape,
    flat_batch,
    nanoseconds,
    samples_within,
)
from lie_rigid_body.wording import call_repr

_WORKING_MEMORY: Final = WorkingMemory(body=0, time=8, sample=512)
"""Bytes beside the states; a sample being computed takes 340 to 420 bytes, by measurement."""


class ClosedForm:
    """Torque-free motion by its exact solution in theta functions, of one body or of an ensemble.

    The constants of a motion are computed once: of most in double-double, of those near a separatrix or of extreme
    sizes in decimal arithmetic of 50 digits or more. A state costs a fixed number of elementwise operations, whatever
    the time. The errors do not grow with time: the body and the start are taken as exactly the given doubles, and
    phases are reduced in double-double.

    Parameters
    ----------
    body : RigidBody
        One, or a batch.
    start : State
        One state, or one for each body. The batches broadcast; one of shape () goes with every other.

    Raises
    ------
    InputError
        If the body is no RigidBody, the start no State, or their batches do not go together.
    """

    __slots__ = ("_attitude_xyzw", "_batch", "_body_rate", "_ensemble")

    def __init__(self, body: RigidBody, start: State) -> None:
        self._batch = batch_shape(body, start)
        starts = Starts(
            flat_batch(body.inertia, self._batch, 3, 3),
            flat_batch(body.principal_moments, self._batch, 3),
            flat_batch(body.principal_axes, self._batch, 3, 3),
            flat_batch(start.attitude_xyzw, self._batch, 4),
            flat_batch(start.body_rate, self._batch, 3),
        )
        self._attitude_xyzw, self._body_rate = starts.attitude_xyzw, starts.body_rate
        self._ensemble = Ensemble.of(starts)

    def __repr__(self) -> str:
        shape = {"bodies": self._batch} if self._batch else {}
        attitude, rate = self._attitude_xyzw, self._body_rate
        if not self._batch:
            attitude, rate = attitude[0], rate[0]
        return call_repr(self, {**shape, "attitude_xyzw": attitude, "body_rate": rate})

    def expect(self, work: int) -> None:
        """Take notice of samples of each body that will be asked for; see `Motion`."""
        self._ensemble.expect(work)

    def at(self, t_ns: ArrayLike, *, memory_limit: int = DEFAULT_MEMORY_LIMIT) -> State:
        """The states at the given times.

        The attitude is the continuous path on the unit quaternions that begins at the start's, whatever times are
        asked for. Each body and time has the bits that it has alone.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start, of either sign, in any order.
        memory_limit : int, optional
            Bytes that the states and everything made on the way may take; 4 GiB unless given. The states take 56 of
            them for each body and time.

        Returns
        -------
        State
            Shapes (..., 4) and (..., 3) for one time, (..., N, 4) and (..., N, 3) for an array, after the axes of
            the batch.

        Raises
        ------
        InputError
            If the times are not integers, or not of at most one axis, or the states would take more memory than
            allowed.
        """
        times = nanoseconds(t_ns)
        bodies = math.prod(self._batch)
        block = samples_within(bodies, times.size, memory_limit, _WORKING_MEMORY)
        attitude, rate = np.empty((bodies, times.size, 4)), np.empty((bodies, times.size, 3))
        self._ensemble.fill(attitude, rate, np.atleast_1d(times), block)
        # at time 0 the very numbers that were given
        first = np.flatnonzero(np.atleast_1d(times) == 0)
        attitude[:, first], rate[:, first] = self._attitude_xyzw[:, np.newaxis], self._body_rate[:, np.newaxis]
        shape = (*self._batch, *times.shape)
        return State.trusted(attitude.reshape(*shape, 4), rate.reshape(*shape, 3))
