"""Work that another thread does aside, while its caller goes on."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, Generic, TypeVar

A = TypeVar("A")


class Aside(Generic[A]):
    """Calls of a function that another thread does one after the other. At most one waits.

    As a context it ends with the last of them; then, or by the next call, an error of one is raised in this thread.

    Parameters
    ----------
    function : callable
    is_worth_it : bool
        Otherwise this thread does them.
    """

    def __init__(self, function: Callable[[A], object], *, is_worth_it: bool) -> None:
        self._function = function
        self._thread = ThreadPoolExecutor(1) if is_worth_it else None
        self._pending: Future[Any] | None = None

    def __call__(self, argument: A) -> None:
        """Have the function called."""
        if self._thread is None:
            self._function(argument)
            return
        self._wait()
        self._pending = self._thread.submit(self._function, argument)

    def _wait(self) -> None:
        pending, self._pending = self._pending, None
        if pending is not None:
            pending.result()

    def __enter__(self) -> Aside[A]:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        try:
            if error is None:
                self._wait()
        finally:
            if self._thread is not None:
                self._thread.shutdown()
