"""A function that runs compiled as soon as there was enough work to pay for compiling."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Callable
from typing import Final

from lie_rigid_body.compilation.cache import is_kept
from lie_rigid_body.compilation.compiler import loaded, started

LONG_CALL: Final = 1_000
"""Smallest number of units of work in a call that counts: those of a live node are shorter and start no compiler."""


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
