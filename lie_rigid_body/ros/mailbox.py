"""Calls from other threads, carried out by the one thread that owns the simulation."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, Generic, TypeVar, cast

from lie_rigid_body.errors import BagError, LieRigidBodyError

T = TypeVar("T")


class ClosedError(LieRigidBodyError):
    """The owner has ended and takes no more calls."""


class Call(Generic[T]):
    """A function to call, and the place where its result is awaited.

    Parameters
    ----------
    function : callable
    """

    def __init__(self, function: Callable[[], T]) -> None:
        self._function = function
        self._outcome: Future[T] = Future()

    def carry_out(self) -> None:
        """Call the function. What it raises goes to whoever waits for the result.

        Raises
        ------
        BagError
            Also to the caller: a recording that failed ends the run.
        """
        try:
            self._outcome.set_result(self._function())
        except Exception as error:
            self._outcome.set_exception(error)
            if isinstance(error, BagError):
                raise

    def refuse(self) -> None:
        """Tell whoever waits that nothing will come, unless it has come."""
        if not self._outcome.done():
            self._outcome.set_exception(ClosedError("the node is ending: start it again"))

    def result(self) -> T:
        """Wait for the function's result, or raise what it raised."""
        return self._outcome.result()


class Mailbox:
    """Where other threads leave their calls, and the owner waits for them."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[Call[object]] = SimpleQueue()
        self._unanswered: set[Call[object]] = set()
        self._lock = Lock()
        self._open = True

    def request(self, function: Callable[[], T]) -> T:
        """Have the owner call a function, and wait for the result.

        Raises
        ------
        ClosedError
            If the owner has ended.
        Exception
            What the function raised.
        """
        call: Call[Any] = Call(function)
        with self._lock:
            if not self._open:
                call.refuse()
            else:
                self._unanswered.add(call)
                self._calls.put(call)
        try:
            return cast(T, call.result())
        finally:
            with self._lock:
                self._unanswered.discard(call)

    def wait(self, seconds: float) -> Call[object] | None:
        """The next call, as soon as there is one, or None after a time without any."""
        try:
            return self._calls.get(timeout=seconds) if seconds > 0.0 else self._calls.get_nowait()
        except Empty:
            return None

    def close(self) -> None:
        """Refuse every call without an answer, and all later ones.

        Also those that `wait` has given: a signal may have come before they were carried out.
        """
        with self._lock:
            self._open = False
            for call in self._unanswered:
                call.refuse()
