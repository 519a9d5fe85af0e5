"""The bag of a live run, kept whole on the disk but for its last moment."""

from __future__ import annotations

from typing import Final

from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.ros.burst import steps_per_sample
from lie_rigid_body.ros.punctuality import Punctuality
from lie_rigid_body.simulation import Segment

FLUSH_INTERVAL_NS: Final = 500_000_000
"""Half of the second that a crash may cost, so that a busy machine keeps the promise as well."""
MANY_STEPS: Final = 20_000
"""Steps of the moving chart that take some tenths of a second, in which the recorder is not heard."""
_NEVER: Final = 2**63


class Recorder:
    """An outlet into a bag, whose chunks end by the steady clock.

    Parameters
    ----------
    bag : BagWriter
    """

    def __init__(self, bag: BagWriter) -> None:
        self._bag = bag
        self._unsafe = False
        self._patience_ns = FLUSH_INTERVAL_NS
        self._flush_due_ns: int | None = None

    def begin_segment(self, segment: Segment) -> None:
        """Record the scenario."""
        self._bag.begin_segment(segment)
        self._unsafe = True
        self._patience_ns = FLUSH_INTERVAL_NS if steps_per_sample(segment.scenario) < MANY_STEPS else 0

    def write(self, batch: Batch) -> None:
        """Record messages."""
        self._bag.write(batch)
        self._unsafe = True

    def ready(self) -> bool:
        """There is always room."""
        return True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """End the chunk when it is half a second old, or at once if the next sample takes long to compute."""
        if not self._unsafe:
            return _NEVER
        if self._flush_due_ns is None:
            self._flush_due_ns = steady_ns + self._patience_ns
        if steady_ns >= self._flush_due_ns:
            self._bag.flush()
            self._unsafe, self._flush_due_ns = False, None
            return _NEVER
        return self._flush_due_ns - steady_ns
