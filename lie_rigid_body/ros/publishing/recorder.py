"""The bag of a live run: on the disk it lacks at most the samples of the last half second. What ends it is told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.timing.sink import Periodic, Punctuality
from lie_rigid_body.simulation import Segment

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_writer import BagWriter

FLUSH_INTERVAL_NS: Final = 500_000_000
"""Steady time between two flushes of the bag, ns: a crash may cost one second of samples, and half of it is left for
what a busy machine does late."""
MANY_STEPS: Final = 20_000
"""Steps between two samples from which on each sample is flushed: so many take tenths of a second, without a tick."""


class Recorder(Periodic):
    """A sink into a bag. It ends the chunks of the bag by the steady clock, and looks after the file as often.

    A bag that can no longer be written is reported at once, and nothing more is recorded; the run goes on for others.

    Parameters
    ----------
    bag : BagWriter
    report : callable
        It is called once, with the reason, when the bag can no longer be written.

    Attributes
    ----------
    failure : BagError or None
        Why nothing more is recorded.
    """

    interval_ns = FLUSH_INTERVAL_NS

    def __init__(self, bag: BagWriter, report: Callable[[str], object]) -> None:
        self.failure: BagError | None = None
        self._bag = bag
        self._report = report
        self._every_sample = False

    def begin_segment(self, segment: Segment) -> None:
        """Record the scenario."""
        self._every_sample = segment.scenario.steps_per_sample() >= MANY_STEPS
        with self._recording():
            self._bag.begin_segment(segment)

    def write(self, batch: Batch) -> None:
        """Record messages; end the chunk at once if the next sample takes long to compute."""
        with self._recording():
            self._bag.write(batch)
            if self._every_sample:
                self._bag.flush()

    def act(self, steady_ns: int, punctuality: Punctuality) -> None:
        """End the chunk, and see that the file is still there."""
        if self.failure is None:
            with self._recording():
                self._bag.flush()

    @contextmanager
    def _recording(self) -> Iterator[None]:
        """A context of writing, whose failure is reported once."""
        try:
            yield
        except BagError as error:
            if self.failure is None:
                self.failure = error
                self._report(str(error))
