"""Where the samples of a run go."""

from __future__ import annotations

from typing import Protocol

from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.punctuality import Punctuality
from lie_rigid_body.simulation import Segment


class Outlet(Protocol):
    """Where samples go."""

    def begin_segment(self, segment: Segment) -> None:
        """Announce the motion that the next samples belong to."""
        ...

    def write(self, batch: Batch) -> None:
        """Take messages."""
        ...

    def ready(self) -> bool:
        """Whether there is room for more."""
        ...

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Do what is due at a steady time; return how long from then the next is, ns."""
        ...
