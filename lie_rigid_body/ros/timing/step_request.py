"""A request to send samples while simulated time stands still."""

from __future__ import annotations

from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet

from lie_rigid_body.errors import LieRigidBodyError


class ControlError(LieRigidBodyError):
    """A request that the run cannot fulfil in its present state."""


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
