"""The contract between a live run and what receives its samples: topics, a bag, diagnostics, markers, transforms."""

from __future__ import annotations

from typing import Final, Protocol

from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.simulation import Segment

FOREVER: Final = 2**63
"""A time longer than any wait, and later than any stamp, ns."""
MAX_BATCH: Final = 250
"""Largest number of samples of the truth, or readings of one sensor, in a batch. Publishers keep four times as many."""


@short_dataclass
class Punctuality:
    """Counts of the samples that a run has sent so far, and their lateness.

    Parameters
    ----------
    sent : int
        Samples of the truth sent.
    missed : int
        Samples sent more than a sample period, or a millisecond if that is longer, after they were due.
    lateness_ns : int
        Lateness of the latest batch's first sample, ns.
    worst_ns : int
        Greatest lateness so far, ns.
    """

    sent: int = 0
    missed: int = 0
    lateness_ns: int = 0
    worst_ns: int = 0

    def after(self, sent: int, missed: int, lateness_ns: int) -> Punctuality:
        """The punctuality after another batch.

        Parameters
        ----------
        sent, missed : int
            Samples in the batch, and those of them that were late.
        lateness_ns : int
            Lateness of its first sample, ns.
        """
        worst = max(self.worst_ns, lateness_ns)
        return Punctuality(self.sent + sent, self.missed + missed, lateness_ns, worst)


class Sink(Protocol):
    """A receiver of samples. All methods are called by the thread of the run, in the order of the stamps."""

    def begin_segment(self, segment: Segment) -> None:
        """Take the segment that the next samples belong to, at the start and at each reset."""

    def write(self, batch: Batch) -> None:
        """Take messages, at most `MAX_BATCH` of a kind. Called only when every sink is ready."""

    def ready(self) -> bool:
        """Whether there is room for another batch. A sink that always has room leaves this as it is."""
        return True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Do periodic work; called in each turn of the run's loop. A sink without such work leaves this as it is.

        Parameters
        ----------
        steady_ns : int
            Present time of the steady clock, ns.
        punctuality : Punctuality
            Punctuality of the run so far.

        Returns
        -------
        int
            The longest time until the next call, ns.
        """
        return FOREVER


class Periodic(Sink):
    """A sink that keeps the latest state, and does something once in an interval of the steady clock.

    Attributes
    ----------
    interval_ns : int
        That interval, ns.
    latest : tuple of (int, State), or None
        Stamp, ns, and state of the latest sample.
    """

    interval_ns: int
    latest: tuple[int, State] | None = None
    _due_ns: int | None = None

    def write(self, batch: Batch) -> None:
        """Keep the latest state."""
        if len(batch.samples):
            self.latest = int(batch.samples.stamps_ns[-1]), batch.samples.states[-1]

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Do it when it is due, one interval after the first turn of the loop if not before."""
        if self._due_ns is None:
            self._due_ns = steady_ns + self.interval_ns
        if steady_ns >= self._due_ns:
            self._due_ns = steady_ns + self.interval_ns
            self.act(steady_ns, punctuality)
        return self._due_ns - steady_ns

    def act(self, steady_ns: int, punctuality: Punctuality) -> None:
        """Do what is due; see `tick`."""
