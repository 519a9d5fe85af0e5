"""A function that runs compiled as soon as there was enough work to pay for compiling."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Final

from lie_rigid_body.compilation.cache import is_kept
from lie_rigid_body.compilation.compiler import Compiler, fill_together

LONG_CALL: Final = 1_000
"""Units of work: shorter calls do not count. The calls of a live node are shorter: it never starts a compiler."""


class Work:
    """A function, and its compiled form as soon as that pays.

    Parameters
    ----------
    plain : callable
        A function of a module.
    signature : str
        The types of the compiled form as numba writes them.
    enough, enough_to_load : int
        Units of work in long calls after which compiling pays, or loading what was compiled before.
    """

    def __init__(self, plain: Callable[..., None], signature: str, enough: int, enough_to_load: int) -> None:
        self._plain = plain
        self._signature = signature
        self._enough, self._enough_to_load = enough, enough_to_load
        self._may_be_kept = True
        self._compiled: Callable[..., None] | None = None
        self._compiler: Compiler | None = None
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
                compiler = self._compiler or Compiler.of(self._plain, self._signature)
                self._compiled = compiler.result() if compiler else None
                self._compiler, self._may_compile = None, self._compiled is not None
        return self._compiled is not None

    def compiled_for(self, work: int) -> Callable[..., None] | None:
        """The compiled form, after counting this much more work; None if it does not pay yet, is not ready, or numba
        is not installed.

        Work may be counted before it comes, so that all of it is done compiled.
        """
        with self._lock:
            if self._compiled is None and self._compiler is None and self._may_compile and work >= LONG_CALL:
                self._work += work
                if self._pays():
                    self._compiler = Compiler.of(self._plain, self._signature)
                    self._may_compile = self._compiler is not None
        if self._compiler is not None and self._compiler.done:
            self.compile()
        return self._compiled

    def _pays(self) -> bool:
        if self._work >= self._enough:
            return True
        if self._work >= self._enough_to_load and self._may_be_kept:
            self._may_be_kept = False  # looked for once: finding its name takes a while
            return find_spec("numba") is not None and is_kept(self._plain)
        return False


def compile_together(works: Sequence[Work]) -> bool:
    """Wait until functions of one signature are all compiled, or loaded from the cache; False where numba cannot."""
    if missing := [work for work in works if work._compiled is None]:
        fill_together([work._plain for work in missing], missing[0]._signature)
    return sum(work.compile() for work in works) == len(works)
