"""A simulation in time: samples go out when they are due, whatever else happens."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Final

import numpy as np

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.ros.burst import fastest_rate, largest_burst
from lie_rigid_body.ros.mailbox import Mailbox
from lie_rigid_body.ros.outlet import Outlet
from lie_rigid_body.ros.pace import Halted, Pace, pace
from lie_rigid_body.ros.punctuality import Punctuality
from lie_rigid_body.ros.run_state import RunState
from lie_rigid_body.ros.stepping import ControlError, Stepping
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation

NS: Final = 1_000_000_000
SHORTEST_WAIT_NS: Final = 1_000_000
"""Samples that come faster than once a millisecond go out together, a millisecond's worth at a time."""
LONGEST_WAIT_NS: Final = 3600 * NS
"""Some waits of the operating system cannot be longer than a few weeks."""


class LiveRun:
    """The loop that owns the simulation. It runs in the main thread, which signals interrupt.

    Parameters
    ----------
    simulation : Simulation
    outlets : sequence of Outlet
    mailbox : Mailbox
        For calls from other threads, such as a service that calls `reset`. All methods but `run` are for such calls.
    interruption : Interruption
        Ends the loop.
    steady : callable, optional
        The steady clock, ns.
    factor : float, optional
        Simulated time by steady time; 0: as fast as possible.
    paused : bool, optional
        Begin paused, before the first sample.
    """

    def __init__(
        self,
        simulation: Simulation,
        outlets: Sequence[Outlet],
        mailbox: Mailbox,
        interruption: Interruption,
        steady: Callable[[], int] = time.monotonic_ns,
        *,
        factor: float = 1.0,
        paused: bool = False,
    ) -> None:
        self._simulation = simulation
        self._outlets = outlets
        self._mailbox = mailbox
        self._interruption = interruption
        self._steady = steady
        self._factor = factor
        self._pace: Pace = Halted(simulation.next_stamp_ns - 1)
        self._state = RunState.PAUSED if paused else RunState.PLAYING
        self._stepping: Stepping | None = None
        self._punctuality = Punctuality()

    @property
    def state(self) -> RunState:
        """What time does."""
        return self._state

    @property
    def factor(self) -> float:
        """Simulated time by steady time."""
        return self._factor

    @property
    def segment(self) -> Segment:
        """The present motion."""
        return self._simulation.segment

    @property
    def latest(self) -> tuple[int, State]:
        """Stamp (ns) and state of the sample sent last, or of the next one if it begins a motion."""
        return self._latest

    def run(self) -> None:
        """Send samples until the process is asked to end.

        Raises
        ------
        LieRigidBodyError
            If an outlet fails, or the stamps run out.
        """
        if self._state is RunState.PLAYING:
            self._pace = pace(self._factor, self._simulation.next_stamp_ns, self._steady())
        self._begin(self._simulation.segment)
        try:
            while not self._interruption.requested:
                self._send_due()
                self._hear(self._wait_ns())
        except KeyboardInterrupt:
            return  # asked to end while there was nothing to lose
        finally:
            self._abandon("the node is ending")

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment.

        Parameters
        ----------
        scenario : Scenario
            Its initial state is that of the next sample.

        Returns
        -------
        Segment
        """
        segment = self._simulation.reset(scenario)
        self._abandon("reset")
        self._halt_if_still()
        self._begin(segment)
        return segment

    def restate(self, state: State) -> Segment:
        """Begin a new segment of the present scenario from another state of one instant.

        Raises
        ------
        LieRigidBodyError
            If the scenario cannot begin there.
        """
        present = self._simulation.segment.scenario
        given = {
            **present.parameters(),
            "initial_attitude_xyzw": state.attitude_xyzw.tolist(),
            "initial_body_rate": state.body_rate.tolist(),
        }
        return self.reset(replace(Scenario.from_parameters(given), epoch_ns=present.epoch_ns))

    def pause(self) -> int:
        """Let time stand still; return the stamp where it does, ns."""
        self._abandon("paused")
        halted = self._present_ns()
        self._pace, self._state = Halted(halted), RunState.PAUSED
        return halted

    def resume(self) -> None:
        """Let time go on from where it stands."""
        if self._state is RunState.PLAYING:
            return
        self._abandon("resumed")
        self._pace = pace(self._factor, self._present_ns(), self._steady())
        self._state = RunState.PLAYING

    def stop(self, scenario: Scenario) -> Segment:
        """Let time stand still at the start of a motion."""
        self.pause()
        segment = self.reset(scenario)
        self._state = RunState.STOPPED
        return segment

    def step(self, count: int) -> Stepping:
        """Send the next samples of the truth, and what sensors read until then, though time stands still.

        Parameters
        ----------
        count : int
            At least 1.

        Returns
        -------
        Stepping
            Whose end can be awaited.

        Raises
        ------
        ControlError
            If time does not stand still, or another request is not yet done.
        ParameterError
            If the stamps end before.
        """
        if self._state is not RunState.PAUSED:
            raise ControlError(f"the run is {self._state.value}: pause it before a step")
        if self._stepping is not None:
            raise ControlError(f"{self._stepping.completed} of {self._stepping.total} steps are done: wait, or pause")
        if count < 1:
            raise ControlError(f"{count} steps are none: ask for at least 1")
        first = self._simulation.next_sample
        last_ns = self._simulation.clock.stamp_ns(first + count - 1)
        if last_ns > MAX_EPOCH_NS:
            raise ParameterError("steps", f"{count} steps lead to {last_ns} ns, beyond the last stamp {MAX_EPOCH_NS}")
        self._pace = Halted(last_ns)
        self._stepping = Stepping(first, count)
        return self._stepping

    def change_factor(self, factor: float) -> None:
        """Let time go on at another speed from now."""
        present = self._present_ns()
        self._factor = factor
        self._set_deadline()
        if self._state is RunState.PLAYING:
            self._pace = pace(factor, present, self._steady())

    def _present_ns(self) -> int:
        """Where simulated time is: what was not sent is still to come."""
        return min(self._pace.due_ns(self._steady()), self._simulation.next_stamp_ns - 1)

    def _halt_if_still(self) -> None:
        if self._state is not RunState.PLAYING:
            self._pace = Halted(self._simulation.next_stamp_ns - 1)

    def _abandon(self, why: str) -> None:
        if self._stepping is not None:
            self._stepping.abandon(why)
            self._stepping = None

    def _begin(self, segment: Segment) -> None:
        scenario = segment.scenario
        self._encoder = BatchEncoder(scenario)
        self._burst = largest_burst(scenario)
        self._rate = fastest_rate(scenario)
        self._set_deadline()
        self._latest = (segment.start_ns, scenario.start())
        for outlet in self._outlets:
            outlet.begin_segment(segment)

    def _set_deadline(self) -> None:
        factor = self._factor or 1.0
        self._deadline_ns = max(SHORTEST_WAIT_NS, math.ceil(self._simulation.clock.period_ns / Fraction(factor)))
        self._is_fast = self._rate * factor * SHORTEST_WAIT_NS > NS

    def _send_due(self) -> None:
        """Send what is due, at most a burst."""
        now, stamp = self._steady(), self._simulation.next_stamp_ns
        due = self._pace.due_ns(now)
        if not all(outlet.ready() for outlet in self._outlets) or stamp > due:
            return
        with self._interruption.allowed():
            taken = self._simulation.take_until(due, self._burst)
        batch = self._encoder.encode(taken)
        for outlet in self._outlets:
            outlet.write(batch)
        self._note(batch, now, -self._pace.wait_ns(stamp, now))

    def _note(self, batch: Batch, steady_ns: int, lateness_ns: int) -> None:
        samples, missed = batch.samples, 0
        if lateness_ns > self._deadline_ns:
            overdue = self._pace.due_ns(steady_ns - self._deadline_ns - 1)
            missed = int(np.searchsorted(samples.stamps_ns, overdue, side="right"))
        self._punctuality = self._punctuality.after(len(samples), missed, lateness_ns)
        if len(samples):
            self._latest = (int(samples.stamps_ns[-1]), samples.states[-1])
        if self._stepping is not None:
            self._stepping.advance(self._simulation.next_sample)
            if self._stepping.completed == self._stepping.total:
                self._stepping = None

    def _wait_ns(self) -> int:
        """How long there is nothing to do."""
        now = self._steady()
        others = [outlet.tick(now, self._punctuality) for outlet in self._outlets]
        wait = self._pace.wait_ns(self._simulation.next_stamp_ns, now)
        if not all(outlet.ready() for outlet in self._outlets):
            return 0
        if self._is_fast and wait and -SHORTEST_WAIT_NS < wait < SHORTEST_WAIT_NS:
            wait = SHORTEST_WAIT_NS
        return min(wait, LONGEST_WAIT_NS, *others)

    def _hear(self, wait_ns: int) -> None:
        with self._interruption.allowed():
            call = self._mailbox.wait(wait_ns / NS)
        if call is not None:
            call.carry_out()
