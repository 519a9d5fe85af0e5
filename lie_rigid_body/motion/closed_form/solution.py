"""The closed form as a motion: states at any times from bodies and starts.

Motions of one kind are evaluated together: few samples in floats, more on arrays, very many compiled. The formulas are
those of `states` in every case, and so are the bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arithmetic.double_double import from_integer, from_integers
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.attitude import BodyMotion, Members
from lie_rigid_body.motion.closed_form.decimal_constants import decimal_motions
from lie_rigid_body.motion.closed_form.fast_constants import fast_motions
from lie_rigid_body.motion.closed_form.states import MOTION_KINDS, WORK_AREA, KindOfMotion, kind_and_row
from lie_rigid_body.motion.motion import (
    DEFAULT_MEMORY_LIMIT,
    InitialConditions,
    WorkingMemory,
    states_at,
)

MOST_SAMPLES_IN_FLOATS: Final = 16
"""Largest number of samples computed one by one, in floats, which is faster than on arrays."""

SAMPLES_PER_CALL: Final = 4_000_000
"""Largest number of samples in one call of compiled code, which lets no signal through."""

_WORKING_MEMORY: Final = WorkingMemory(body=0, time=8, sample=512)
"""Bytes beside the states; a sample being computed takes 340 to 420 bytes, by measurement."""


def compile_all() -> bool:
    """Compile the functions of every kind now, for what is to be timed or compared; whether numba is there to do it."""
    return all(kind.work.compile() for kind in MOTION_KINDS)


@dataclass(frozen=True)
class Evaluation:
    """Motions of one kind, ready to be evaluated.

    Attributes
    ----------
    kind : KindOfMotion
    table : ndarray, shape (constants, B)
        Their rows of constants, side by side.
    members : ndarray of int, shape (B,)
        Their places in the ensemble.
    """

    kind: KindOfMotion
    table: Array
    members: Members

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        """Write the states into arrays of shapes (bodies, N, 4) and (bodies, N, 3).

        Parameters
        ----------
        attitude_xyzw, body_rate : ndarray
        t_ns : ndarray of int64, shape (N,)
        block : int
            Largest number of samples on arrays at once.
        """
        samples = len(self.members) * len(t_ns)
        compiled = self.kind.work.compiled_for(samples)
        if compiled is not None:
            self._compiled(compiled, attitude_xyzw, body_rate, t_ns)
        elif 0 < samples <= MOST_SAMPLES_IN_FLOATS:
            self._one_by_one(attitude_xyzw, body_rate, t_ns.tolist())
        elif samples:
            self._by_blocks(attitude_xyzw, body_rate, t_ns, block)

    def _compiled(self, compiled: Any, attitude_xyzw: Array, body_rate: Array, t_ns: Integers) -> None:
        columns = np.empty(WORK_AREA)
        for some, times in _pieces(len(self.members), len(t_ns), SAMPLES_PER_CALL):
            table, members = self.table[:, some], self.members[some]
            compiled(table, members, t_ns[times], attitude_xyzw, body_rate, columns, times.start)

    def _one_by_one(self, attitude_xyzw: Array, body_rate: Array, t_ns: list[int]) -> None:
        times = [from_integer(t) for t in t_ns]
        for row, member in zip(self.table.T.tolist(), self.members.tolist(), strict=True):
            constants = self.kind.constants(row)
            samples = [self.kind.sample(constants, time) for time in times]
            attitude_xyzw[member] = [sample[:4] for sample in samples]
            body_rate[member] = [sample[4:] for sample in samples]

    def _by_blocks(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        for some, times in _pieces(len(self.members), len(t_ns), block):
            members = self.members[some]
            sample = self.kind.sample(self._constants(some), from_integers(t_ns[times]))
            for k in range(4):
                attitude_xyzw[members, times, k] = sample[k]
            for k in range(3):
                body_rate[members, times, k] = sample[4 + k]

    def _constants(self, some: slice) -> Any:
        """The constants of one motion as floats, of many as columns, which broadcast with times."""
        if some.stop - some.start == 1:
            return self.kind.constants(self.table[:, some.start].tolist())
        return self.kind.constants(list(self.table[:, some, np.newaxis]))


def _pieces(bodies: int, times: int, most: int) -> Iterator[tuple[slice, slice]]:
    """Slices of the bodies and of the times that together cover all, each of at most ``most`` samples."""
    breadth = max(1, min(times, most))
    return product(_slices(bodies, most // breadth), _slices(times, breadth))


def _slices(length: int, step: int) -> Iterator[slice]:
    return (slice(begin, min(begin + step, length)) for begin in range(0, length, max(step, 1)))


def evaluations(starts: InitialConditions) -> list[Evaluation]:
    """The motions of bodies from their starts, those of a kind together."""
    by_kind: dict[KindOfMotion, list[tuple[Array, Members]]] = {}
    for motion, members in _motions(starts):
        kind, row = kind_and_row(motion)
        by_kind.setdefault(kind, []).append((_table(row, len(members)), members))
    return [_evaluation(kind, parts) for kind, parts in by_kind.items()]


def _motions(starts: InitialConditions) -> Iterator[tuple[BodyMotion, Members]]:
    """Every motion with its place in the ensemble; those that are computed together, as one with its places."""
    rest = np.ones(len(starts.states), dtype=np.bool_)
    for motion, members in fast_motions(starts):
        rest[members] = False
        yield motion, members
    yield from decimal_motions(starts, np.flatnonzero(rest))


def _table(row: list[Number], count: int) -> Array:
    """The constants of ``count`` motions, shape (constants, count)."""
    if count == 1:
        return np.array(row, dtype=np.float64).reshape(-1, 1)
    return np.stack([np.broadcast_to(entry, count) for entry in row])


def _evaluation(kind: KindOfMotion, parts: list[tuple[Array, Members]]) -> Evaluation:
    tables, members = zip(*parts, strict=True)
    return Evaluation(kind, np.concatenate(tables, axis=1), np.concatenate(members))


class ClosedForm:
    """Torque-free motion by its exact solution in theta functions, of one body or of an ensemble.

    The constants of a motion are computed once, mostly in double-double. Near a separatrix, and for extreme sizes,
    decimal arithmetic of 50 digits or more computes them. A state costs a fixed number of elementwise operations,
    whatever the time. The errors do not grow with time: the body and the start are taken as exactly the given doubles,
    and phases are reduced in double-double.

    Parameters
    ----------
    body : RigidBody
        One, or a batch.
    start : State
        One state, or one for each body. The batches broadcast; a single one goes with every other.

    Raises
    ------
    InputError
        If the body is no RigidBody, the start no State, or their batches do not go together.
    """

    __slots__ = ("_evaluations", "_starts")

    def __init__(self, body: RigidBody, start: State) -> None:
        self._starts = InitialConditions.of(body, start)
        self._evaluations = evaluations(self._starts)

    def __repr__(self) -> str:
        batch, start = self._starts.batch, self._starts.states
        shape = {"bodies": batch} if batch else {}
        own = slice(None) if batch else 0
        return call_repr(self, {**shape, "attitude_xyzw": start.attitude_xyzw[own], "body_rate": start.body_rate[own]})

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
        return states_at(self._starts, t_ns, memory_limit, _WORKING_MEMORY, self._fill)

    def _fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        for evaluation in self._evaluations:
            evaluation.fill(attitude_xyzw, body_rate, t_ns, block)
