"""The states of motions of one kind at many times: few samples in floats, more on arrays, very many compiled.

The formulas are those of `states` in every case, and so are the bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from lie_rigid_body.arithmetic.double_double import from_integer, from_integers
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.motion.closed_form.motion_parameters import Members
from lie_rigid_body.motion.closed_form.states import KINDS, WORK_AREA, Kind

MOST_SAMPLES_IN_FLOATS: Final = 16
"""Largest number of samples computed one by one, in floats, which is faster than on arrays."""

SAMPLES_PER_CALL: Final = 4_000_000
"""Largest number of samples in one call of compiled code, which lets no signal through."""


def compile_all() -> bool:
    """Compile the functions of every kind now, for what is to be timed or compared; whether numba is there to do it."""
    return all(kind.work.compile() for kind in KINDS)


@dataclass(frozen=True)
class Evaluation:
    """Motions of one kind, ready to be evaluated.

    Attributes
    ----------
    kind : Kind
    table : ndarray, shape (constants, B)
        Their rows of constants, side by side.
    members : ndarray of int, shape (B,)
        Their places in the ensemble.
    """

    kind: Kind
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
    for some in _slices(bodies, most // breadth):
        for part in _slices(times, breadth):
            yield some, part


def _slices(length: int, step: int) -> Iterator[slice]:
    return (slice(begin, min(begin + step, length)) for begin in range(0, length, max(step, 1)))
