"""Work that another thread does aside, while its caller goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

A = TypeVar("A")


@contextmanager
def aside(function: Callable[[A], object], *, is_worth_it: bool) -> Iterator[Callable[[A], object]]:
    """Calls of a function that another thread does one after the other; at most one waits.

    The context ends with the last of them. Then, or by the next call, an error of one is raised in this thread.

    Parameters
    ----------
    function : callable
    is_worth_it : bool
        Otherwise this thread does them.

    Yields
    ------
    callable
        Has the function called with an argument.
    """
    if not is_worth_it:
        yield function
        return
    pending: list[Future[Any]] = []

    def call(argument: A) -> None:
        while pending:
            pending.pop().result()
        pending.append(thread.submit(function, argument))

    with ThreadPoolExecutor(1) as thread:
        yield call
    for last in pending:
        last.result()
