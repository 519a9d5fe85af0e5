"""The `Motion` protocol, and what both motions do alike: read bodies, starts, times and memory, and lay out states."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import TO_NANOSECONDS, Array, Integers, as_numbers, plain
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics import RigidBody, State


class Motion(Protocol):
    """A torque-free motion: the states of a body, or of an ensemble of bodies, at given times."""

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start.

        Returns
        -------
        State
            Shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array; of an ensemble, after its axes.
        """


def batch_shape(body: object, start: object) -> tuple[int, ...]:
    """Leading axes of the states that result from broadcasting body against start.

    They follow numpy's rules of broadcasting, but where both have leading axes the body must not have fewer than the
    start. Its axes then are the first of every result, and ``body.kinetic_energy(states)`` takes them so.

    Parameters
    ----------
    body, start : object

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        If one is no RigidBody or State, or their leading axes do not go together.
    """
    if not isinstance(body, RigidBody):
        raise InputError(f"body {shown(body)} is not a RigidBody: give for example RigidBody([1, 2, 3])")
    if not isinstance(start, State):
        raise InputError(f"start {shown(start)} is not a State: give for example State([0, 0, 0, 1], [0, 1, 0])")
    bodies, starts = body.batch_shape, start.body_rate.shape[:-1]
    try:
        shape = np.broadcast_shapes(bodies, starts)
    except ValueError:
        shape = ()
    if ((bodies or starts) and not shape) or 0 < len(bodies) < len(starts):
        raise InputError(
            f"bodies of shape {bodies} do not go with starts of shape {starts}: give equal leading axes, "
            "of length 1 where one body or start serves all"
        )
    return shape


@short_dataclass(frozen=True)
class InitialConditions:
    """B bodies, each with its state at time 0.

    Attributes
    ----------
    batch : tuple of int
        The leading axes of the batch that they were given as, of product B; () for one body alone.
    bodies : RigidBody
        Of leading axis B.
    states : State
        Shapes (B, 4) and (B, 3).
    """

    batch: tuple[int, ...]
    bodies: RigidBody
    states: State

    @classmethod
    def of(cls, body: RigidBody, start: State) -> InitialConditions:
        """The initial conditions of a body or a batch of bodies, with the start broadcast to it.

        Raises
        ------
        InputError
            If body and start do not go together; see `batch_shape`.
        """
        batch = batch_shape(body, start)
        tensors = (_flat(tensor, batch, 3, 3) for tensor in (body.inertia, body.inverse_inertia, body.principal_axes))
        bodies = RigidBody.trusted(*tensors, _flat(body.principal_moments, batch, 3))
        return cls(batch, bodies, State.trusted(_flat(start.attitude_xyzw, batch, 4), _flat(start.body_rate, batch, 3)))

    def named(self, place: int, error: InputError) -> InputError:
        """An error about one body, whose index in the batch comes first; without one for a body alone."""
        index = tuple(int(i) for i in np.unravel_index(place, self.batch)) if self.batch else ()
        return InputError(f"body {index[0] if len(index) == 1 else index}: {error}" if index else str(error))


def _flat(values: Array, batch: tuple[int, ...], *own: int) -> Array:
    """Values of shape (..., *own) broadcast to a batch of B elements, as an array of shape (B, *own)."""
    shape = (*batch, *own)
    return (values if values.shape == shape else np.broadcast_to(values, shape)).reshape(-1, *own)


def alike(values: Array, places: Iterable[int]) -> list[list[int]]:
    """Indices along the first axis of ``values``, grouped by rows of the same bits."""
    groups: dict[bytes, list[int]] = {}
    for i in places:
        groups.setdefault(values[i].tobytes(), []).append(i)
    return list(groups.values())


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
    if array.dtype.kind == "u" and array.size and int(array.max()) > np.iinfo(np.int64).max:
        raise InputError(
            f"t_ns {int(array.max())} is beyond int64: give at most {np.iinfo(np.int64).max} ns (292 years)"
        )
    return array.astype(np.int64)


DEFAULT_MEMORY_LIMIT: Final = 4 * 1024**3
"""Memory that one call may take by default, bytes (4 GiB)."""

_LARGEST_BLOCK: Final = 8192
"""Largest number of samples computed at once: their temporaries fit into a processor's cache."""

_SMALLEST_BLOCK: Final = 256
"""Smallest number of samples computed at once: with fewer, calling an array operation takes longer than its work."""

_STATE_BYTES: Final = 7 * 8
"""Bytes of one state: 4 + 3 doubles."""

_FIXED_BYTES: Final = 1024 * 1024
"""Memory of a call that does not depend on bodies, times or samples, bytes; it includes Python's free lists of
tuples."""


@dataclass(frozen=True)
class WorkingMemory:
    """The memory that computing states takes at its peak, beside the states themselves.

    Attributes
    ----------
    body : int
        Bytes for each body.
    time : int
        Bytes for each time.
    sample : int
        Bytes for each sample of the block that is being computed.
    """

    body: int
    time: int
    sample: int


def samples_within(bodies: int, times: int, memory_limit: int, needs: WorkingMemory) -> int:
    """The number of samples to compute at once.

    At most 8192; at least 256 or all samples, whichever is fewer. Otherwise InputError.

    Parameters
    ----------
    bodies, times : int
        The samples are their product.
    memory_limit : int
        Bytes that the states and everything made on the way may take.
    needs : WorkingMemory

    Returns
    -------
    int

    Raises
    ------
    InputError
        If the limit is no integer, or leaves no room for the states and a small block of temporaries.
    """
    fixed = bodies * times * _STATE_BYTES + bodies * needs.body + times * needs.time + _FIXED_BYTES
    least = fixed + needs.sample * min(_SMALLEST_BLOCK, bodies * times)
    require_memory(least, memory_limit, f"{bodies} bodies at {times} times")
    return max(1, min(_LARGEST_BLOCK, (int(memory_limit) - fixed) // needs.sample))


def require_memory(least: int, memory_limit: int, what: str) -> None:
    """Refuse work that does not fit into the memory that a caller allows.

    Parameters
    ----------
    least : int
        Bytes that it takes.
    memory_limit : int
        Bytes that it may take.
    what : str
        What takes them, in the plural.

    Raises
    ------
    InputError
        Also if the limit is no integer.
    """
    if type(plain(memory_limit)) is not int:
        raise InputError(f"memory_limit {shown(memory_limit)} is not a number of bytes: give an integer")
    if memory_limit < least:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {what}, which take {least}: "
            "ask for fewer at once, or give a larger memory_limit"
        )


def states_at(
    starts: InitialConditions,
    t_ns: ArrayLike,
    memory_limit: int,
    needs: WorkingMemory,
    fill: Callable[[Array, Array, Integers, int], None],
) -> State:
    """The states of bodies at some times: shapes (..., 4) and (..., 3), of the batch's axes and that of the times.

    Parameters
    ----------
    starts : InitialConditions
        The states at time 0, which come out as they were given.
    t_ns : int or array_like of int, shape (N,)
    memory_limit : int
        See `samples_within`.
    needs : WorkingMemory
    fill : callable
        ``fill(attitude_xyzw, body_rate, t_ns, block)`` writes the states at all other times, shapes (B, N, 4) and
        (B, N, 3), at most ``block`` samples at once.

    Raises
    ------
    InputError
    """
    times = nanoseconds(t_ns)
    bodies, flat = len(starts.states), np.atleast_1d(times)
    block = samples_within(bodies, times.size, memory_limit, needs)
    attitude, rate = np.empty((bodies, times.size, 4)), np.empty((bodies, times.size, 3))
    fill(attitude, rate, flat, block)
    first, start = np.flatnonzero(flat == 0), starts.states
    attitude[:, first], rate[:, first] = start.attitude_xyzw[:, np.newaxis], start.body_rate[:, np.newaxis]
    shape = (*starts.batch, *times.shape)
    return State.trusted(attitude.reshape(*shape, 4), rate.reshape(*shape, 3))
