"""The states of motions side by side: of few samples in floats, of many on arrays, of very many compiled.

The formulas are the same, and the bits are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.double_double import DoubleDouble, from_integer, from_integers
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.arrays import Array
from lie_rigid_body.compilation import Work
from lie_rigid_body.motion.closed_form import circular_states, hyperbolic_states, separatrix_states, steady_states
from lie_rigid_body.motion.closed_form.circular_wave import CircularWave
from lie_rigid_body.motion.closed_form.clock import Clock
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.hyperbolic_wave import HyperbolicWave
from lie_rigid_body.motion.closed_form.samples import BLOCK, COLUMNS, SIGNATURE, Sample
from lie_rigid_body.motion.closed_form.steady_motion import SteadyMotion

BodyMotion: TypeAlias = SteadyMotion | GeneralMotion

FEW: Final = 16
"""Samples that are sooner computed one by one."""

LONG_WORK: Final = 5_000_000
"""Samples in long calls after which compiled code pays: a second of arrays, while numba loads in half of one, and
compiles in two, once."""

AT_ONCE: Final = 4_000_000
"""Samples of compiled code between two looks at signals."""


@dataclass(frozen=True)
class Formulas:
    """How the states of one kind of motion are computed.

    Attributes
    ----------
    constants : callable
        What a row of numbers says.
    state : callable
        The sample of these constants at a time.
    work : Work
        The loop that is compiled.
    """

    constants: Callable[[Sequence[Number]], Any]
    state: Callable[[Any, DoubleDouble], Sample]
    work: Work


CIRCULAR: Final = Formulas(
    circular_states.circular, circular_states.circular_state, Work(circular_states.fill, SIGNATURE, LONG_WORK)
)
HYPERBOLIC: Final = Formulas(
    hyperbolic_states.hyperbolic,
    hyperbolic_states.hyperbolic_state,
    Work(hyperbolic_states.fill, SIGNATURE, LONG_WORK),
)
SEPARATRIX: Final = Formulas(
    separatrix_states.separatrix,
    separatrix_states.separatrix_state,
    Work(separatrix_states.fill, SIGNATURE, LONG_WORK),
)
STEADY: Final = Formulas(
    steady_states.steady, steady_states.steady_state, Work(steady_states.fill, SIGNATURE, LONG_WORK)
)

KINDS: Final = (CIRCULAR, HYPERBOLIC, SEPARATRIX, STEADY)


def compile_all() -> bool:
    """Compile every loop now, for what is to be timed or compared; whether numba is there to do it."""
    return sum(kind.work.compile() for kind in KINDS) == len(KINDS)


def formulas_and_row(motion: BodyMotion) -> tuple[Formulas, list[Number]]:
    """The formulas of a motion, and its constants in a row: of many motions, if its numbers are arrays."""
    if isinstance(motion, SteadyMotion):
        return STEADY, steady_states.steady_row(motion)
    wave, clock = motion.wave, motion.polhode_clock
    if isinstance(wave, CircularWave):
        return CIRCULAR, circular_states.circular_row(motion, wave)
    assert isinstance(wave, HyperbolicWave)
    if isinstance(clock, Clock):
        return HYPERBOLIC, hyperbolic_states.hyperbolic_row(motion, wave, clock.period)
    return SEPARATRIX, separatrix_states.separatrix_row(motion, wave)


@dataclass(frozen=True)
class Evaluation:
    """Motions of one kind, ready to be evaluated.

    Attributes
    ----------
    formulas : Formulas
    table : ndarray, shape (constants, B)
    members : ndarray of int, shape (B,)
        Their places in the ensemble.
    """

    formulas: Formulas
    table: Array
    members: NDArray[np.intp]

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: NDArray[np.int64], block: int) -> None:
        """Write the states into arrays of shapes (bodies, N, 4) and (bodies, N, 3).

        Parameters
        ----------
        attitude_xyzw, body_rate : ndarray
        t_ns : ndarray of int64, shape (N,)
        block : int
            Samples on arrays at once.
        """
        samples = len(self.members) * len(t_ns)
        compiled = self.formulas.work.compiled_for(samples)
        if compiled is not None:
            self._run(compiled, attitude_xyzw, body_rate, t_ns)
        elif 0 < samples <= FEW:
            self._one_by_one(attitude_xyzw, body_rate, t_ns.tolist())
        elif samples:
            self._by_blocks(attitude_xyzw, body_rate, t_ns, block)

    def _run(self, compiled: Any, attitude_xyzw: Array, body_rate: Array, t_ns: NDArray[np.int64]) -> None:
        columns = np.empty(COLUMNS * BLOCK)
        for some, times in _pieces(len(self.members), len(t_ns), AT_ONCE):
            table, members = self.table[:, some], self.members[some]
            compiled(table, members, t_ns[times], attitude_xyzw, body_rate, columns, times.start)

    def _one_by_one(self, attitude_xyzw: Array, body_rate: Array, t_ns: list[int]) -> None:
        times = [from_integer(t) for t in t_ns]
        for row, member in zip(self.table.T.tolist(), self.members.tolist(), strict=True):
            constants = self.formulas.constants(row)
            samples = [self.formulas.state(constants, time) for time in times]
            attitude_xyzw[member] = [sample[:4] for sample in samples]
            body_rate[member] = [sample[4:] for sample in samples]

    def _by_blocks(self, attitude_xyzw: Array, body_rate: Array, t_ns: NDArray[np.int64], block: int) -> None:
        for some, times in _pieces(len(self.members), len(t_ns), block):
            members = self.members[some]
            sample = self.formulas.state(self._constants(some), from_integers(t_ns[times]))
            for k in range(4):
                attitude_xyzw[members, times, k] = sample[k]
            for k in range(3):
                body_rate[members, times, k] = sample[4 + k]

    def _constants(self, some: slice) -> Any:
        """Of one motion as floats, of many as columns."""
        if some.stop - some.start == 1:
            return self.formulas.constants(self.table[:, some.start].tolist())
        return self.formulas.constants(list(self.table[:, some, np.newaxis]))


def _pieces(bodies: int, times: int, most: int) -> Iterator[tuple[slice, slice]]:
    """Some of the bodies and some of the times, in pieces of so many samples at most."""
    breadth = max(1, min(times, most))
    for some in _slices(bodies, most // breadth):
        for part in _slices(times, breadth):
            yield some, part


def _slices(length: int, step: int) -> Iterator[slice]:
    return (slice(begin, min(begin + step, length)) for begin in range(0, length, max(step, 1)))
