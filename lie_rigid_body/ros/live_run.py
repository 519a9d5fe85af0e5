"""A simulation in real time: samples go out when they are due, whatever else happens."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Final, Protocol

from lie_rigid_body.interruption import Interruption
from lie_rigid_body.recording.cdr import MessageEncoder
from lie_rigid_body.ros.mailbox import Mailbox
from lie_rigid_body.ros.pacer import Pacer
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples, Segment, Simulation

NS: Final = 1_000_000_000
SHORTEST_WAIT_NS: Final = 1_000_000
"""Samples that come faster than once a millisecond go out together, a millisecond's worth at a time."""
LARGEST_BURST: Final = 250
"""Samples that go out before anyone else is heard. Subscribers keep as many and more, see `publisher`."""
STEPS_PER_BURST: Final = 2000
"""Steps of the moving chart, about 20 ms of computing, before anyone else is heard."""
LONGEST_WAIT_NS: Final = 3600 * NS
"""Some waits of the operating system cannot be longer than a few weeks."""


class Outlet(Protocol):
    """Where samples go."""

    def begin_segment(self, segment: Segment) -> None:
        """Announce the motion that the next samples belong to."""
        ...

    def write(self, samples: Samples, poses: Sequence[bytes], twists: Sequence[bytes]) -> None:
        """Take samples, and their messages."""
        ...

    def tick(self, steady_ns: int, lateness_ns: int) -> int:
        """Do what is due at a steady time; return how long from then the next is, ns.

        Parameters
        ----------
        steady_ns : int
        lateness_ns : int
            How long after it was due the latest sample was sent; negative when none was due.
        """
        ...


class LiveRun:
    """The loop that owns the simulation. It runs in the main thread, which signals interrupt.

    Parameters
    ----------
    simulation : Simulation
    outlets : sequence of Outlet
    mailbox : Mailbox
        For calls from other threads, such as a service that calls `reset`.
    interruption : Interruption
        Ends the loop.
    steady : callable, optional
        The steady clock, ns.
    """

    def __init__(
        self,
        simulation: Simulation,
        outlets: Sequence[Outlet],
        mailbox: Mailbox,
        interruption: Interruption,
        steady: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._simulation = simulation
        self._outlets = outlets
        self._mailbox = mailbox
        self._interruption = interruption
        self._steady = steady
        self._offset_ns = 0

    def run(self) -> None:
        """Send samples until the process is asked to end.

        Raises
        ------
        LieRigidBodyError
            If an outlet fails, or the stamps run out.
        """
        self._offset_ns = self._steady() - self._simulation.segment.start_ns
        self._begin(self._simulation.segment)
        try:
            while not self._interruption.requested:
                lateness_ns = self._send_due()
                self._hear(self._wait_ns(lateness_ns))
        except KeyboardInterrupt:
            return  # asked to end while there was nothing to lose

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment; for calls through the mailbox.

        Parameters
        ----------
        scenario : Scenario
            Its initial state is that of the next sample.

        Returns
        -------
        Segment
        """
        segment = self._simulation.reset(scenario)
        self._begin(segment)
        return segment

    def _begin(self, segment: Segment) -> None:
        self._pacer = Pacer(self._simulation.clock, self._offset_ns)
        self._encoder = MessageEncoder(segment.scenario)
        self._burst = largest_burst(segment.scenario)
        for outlet in self._outlets:
            outlet.begin_segment(segment)

    def _send_due(self) -> int:
        """Send what is due, at most a burst; return how late it was, ns."""
        number, now = self._simulation.next_sample, self._steady()
        lateness = self._pacer.lateness_ns(number, now)
        count = self._pacer.samples_due(number, now)
        if count:
            self._send(min(count, self._burst))
        return lateness

    def _send(self, count: int) -> None:
        with self._interruption.allowed():
            samples = self._simulation.take(count)
        poses, twists = self._encoder.poses(samples), self._encoder.twists(samples)
        for outlet in self._outlets:
            outlet.write(samples, poses, twists)

    def _wait_ns(self, lateness_ns: int) -> int:
        """How long there is nothing to do."""
        now = self._steady()
        others = [outlet.tick(now, lateness_ns) for outlet in self._outlets]
        wait = -self._pacer.lateness_ns(self._simulation.next_sample, now)
        if -SHORTEST_WAIT_NS < wait < SHORTEST_WAIT_NS and self._simulation.clock.rate * SHORTEST_WAIT_NS > NS:
            wait = SHORTEST_WAIT_NS
        return min(wait, LONGEST_WAIT_NS, *others)

    def _hear(self, wait_ns: int) -> None:
        with self._interruption.allowed():
            call = self._mailbox.wait(wait_ns / NS)
        if call is not None:
            call.carry_out()


def largest_burst(scenario: Scenario) -> int:
    """How many samples to take at once: few when each costs many steps, so that others are heard in between."""
    if scenario.motion == "closed_form":
        return LARGEST_BURST
    return max(1, min(LARGEST_BURST, STEPS_PER_BURST // steps_per_sample(scenario)))


def steps_per_sample(scenario: Scenario) -> int:
    """Steps from one sample to the next; of the closed form 1."""
    return 1 if scenario.motion == "closed_form" else math.ceil(1.0 / (scenario.rate * scenario.max_step))
