"""A loop over samples that advances a state in steps: in Python until there was much work, compiled from then on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final, TypeVar

import numpy as np

from lie_rigid_body.compilation.compiler import compiled
from lie_rigid_body.foundation.arrays import Array, Integers

MAX_LIVE_SAMPLES: Final = 64
"""Largest number of samples that a live node asks for at once: it never waits for a compiler."""

MAX_LIVE_STEPS: Final = 1_000
"""Number of steps in a call that is longer than those of a live node."""

MIN_STEPS_TO_COMPILE: Final = 50_000
"""Number of steps from which on compiled code pays: Python takes a second for so many, and numba half of one to load
what was compiled once."""

MAX_STEPS_AT_ONCE: Final = 100_000
"""Largest number of steps in one call of compiled code, which lets no signal through: a hundredth of a second."""

State = TypeVar("State")


class StepLoop:
    """A loop over samples that advances a state.

    Parameters
    ----------
    plain : callable
        A function of the state and the constants, which are named tuples of floats, and of ``spans``, ``counts``,
        ``takes`` and ``out``. The three are integers for each sample: the time since the one before, ns, the steps that
        divide it, and how many of these it is to take. It fills a row of the array ``out`` for each sample, and returns
        the state at the end in plain tuples. Numba would make named ones by Python code, and crash where the handler of
        a signal raises an exception in it.
    named : callable
        A function of these plain tuples, which returns the state.
    """

    def __init__(self, plain: Callable[..., Any], named: Callable[[Any], Any]) -> None:
        self._plain = plain
        self._named = named
        self._compiled: Callable[..., Any] | None = None
        self._may_compile = True
        self._steps = 0

    def __reduce__(self) -> tuple[type[StepLoop], tuple[Callable[..., Any], Callable[[Any], Any]]]:
        """The functions: a copy counts its own work, and the compiled form stays in the cache for both."""
        return StepLoop, (self._plain, self._named)

    def run(self, state: State, constants: Any, spans: Integers, counts: Integers, out: Array) -> State:
        """The state after all samples, of which each fills a row of ``out``.

        Parameters
        ----------
        state, constants : namedtuple
        spans, counts : ndarray of int64, shape (N,)
            Time since the sample before, ns, and the number of steps that divide it.
        out : ndarray, shape (N, K)
        """
        steps = int(counts.sum())
        self._steps += steps if len(counts) > MAX_LIVE_SAMPLES or steps >= MAX_LIVE_STEPS else 0
        if self._steps >= MIN_STEPS_TO_COMPILE:
            self.compile(state, constants)
        for some, takes in _pieces(counts):
            pieces = spans[some], counts[some], takes
            if self._compiled is None:
                found = self._plain(state, constants, *(piece.tolist() for piece in pieces), out[some])
            else:
                found = self._compiled(state, constants, *pieces, out[some])
            state = self._named(found)
        return state

    def compile(self, state: Any, constants: Any) -> bool:
        """Compile the loop for these types, or load it from the cache; False where numba cannot do it."""
        if self._compiled is None and self._may_compile:
            integers = np.empty(0, dtype=np.int64)
            arguments = (state, constants, integers, integers, integers, np.empty((0, 0)))
            self._compiled = compiled(self._plain, arguments)
            self._may_compile = self._compiled is not None
        return self._compiled is not None


def _pieces(counts: Integers) -> Iterator[tuple[slice, Integers]]:
    """Short pieces of the work: samples and the steps to take in them; a sample of many steps is many pieces."""
    ends = np.cumsum(counts)
    begin = 0
    done = 0
    while begin < len(counts):
        limit = done + MAX_STEPS_AT_ONCE
        end = max(begin + 1, int(np.searchsorted(ends, limit, side="right")))
        some = slice(begin, end)
        yield some, np.minimum(ends[some], limit) - np.maximum(ends[some] - counts[some], done)
        done = min(int(ends[end - 1]), limit)
        begin = int(np.searchsorted(ends, done, side="right"))
