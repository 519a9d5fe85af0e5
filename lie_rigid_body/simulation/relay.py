"""Tracks of one sensor, one after the other across resets."""

from __future__ import annotations

from typing import Generic, TypeVar

from lie_rigid_body.simulation.track import SlicedRows, Track

R = TypeVar("R", bound=SlicedRows)


class Relay(Generic[R]):
    """Tracks of which each goes on until the next one starts; nothing is computed before it is taken.

    Parameters
    ----------
    track : Track
        The first one.
    """

    def __init__(self, track: Track[R]) -> None:
        self._ending: list[tuple[Track[R], int]] = []
        self._last = track

    def hand_over(self, track: Track[R], start_ns: int) -> None:
        """Let a track follow from a stamp on, which lies after all that was taken."""
        ending = [*self._ending, (self._last, start_ns - 1)]
        self._ending = [(old, end_ns) for old, end_ns in ending if old.count_until(end_ns)]
        self._last = track

    def stamp_ns(self, ahead: int) -> int:
        """The stamp of the sample that comes after ``ahead`` others, ns."""
        for track, end_ns in self._ending:
            left = track.count_until(end_ns)
            if ahead < left:
                return track.stamp_ns(ahead)
            ahead -= left
        return self._last.stamp_ns(ahead)

    def count_until(self, stamp_ns: int) -> int:
        """How many samples that were not yet taken are stamped at or before a time."""
        ending = sum(track.count_until(min(stamp_ns, end_ns)) for track, end_ns in self._ending)
        return ending + self._last.count_until(stamp_ns)

    def take(self, count: int) -> R:
        """The next ``count`` samples."""
        taken: R | None = None
        while self._ending:
            track, end_ns = self._ending[0]
            left = track.count_until(end_ns)
            part = track.take(min(count, left))
            taken = part if taken is None else taken.joined(part)
            if count < left:
                return taken
            count -= left
            self._ending.pop(0)
        part = self._last.take(count)
        return part if taken is None else taken.joined(part)
