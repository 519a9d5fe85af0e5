"""A function that runs compiled as soon as there was enough work to pay for compiling, and such a loop over samples."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from lie_rigid_body.compilation.cache import is_kept
from lie_rigid_body.compilation.compiler import loaded, started
from lie_rigid_body.foundation.arrays import Array, Integers

LONG_CALL: Final = 1_000
"""Smallest number of units of work in a call that counts: those of a live node are shorter and start no compiler."""

STEPS_FOR_COMPILING: Final = 150_000
"""Number of steps in long calls from which on compiling pays: Python takes two seconds for so many, compiling four,
once."""

STEPS_FOR_LOADING: Final = 40_000
"""Number of steps from which on loading compiled code pays: Python takes as long for so many as numba to load."""

STEPS_PER_CALL: Final = 1_000_000
"""Largest number of steps in one call of compiled code, which lets no signal through: a tenth of a second."""

STEPS_IN_PYTHON: Final = 20_000
"""Largest number of steps in one call of plain code; after each call the compiler is asked whether it is done."""

SIGNATURE: Final = "void(float64[::1], float64[::1], int64[::1], int64[::1], int64[::1], float64[:,::1])"


class Work:
    """A function, and its compiled form as soon as that pays.

    Until then, and without numba, the work is done in Python: another process compiles, so that nothing waits.

    Parameters
    ----------
    plain : callable
        A function of a module.
    signature : str
        Types of the compiled form as numba writes them.
    enough, enough_to_load : int
        Units of work in long calls after which compiling pays, or loading what was compiled before.
    """

    def __init__(self, plain: Callable[..., None], signature: str, enough: int, enough_to_load: int) -> None:
        self._plain = plain
        self._signature = signature
        self._enough, self._enough_to_load = enough, enough_to_load
        self._compiled: Callable[..., None] | None = None
        self._compiler: subprocess.Popen[bytes] | None = None
        self._lock = threading.RLock()
        self._work = 0
        self._may_compile = True

    def __reduce__(self) -> tuple[type[Work], tuple[Callable[..., None], str, int, int]]:
        """The plain function: a copy counts its own work, and the compiled form stays in the cache for both."""
        return Work, (self._plain, self._signature, self._enough, self._enough_to_load)

    def compile(self) -> bool:
        """Wait until the function is compiled, or loaded from the cache; False where numba cannot do it."""
        with self._lock:
            if self._compiled is None and self._may_compile:
                compiler = self._compiler or started(self._plain, self._signature)
                if compiler is None or compiler.wait() == 0:
                    self._compiled = loaded(self._plain, self._signature)
                self._may_compile = self._compiled is not None
        return self._compiled is not None

    def compiled_for(self, work: int) -> Callable[..., None] | None:
        """The compiled form, after counting this much more work; None as long as it does not pay or is not ready."""
        with self._lock:
            if self._compiled is None and self._may_compile:
                self._count(work if work >= LONG_CALL else 0)
                if self._compiler is not None and self._compiler.poll() is not None:
                    self.compile()
        return self._compiled

    def _count(self, work: int) -> None:
        """Count work, and where there is enough of it now, load or compile the function."""
        before, self._work = self._work, self._work + work
        if before < self._enough_to_load <= self._work and is_kept(self._plain):
            self.compile()
        elif before < self._enough <= self._work:
            self._compiler = started(self._plain, self._signature)
            if self._compiler is None:
                self.compile()


class Loop(Work):
    """A loop over samples that advances a state, in Python until there was much work, compiled from then on.

    Parameters
    ----------
    plain : callable
        A function of ``state`` (list or array of float, changed in place), ``constants`` (floats), ``spans``,
        ``counts``, ``takes`` and ``out`` (array with a row for each sample). The three before ``out`` are integers for
        each sample. They are the time since the sample before, ns, the number of steps that divide it, and how many of
        these to take now.
    """

    def __init__(self, plain: Callable[..., None]) -> None:
        super().__init__(plain, SIGNATURE, STEPS_FOR_COMPILING, STEPS_FOR_LOADING)

    def __reduce__(self) -> tuple[Any, ...]:
        return Loop, (self._plain,)

    def run(
        self,
        state: list[float],
        constants: list[float],
        spans: Integers,
        counts: Integers,
        out: Array,
        work: int | None = None,
    ) -> None:
        """Advance the state, and fill a row of ``out`` for each sample.

        Parameters
        ----------
        state : list of float
            Changed in place.
        constants : list of float
        spans, counts : ndarray of int64, shape (N,)
            Time since the sample before, ns, and the number of steps that divide it.
        out : ndarray, shape (N, K)
        work : int, optional
            Steps that this call counts as when it is judged whether compiling pays; by default its own. Of many calls
            that make one piece of work, the first may count as all of them.
        """
        compiled = self.compiled_for(int(counts.sum()) if work is None else work)
        for some, takes in self._pieces(counts):
            compiled = compiled or self.compiled_for(0)
            if compiled is None:
                self._plain(state, constants, spans[some].tolist(), counts[some].tolist(), takes.tolist(), out[some])
                continue
            moved, fixed = np.array(state), np.array(constants)
            compiled(moved, fixed, spans[some], counts[some], takes, out[some])
            state[:] = moved.tolist()

    def _pieces(self, counts: Integers) -> Iterator[tuple[slice, Integers]]:
        """Short pieces of the work: samples and the steps to take in them; a sample of many steps is many pieces."""
        ends, begin, done = np.cumsum(counts), 0, 0
        while begin < len(counts):
            limit = done + (STEPS_PER_CALL if self._compiled else STEPS_IN_PYTHON)
            end = max(begin + 1, int(np.searchsorted(ends, limit, side="right")))
            some = slice(begin, end)
            yield some, np.minimum(ends[some], limit) - np.maximum(ends[some] - counts[some], done)
            done = min(int(ends[end - 1]), limit)
            begin = int(np.searchsorted(ends, done, side="right"))
