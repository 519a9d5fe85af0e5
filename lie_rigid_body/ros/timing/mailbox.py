"""Function calls from other threads, carried out by the one thread that owns the simulation."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, Generic, ParamSpec, TypeVar, cast

from lie_rigid_body.errors import LieRigidBodyError

P = ParamSpec("P")
T = TypeVar("T")


class ClosedError(LieRigidBodyError):
    """The owner of the mailbox has ended, and takes no more calls."""


class Call(Generic[T]):
    """A function for the owner to call, and a future of its result.

    Parameters
    ----------
    function : callable

    Attributes
    ----------
    outcome : Future
        What the function returned or raised, for the thread that waits.
    """

    def __init__(self, function: Callable[[], T]) -> None:
        self._function = function
        self.outcome: Future[T] = Future()

    def carry_out(self) -> None:
        """Call the function. The waiting thread gets its result, or what it raised."""
        try:
            self.outcome.set_result(self._function())
        except Exception as error:
            self.outcome.set_exception(error)

    def refuse(self) -> None:
        """Raise ClosedError in the waiting thread, unless the function was called."""
        if not self.outcome.done():
            self.outcome.set_exception(ClosedError("the node is ending: start it again"))


class Mailbox:
    """A queue of calls: other threads request them, the owner waits for them and carries them out."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[Call[object]] = SimpleQueue()
        self._unanswered: set[Call[object]] = set()
        self._lock = Lock()
        self._open = True

    def request(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Have the owner call a function; wait for the result, and return it.

        Parameters
        ----------
        function : callable
        *args, **kwargs
            Arguments for the function.

        Raises
        ------
        ClosedError
            If the owner has ended.
        Exception
            Whatever the function raised.
        """
        call: Call[Any] = Call(partial(function, *args, **kwargs))
        with self._lock:
            if not self._open:
                call.refuse()
            else:
                self._unanswered.add(call)
                self._calls.put(call)
        try:
            return cast(T, call.outcome.result())
        finally:
            with self._lock:
                self._unanswered.discard(call)

    def post(self, function: Callable[[], object]) -> None:
        """Have the owner call a function that raises nothing, without waiting for it."""
        self._calls.put(Call(function))

    def wait(self, seconds: float) -> Call[object] | None:
        """The next call as soon as there is one, or None after so many seconds."""
        try:
            return self._calls.get(timeout=seconds) if seconds > 0.0 else self._calls.get_nowait()
        except Empty:
            return None

    def close(self) -> None:
        """Refuse every call that has no result yet, and all later ones.

        Calls that `wait` has returned count as well: a signal may have come before they were carried out.
        """
        with self._lock:
            self._open = False
            for call in self._unanswered:
                call.refuse()
