"""Code that runs compiled from when it pays."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

from lie_rigid_body.compilation.compiler import Compiler

LONG_CALL: Final = 1_000
"""Steps: shorter calls do not count. Those of a live node are shorter, and it cannot wait for a compiler."""


class Work:
    """A piece of code, and its compiled form from when much of it was called for.

    Parameters
    ----------
    plain : callable
        A function of a module.
    signature : str
        Numba's, of the compiled form.
    enough : int
        Units of work in long calls after which compiled code pays.
    """

    def __init__(self, plain: Callable[..., None], signature: str, enough: int) -> None:
        self._plain = plain
        self._signature = signature
        self._enough = enough
        self._compiled: Callable[..., None] | None = None
        self._compiler: Compiler | None = None
        self._lock = threading.RLock()
        self._work = 0
        self._may_compile = True

    def compile(self) -> bool:
        """Compile, or load what was compiled before, and wait for it; whether numba is there to do it."""
        with self._lock:
            if self._compiled is None and self._may_compile:
                compiler = self._compiler or Compiler.of(self._plain, self._signature)
                self._compiled = compiler.result() if compiler else None
                self._compiler, self._may_compile = None, self._compiled is not None
        return self._compiled is not None

    def compiled_for(self, work: int) -> Callable[..., None] | None:
        """The compiled form, or None where this much more work does not make it pay, it is not ready, or there is no
        numba.
        """
        with self._lock:
            if self._compiled is None and self._compiler is None and self._may_compile and work >= LONG_CALL:
                self._work += work
                if self._work >= self._enough:
                    self._compiler = Compiler.of(self._plain, self._signature)
                    self._may_compile = self._compiler is not None
        if self._compiler is not None and self._compiler.done:
            self.compile()
        return self._compiled
