"""The `Motion` protocol, and what both motions do alike: read bodies, starts and times, and lay out states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arithmetic.decimals import Tensor
from lie_rigid_body.foundation.arrays import TO_NANOSECONDS, Array, Integers, as_numbers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics import RigidBody, State

Samples: TypeAlias = tuple[Array, Array]
"""Attitudes, scalar last, and body rates, rad/s, at N times, shapes (N, 4) and (N, 3)."""


class Motion(Protocol):
    """A torque-free motion: the states of a body at given times."""

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start.

        Returns
        -------
        State
            Shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.
        """


def require_one(body: object, start: object) -> None:
    """Refuse what is not one body and its state at one instant.

    Raises
    ------
    InputError
    """
    if not isinstance(body, RigidBody):
        raise InputError(f"body {shown(body)} is not a RigidBody: give for example RigidBody([1, 2, 3])")
    if not isinstance(start, State):
        raise InputError(f"start {shown(start)} is not a State: give for example State([0, 0, 0, 1], [0, 1, 0])")
    if start.batch_shape:
        raise InputError(f"start is {start.batch_shape} states: give that of one instant, as states[0]")


def exact_inertia(body: RigidBody) -> Tensor:
    """The inertia of one body as rows of floats, each of which is taken as exact."""
    (a, b, c), (_, d, e), (_, _, f) = body.inertia.tolist()
    return (a, b, c), (b, d, e), (c, e, f)


def nanoseconds(t_ns: ArrayLike) -> Integers:
    """Times as an int64 array of at most one axis, or an error that says what they were.

    Parameters
    ----------
    t_ns : int or array_like of int, shape (N,)
        Nanoseconds since the start.

    Returns
    -------
    ndarray of int64, shape () or (N,)

    Raises
    ------
    InputError
        If the times are not integers, or not of at most one axis.
    """
    array = as_numbers("t_ns", t_ns)
    if array.size == 0 and array.ndim == 1:
        return np.empty(0, dtype=np.int64)
    if array.dtype.kind not in "iu" or array.ndim > 1:
        how = TO_NANOSECONDS.get(array.dtype.kind, "")
        raise InputError(
            f"t_ns has type {array.dtype} and shape {array.shape}: give integer nanoseconds, one or a flat list{how}"
        )
    if array.dtype.kind == "u" and array.size and (array.max()) > np.iinfo(np.int64).max:
        raise InputError(f"t_ns {(array.max())} is beyond int64: give at most {np.iinfo(np.int64).max} ns (292 years)")
    return array.astype(np.int64)


def states_at(start: State | None, t_ns: ArrayLike, samples: Callable[[Integers], Samples]) -> State:
    """The states at some times: shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.

    Parameters
    ----------
    start : State or None
        The state at time 0, which comes out as it was given; None: as it is computed.
    t_ns : int or array_like of int, shape (N,)
    samples : callable
        The attitudes and body rates at times of shape (N,).

    Raises
    ------
    InputError
    """
    times = nanoseconds(t_ns)
    flat = np.atleast_1d(times)
    attitude, rate = samples(flat)
    if start is not None:
        attitude[flat == 0] = start.attitude_xyzw
        rate[flat == 0] = start.body_rate
    return State.trusted(attitude.reshape(*times.shape, 4), rate.reshape(*times.shape, 3))
