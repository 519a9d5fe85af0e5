"""Lock-step: a run goes on only when a filter has answered the last reading that it can answer."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterable
from functools import partial
from typing import Final

from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.sensors.imu import IMU_SENSOR

LOOK_NS: Final = 100_000_000
"""Longest time between two looks whether samples are still held back, ns."""
FIRST_NS: Final = NS
"""Longest wait for an answer that may never come, ns: some filters begin with a later reading, or have paired the
partner of this one with another."""
STAMPS_KEPT: Final = 1000
"""Stamps of each sensor that are remembered until all have a reading of the same stamp."""


class Lockstep:
    """The answers that a run waits for. All methods are called by the thread of the run.

    An IMU reading can be answered once every other sensor that the filter hears has delivered a reading of the same
    stamp, before it or after it. Then its answer is awaited, unless that has come already, or a reading of that stamp
    or a later one was awaited before. Other readings are not waited for: a filter that pairs its sensors has no answer
    to them. Before its first answer, a filter is waited for no longer than `FIRST_NS` at each reading. The same holds
    after its first answer to another reading than the awaited one, however old. There message_filters' ApproximateTime
    may have spent the partner of the awaited reading, where both sensors lose some.

    Parameters
    ----------
    topic : str
        Full name of the filter's topic, for the message.
    look : callable
        Returns the names of the sensors that the filter hears, or None as long as somebody is missing.
    timeout_ns : int
        Longest wait for an answer, ns. Time in which nothing is due, as while paused, does not count.
    """

    def __init__(self, topic: str, look: Callable[[], Collection[str] | None], timeout_ns: int) -> None:
        self._topic = topic
        self._look = look
        self._timeout_ns = timeout_ns
        self._heard: Collection[str] | None = None
        self._sensors: frozenset[str] = frozenset()
        self._delivered = defaultdict[str, deque[int]](partial(deque, maxlen=STAMPS_KEPT))
        self._awaited: set[int] = set()
        self._latest_ns = -1
        self._others = self._other_ns = 0
        self._waited_ns = self._awaited_at_ns = self._asked_ns = 0
        self._longest_ns = min(FIRST_NS, timeout_ns)
        self._unanswered = deque[int](maxlen=STAMPS_KEPT)

    @property
    def is_waiting(self) -> bool:
        """Whether samples that are due have to wait."""
        return self._heard is None or bool(self._awaited)

    def begin_segment(self, sensors: Iterable[str]) -> None:
        """Look for those that take part anew if there are other sensors, whose topics nobody may hear yet."""
        if self._sensors != (found := frozenset(sensors)):
            self._sensors = found
            self._heard = None

    def holds(self, steady_ns: int) -> bool:
        """Whether samples that are due at a time of the steady clock have to wait.

        Raises
        ------
        LieRigidBodyError
            If they have waited for an answer as long as they may.
        """
        if self._heard is None:
            self._heard = self._look()
        if self._awaited:
            # a longer time than between two looks was a pause, or one in which this process stood still itself
            self._waited_ns += min(steady_ns - self._asked_ns, 2 * LOOK_NS)
            if self._waited_ns > self._timeout_ns:
                others = f"{counted(self._others, 'other')} came, last {self._other_ns} ns"
                raise LieRigidBodyError(
                    f"{self._topic}: no answer to {min(self._awaited)} ns in {self._timeout_ns / NS:g} s; "
                    f"{others if self._others else 'none came'}: let the filter answer each pair of readings, and not "
                    "by a timer"
                )
            if self._waited_ns - self._awaited_at_ns > self._longest_ns:
                self._awaited.clear()
        self._asked_ns = steady_ns
        return self.is_waiting

    def sent(self, readings: Iterable[tuple[str, int]]) -> None:
        """Await the answers to readings that were sent, names of sensors and stamps, ns."""
        heard = {*self._sensors.intersection(self._heard or ()), IMU_SENSOR.name}
        for name, stamp in sorted(readings, key=lambda reading: reading[0] == IMU_SENSOR.name):  # as published
            if name in heard:
                self._delivered[name].append(stamp)
                if name == IMU_SENSOR.name:
                    self._unanswered.append(stamp)
                if stamp > self._latest_ns and all(stamp in self._delivered[one] for one in heard):
                    self._await(stamp)

    def _await(self, stamp_ns: int) -> None:
        self._awaited.add(stamp_ns)
        self._latest_ns = stamp_ns
        self._awaited_at_ns = self._waited_ns
        self._others = 0
        for name, stamps in self._delivered.items():
            self._delivered[name] = deque((s for s in stamps if s > stamp_ns), maxlen=STAMPS_KEPT)

    def hear(self, stamp_ns: int) -> None:
        """Take the stamp of an estimate."""
        self._longest_ns = self._timeout_ns
        is_first = stamp_ns in self._unanswered
        if is_first:
            self._unanswered.remove(stamp_ns)
        if stamp_ns in self._awaited:
            self._awaited.remove(stamp_ns)
            self._waited_ns = 0
        else:
            if is_first:
                self._longest_ns = min(FIRST_NS, self._timeout_ns)
            self._others += 1
            self._other_ns = stamp_ns
            if stamp_ns in self._delivered[IMU_SENSOR.name]:  # answered before its partners came
                self._delivered[IMU_SENSOR.name].remove(stamp_ns)
