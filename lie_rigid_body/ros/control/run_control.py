"""The commands of a live run, for other threads than its own."""

from __future__ import annotations

from lie_rigid_body.interruption import Interruption
from lie_rigid_body.mechanics import State
from lie_rigid_body.ros.timing.live_run import LiveRun, RunState
from lie_rigid_body.ros.timing.mailbox import Mailbox
from lie_rigid_body.ros.timing.step_request import StepRequest
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment


class RunControl:
    """The commands of a run, each carried out by the thread of the run, between two batches.

    Every method waits for its result. It raises what the run raises, and `ClosedError` once the run has ended.

    Parameters
    ----------
    run : LiveRun
    mailbox : Mailbox
        The mailbox of the run.
    interruption : Interruption
        The interruption that ends the run.
    """

    def __init__(self, run: LiveRun, mailbox: Mailbox, interruption: Interruption) -> None:
        self._run = run
        self._mailbox = mailbox
        self._interruption = interruption

    @property
    def state(self) -> RunState:
        """The run state: stopped, playing or paused."""
        return self._run.state

    @property
    def scenario(self) -> Scenario:
        """The scenario of the present segment."""
        return self._run.segment.scenario

    def latest(self) -> tuple[int, State]:
        """Stamp (ns) and state of the last sample sent; at the start of a segment, of its first sample."""
        return self._mailbox.request(lambda: self._run.latest)

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample."""
        return self._mailbox.request(lambda: self._run.reset(scenario))

    def reset_to(self, state: State) -> Segment:
        """Begin a new segment of the present scenario from another initial state."""
        return self._mailbox.request(lambda: self._run.reset_to(state))

    def pause(self) -> int:
        """Stop simulated time; return where it stands, ns."""
        return self._mailbox.request(self._run.pause)

    def resume(self) -> None:
        """Let simulated time pass again."""
        self._mailbox.request(self._run.resume)

    def stop(self, scenario: Scenario) -> Segment:
        """Begin a new segment, and stop simulated time just before its first sample."""
        return self._mailbox.request(lambda: self._run.stop(scenario))

    def step(self, count: int) -> StepRequest:
        """While paused, begin to send the next samples."""
        return self._mailbox.request(lambda: self._run.step(count))

    def change_factor(self, factor: float) -> None:
        """Let simulated time pass by another real-time factor."""
        self._mailbox.request(lambda: self._run.change_factor(factor))

    def quit(self) -> None:
        """End the run."""

        def end() -> None:
            self._interruption.requested = True

        self._mailbox.request(end)
