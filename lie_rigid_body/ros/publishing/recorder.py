"""The bag of a live run: on the disk it lacks at most the samples of the last half second."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.timing.pace import FOREVER
from lie_rigid_body.ros.timing.sink import Punctuality, Sink
from lie_rigid_body.simulation import Segment

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_writer import BagWriter

FLUSH_INTERVAL_NS: Final = 500_000_000
"""Steady time between two flushes of the bag, ns: a crash may cost one second of samples, and half of it is left for
what a busy machine does late."""
MANY_STEPS: Final = 20_000
"""Steps between two samples from which on each sample is flushed: they take some tenths of a second, without a tick."""


class Recorder(Sink):
    """A sink into a bag. It ends the chunks of the bag by the steady clock.

    Parameters
    ----------
    bag : BagWriter
    """

    def __init__(self, bag: BagWriter) -> None:
        self._bag = bag
        self._unflushed = False
        self._interval_ns = FLUSH_INTERVAL_NS
        self._flush_due_ns: int | None = None

    def begin_segment(self, segment: Segment) -> None:
        """Record the scenario."""
        self._bag.begin_segment(segment)
        self._unflushed = True
        self._interval_ns = FLUSH_INTERVAL_NS if segment.scenario.steps_per_sample() < MANY_STEPS else 0

    def write(self, batch: Batch) -> None:
        """Record messages."""
        self._bag.write(batch)
        self._unflushed = True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """End the chunk when it is half a second old, or at once if the next sample takes long to compute."""
        if not self._unflushed:
            return FOREVER
        if self._flush_due_ns is None:
            self._flush_due_ns = steady_ns + self._interval_ns
        if steady_ns >= self._flush_due_ns:
            self._bag.flush()
            self._unflushed, self._flush_due_ns = False, None
            return FOREVER
        return self._flush_due_ns - steady_ns
