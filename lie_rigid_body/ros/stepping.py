"""Samples that were asked for while time stands still."""

from __future__ import annotations

from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet

from lie_rigid_body.errors import LieRigidBodyError


class ControlError(LieRigidBodyError):
    """What the run cannot do in its present state."""


class Stepping:
    """A request for samples, and the place where its end is awaited.

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
        """Note which sample comes next."""
        self.completed = min(self.total, next_sample - self._first)
        if self.completed == self.total and not self._end.done():
            self._end.set_result(self.total)

    def abandon(self, why: str) -> None:
        """Tell whoever waits that the rest will not come, unless all has come."""
        if not self._end.done():
            self._end.set_exception(ControlError(f"{why} after {self.completed} of {self.total} steps"))

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the end, or for a time; return whether all samples were sent.

        Raises
        ------
        ControlError
            If the rest will not come.
        """
        try:
            self._end.result(seconds)
        except NotYet:  # before Python 3.11 not the built-in one
            return False
        return True
