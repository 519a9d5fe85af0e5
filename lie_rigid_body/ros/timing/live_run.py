"""The loop of the live node: it takes samples from a simulation when they are due, and hands them to the sinks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from enum import IntEnum
from fractions import Fraction
from typing import Final

import numpy as np

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS, Given
from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.ros.timing.lockstep import LOOK_NS, Lockstep
from lie_rigid_body.ros.timing.pace import BREATH_NS, Pace, UpTo, credit_ns, pace_of
from lie_rigid_body.ros.timing.requests import ControlError, Mailbox, P, StepRequest, T
from lie_rigid_body.ros.timing.sink import MAX_BATCH, Punctuality, Sink
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation
from lie_rigid_body.system.interruption import Interruption

STEPS_PER_BATCH: Final = 2000
"""Largest number of steps of the moving chart between two looks into the mailbox, about 20 ms of work."""
MAX_LIVE_STEPS: Final = 1_000_000
"""Largest number of steps of the moving chart between two samples, half a second of compiled work; calls wait."""
MIN_WAIT_NS: Final = 1_000_000
"""Shortest time between two batches, ns: samples of a rate above 1 kHz go out in one batch each millisecond."""
FAR_BEHIND_NS: Final = 10 * NS
"""Lateness from which a run that is woken too seldom sends more at once, ns: else it would fall behind for ever."""
MAX_WAIT_NS: Final = 3600 * NS
"""Longest wait for a call, ns: some waits of the operating system cannot be longer than a few weeks."""


def live_scenario(values: Given) -> Scenario:
    """Scenario of parameters, whose samples do not take so long that calls have to wait for their answers.

    Raises
    ------
    ParameterError
        If they make none, or its samples do.
    """
    scenario = Scenario.from_parameters(with_path(values))
    steps = scenario.steps_per_sample(min(scenario.rates))
    if steps > MAX_LIVE_STEPS:
        raise ParameterError(
            "max_step",
            f"{scenario.longest_step:.3g} s takes {steps:.3g} steps between samples, more than {MAX_LIVE_STEPS} of a "
            "live node: give a longer step, higher rates or a slower body, or use closed_form",
        )
    return scenario


class RunState(IntEnum):
    """Run states: stopped, playing, paused, by their numbers in simulation_interfaces/SimulationState."""

    STOPPED = 0
    """Simulated time stands still at the start of a segment."""
    PLAYING = 1
    """Simulated time passes, as the real-time factor says."""
    PAUSED = 2
    """Simulated time stands still, and samples are sent by step requests only."""


class LiveRun:
    """The loop that owns the simulation. It runs in the main thread, which signals interrupt.

    All other methods than `run` and `ask` are to be called by the thread of the loop: other threads `ask` for them.

    Parameters
    ----------
    simulation : Simulation
    sinks : sequence of Sink
        The receivers of the samples.
    mailbox : Mailbox
        Calls to carry out between two batches.
    interruption : Interruption
        Ends the loop when it is requested.
    steady : callable, optional
        The steady clock, ns.
    wall : callable, optional
        The time of day, ns. It stamps the first sample at the time when the run begins; by default the scenario does.
    factor : float, optional
        Real-time factor: simulated time over steady time; 0: as fast as possible.
    paused : bool, optional
        Begin paused, before the first sample.
    lockstep : Lockstep, optional
        What holds samples back until a filter has answered; the factor is then an upper limit.
    warn : callable, optional
        Told why the run has paused by itself, as where the stamps of ROS end.

    Attributes
    ----------
    state : RunState
    factor : float
        Real-time factor.
    latest : tuple of (int, State)
        Stamp (ns) and state of the last sample sent; at the start of a segment, of its first sample.
    punctuality : Punctuality
        How many samples were sent so far, and how late.
    """

    def __init__(
        self,
        simulation: Simulation,
        sinks: Sequence[Sink],
        mailbox: Mailbox,
        interruption: Interruption,
        steady: Callable[[], int] = time.monotonic_ns,
        *,
        wall: Callable[[], int] | None = None,
        factor: float = 1.0,
        paused: bool = False,
        lockstep: Lockstep | None = None,
        warn: Callable[[str], object] = lambda reason: None,
    ) -> None:
        self._simulation = simulation
        self._sinks = sinks
        self._mailbox = mailbox
        self._interruption = interruption
        self._steady = steady
        self._wall = wall
        self.factor = factor
        self._lockstep = lockstep
        self._warn = warn
        self._take_pace(UpTo(simulation.next_stamp_ns - 1))
        self.state = RunState.PAUSED if paused else RunState.PLAYING
        self._request: StepRequest | None = None
        self.punctuality = Punctuality()

    @property
    def segment(self) -> Segment:
        """The present segment."""
        return self._simulation.segment

    @property
    def _end_ns(self) -> int:
        """Stamp at which the motion of the present segment ends, ns."""
        return self.segment.start_ns + self.segment.scenario.last_ns

    def run(self) -> None:
        """Send samples, and carry out calls, until the interruption is requested.

        Raises
        ------
        LieRigidBodyError
            If a sink fails, the first sample cannot be stamped, or in lock-step no answer comes.
        """
        steady = self._steady()
        if self._wall is not None:
            self._simulation.start_at(self._wall())
        else:
            self._simulation.require_stamps(self._simulation.next_stamp_ns)
        first = self._simulation.next_stamp_ns
        playing = self.state is RunState.PLAYING
        self._take_pace(pace_of(self.factor, first, steady) if playing else UpTo(first - 1))
        self._begin(self._simulation.segment)
        try:
            while not self._interruption.requested:
                self._send_due()
                wait_ns = self._wait_ns()
                with self._interruption.allowed():
                    call = self._mailbox.wait(wait_ns / NS)
                if call is not None:
                    call.carry_out()
        except KeyboardInterrupt:
            return  # interrupted while waiting or computing: nothing is lost
        finally:
            self._abandon("the node is ending")
            self._mailbox.close()

    def ask(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Have the thread of the loop call a function between two batches; return or raise what the function does.

        Raises
        ------
        ClosedError
            If the run has ended.
        """
        return self._mailbox.request(function, *args, **kwargs)

    def quit(self) -> None:
        """End the run."""
        self._interruption.requested = True

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample.

        Parameters
        ----------
        scenario : Scenario
            Its initial state is that of the next sample.

        Returns
        -------
        Segment
            The new one.
        """
        segment = self._simulation.reset(scenario)
        self._abandon("reset")
        if self.state is not RunState.PLAYING:
            self._take_pace(UpTo(self._simulation.next_stamp_ns - 1))
        self._begin(segment)
        return segment

    def reset_to(self, changes: Given) -> Segment:
        """Begin a new segment of the present scenario with some parameters changed.

        Raises
        ------
        LieRigidBodyError
            If the scenario is not valid with them.
        """
        present = self._simulation.segment.scenario
        given = {**present.parameters(), **changes}
        return self.reset(live_scenario(given).resampled(epoch_ns=present.epoch_ns))

    def pause(self) -> int:
        """Stop simulated time; return where it stands, ns. A step request under way is abandoned."""
        self._abandon("paused")
        halted = self._present_ns()
        self._take_pace(UpTo(halted))
        self.state = RunState.PAUSED
        return halted

    def resume(self) -> None:
        """Let simulated time pass again, from where it stands."""
        if self.state is RunState.PLAYING:
            return
        self._abandon("resumed")
        self._take_pace(pace_of(self.factor, self._present_ns(), self._steady()))
        self.state = RunState.PLAYING

    def stop(self, scenario: Scenario) -> Segment:
        """Begin a new segment, and stop simulated time just before its first sample."""
        self.pause()
        segment = self.reset(scenario)
        self.state = RunState.STOPPED
        return segment

    def step(self, count: int) -> StepRequest:
        """While paused, send the next samples of the truth, and the sensors' readings up to the last of them.

        Parameters
        ----------
        count : int
            Samples of the truth, at least 1.

        Returns
        -------
        StepRequest
            It tells when they are sent.

        Raises
        ------
        ControlError
            If the run is not paused, or another request is under way.
        ParameterError
            If the last stamp would lie beyond `MAX_EPOCH_NS`.
        """
        if self.state is not RunState.PAUSED:
            raise ControlError(f"the run is {self.state.name.lower()}: pause it before a step")
        if self._request is not None:
            raise ControlError(f"{self._request.completed} of {self._request.total} steps are done: wait, or pause")
        if count < 1:
            raise ControlError(f"{count} steps are none: ask for at least 1")
        first = self._simulation.next_sample
        last_ns = self._simulation.clock.stamp_ns(first + count - 1)
        if last_ns > MAX_EPOCH_NS:
            raise ParameterError(
                "steps", f"{count} lead to {last_ns} ns, beyond the last stamp {MAX_EPOCH_NS}: give fewer"
            )
        if last_ns > self._end_ns:
            raise ControlError(f"{count} steps lead beyond the last pose of the path: ask for fewer")
        self._take_pace(UpTo(last_ns))
        self._request = StepRequest(first, count)
        return self._request

    def cancel(self, request: StepRequest) -> None:
        """Abandon a step request if it is still under way: it may have ended, and time may pass again."""
        if request is self._request:
            self.pause()

    def change_factor(self, factor: float) -> None:
        """Let simulated time pass by another real-time factor from now on."""
        present = self._present_ns()
        self.factor = factor
        self._set_deadline()
        if self.state is RunState.PLAYING:
            self._take_pace(pace_of(factor, present, self._steady()))

    def _take_pace(self, pace: Pace) -> None:
        self._pace = pace
        self._rested_ns = 0

    def _present_ns(self) -> int:
        """Present simulated time, ns: never beyond a sample that was not yet sent."""
        return min(self._pace.due_ns(self._steady()), self._simulation.next_stamp_ns - 1)

    def _abandon(self, why: str) -> None:
        if self._request is not None:
            self._request.abandon(why)
            self._request = None

    def _begin(self, segment: Segment) -> None:
        scenario = segment.scenario
        self._encoder = BatchEncoder(scenario)
        # few samples when each costs many steps, so that calls need not wait long
        self._batch_size = scenario.batch_size(MAX_BATCH, STEPS_PER_BATCH)
        self._set_deadline()
        self._rested_ns = 0
        if self._lockstep is not None:
            self._lockstep.begin_segment(scenario.sensors.on)
        self.latest = (segment.start_ns, scenario.start())
        for sink in self._sinks:
            sink.begin_segment(segment)

    def _set_deadline(self) -> None:
        factor = self.factor or 1.0
        self._deadline_ns = max(MIN_WAIT_NS, math.ceil(self._simulation.clock.period_ns / Fraction(factor)))
        self._is_fast = self._lockstep is None and max(self.segment.scenario.rates) * factor * MIN_WAIT_NS > NS

    def _send_due(self) -> None:
        """Send samples that are due: at most one batch, and of those that are late a few."""
        now = self._steady()
        stamp = self._simulation.next_stamp_ns
        if not all(sink.ready() for sink in self._sinks) or stamp > self._pace.due_ns(now) or now < self._rested_ns:
            return
        if stamp > self._end_ns:
            self._warn("the path has ended with its last pose, and so does the node")
            self.quit()
            return
        if self._lockstep is not None and self._lockstep.holds(now):
            self._take_pace(self._pace.postponed(stamp, now))
            return
        with self._interruption.allowed():
            is_far_behind = self._pace.wait_ns(stamp, now) < -FAR_BEHIND_NS
            credit = credit_ns(now - self._rested_ns, is_far_behind=is_far_behind)
            last_ns = self._pace.last_ns(stamp, now, credit) if self._lockstep is None else stamp
            try:
                taken = self._simulation.take_until(min(last_ns, self._end_ns), self._batch_size)
            except ParameterError as error:
                self.pause()
                self._warn(f"paused: {error}")
                return
        self._rested_ns = now + self._pace.rest_ns(self._simulation.next_stamp_ns - stamp, credit)
        batch = self._encoder.encode(taken)
        for sink in self._sinks:
            sink.write(batch)
        if self._lockstep is not None:
            self._lockstep.sent((n, s) for n, some in taken.sensors.items() for s in some.stamps_ns.tolist())
        self._note(batch, now, -self._pace.wait_ns(stamp, now))

    def _note(self, batch: Batch, steady_ns: int, lateness_ns: int) -> None:
        """Keep account of a batch: its punctuality, its last state, the step request it belongs to."""
        samples = batch.samples
        missed = 0
        if lateness_ns > self._deadline_ns:
            overdue = self._pace.due_ns(steady_ns - self._deadline_ns - 1)
            missed = int(np.searchsorted(samples.stamps_ns, overdue, side="right"))
        self.punctuality = self.punctuality.after(len(samples), missed, lateness_ns)
        if len(samples):
            self.latest = (int(samples.stamps_ns[-1]), samples.states[-1])
        if self._request is not None:
            self._request.advance(self._simulation.next_sample)
            if self._request.completed == self._request.total:
                self._request = None

    def _wait_ns(self) -> int:
        """Time until a sample is due or a sink wants its tick, ns. It gives the sinks their tick."""
        now = self._steady()
        others = [sink.tick(now, self.punctuality) for sink in self._sinks]
        wait = self._pace.wait_ns(self._simulation.next_stamp_ns, now)
        if not all(sink.ready() for sink in self._sinks):
            return 0
        if self._lockstep is not None and self._lockstep.is_waiting and wait <= 0:
            wait = LOOK_NS
        if self._is_fast and wait and -MIN_WAIT_NS < wait < MIN_WAIT_NS:
            wait = MIN_WAIT_NS
        if (rest := self._rested_ns - now) >= 0:
            wait = max(wait, rest, BREATH_NS)
        return min(wait, MAX_WAIT_NS, *others)
