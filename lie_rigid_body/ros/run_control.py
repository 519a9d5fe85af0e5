"""What other threads may ask of a run."""

from __future__ import annotations

from lie_rigid_body.interruption import Interruption
from lie_rigid_body.mechanics import State
from lie_rigid_body.ros.live_run import LiveRun
from lie_rigid_body.ros.mailbox import Mailbox
from lie_rigid_body.ros.run_state import RunState
from lie_rigid_body.ros.stepping import Stepping
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment


class RunControl:
    """The commands of a run, each carried out by the thread that owns it, between two bursts.

    Every method waits for its result, and raises what the run raises, or `ClosedError` when it has ended.

    Parameters
    ----------
    run : LiveRun
    mailbox : Mailbox
        Which the run empties.
    interruption : Interruption
        Which ends it.
    """

    def __init__(self, run: LiveRun, mailbox: Mailbox, interruption: Interruption) -> None:
        self._run = run
        self._mailbox = mailbox
        self._interruption = interruption

    @property
    def state(self) -> RunState:
        """What time does."""
        return self._run.state

    @property
    def scenario(self) -> Scenario:
        """That of the present motion."""
        return self._run.segment.scenario

    def latest(self) -> tuple[int, State]:
        """Stamp (ns) and state of the sample sent last, or of the next one if it begins a motion."""
        return self._mailbox.request(lambda: self._run.latest)

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample."""
        return self._mailbox.request(lambda: self._run.reset(scenario))

    def restate(self, state: State) -> Segment:
        """Begin a new segment of the present scenario from another state."""
        return self._mailbox.request(lambda: self._run.restate(state))

    def pause(self) -> int:
        """Let time stand still; return the stamp where it does, ns."""
        return self._mailbox.request(self._run.pause)

    def resume(self) -> None:
        """Let time go on."""
        self._mailbox.request(self._run.resume)

    def stop(self, scenario: Scenario) -> Segment:
        """Let time stand still at the start of a motion."""
        return self._mailbox.request(lambda: self._run.stop(scenario))

    def step(self, count: int) -> Stepping:
        """Begin to send the next samples while time stands still."""
        return self._mailbox.request(lambda: self._run.step(count))

    def change_factor(self, factor: float) -> None:
        """Let time go on at another speed."""
        self._mailbox.request(lambda: self._run.change_factor(factor))

    def quit(self) -> None:
        """End the run."""

        def end() -> None:
            self._interruption.requested = True

        self._mailbox.request(end)
