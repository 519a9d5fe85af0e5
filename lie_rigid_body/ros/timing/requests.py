"""Requests of other threads to the one that owns the simulation: calls, and steps while time stands still."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from functools import partial
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, Generic, ParamSpec, TypeVar, cast

from lie_rigid_body.foundation.errors import LieRigidBodyError

P = ParamSpec("P")
T = TypeVar("T")


class ClosedError(LieRigidBodyError):
    """The owner of the mailbox has ended, and takes no more calls."""


class ControlError(LieRigidBodyError):
    """A request that the run cannot fulfil in its present state."""


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


class StepRequest:
    """A number of samples to send while paused. The run counts them; any other thread may wait for the last.

    Parameters
    ----------
    first : int
        Number of the first sample.
    total : int
        How many samples were asked for.

    Attributes
    ----------
    completed : int
        How many were sent so far.
    """

    def __init__(self, first: int, total: int) -> None:
        self.total = total
        self.completed = 0
        self._first = first
        self._end: Future[int] = Future()

    def advance(self, next_sample: int) -> None:
        """Count the samples before ``next_sample`` as sent."""
        self.completed = min(self.total, next_sample - self._first)
        if self.completed == self.total and not self._end.done():
            self._end.set_result(self.total)

    def abandon(self, why: str) -> None:
        """Raise ControlError in every thread that waits, unless all samples were sent."""
        if not self._end.done():
            self._end.set_exception(
                ControlError(f"{why} after {self.completed} of {self.total} steps: ask for the rest again")
            )

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the last sample, for at most a time; return whether all were sent.

        Raises
        ------
        ControlError
            If the request was abandoned.
        """
        try:
            self._end.result(seconds)
        except NotYet:  # before Python 3.11 not the built-in one
            return False
        return True
