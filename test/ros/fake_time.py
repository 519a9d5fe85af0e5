"""A run on a steady clock that the test holds, and a sink that keeps what comes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.requests import Call, Mailbox
from lie_rigid_body.ros.timing.sink import Punctuality, Sink
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation
from lie_rigid_body.system.interruption import Interruption

NS = 1_000_000_000
NEVER = 2**63
COST = 2_000_000
"""ns that a turn of the loop takes when it does not wait."""


class KeepingSink:
    """Keeps what comes, and asks the run to end after a number of samples."""

    def __init__(self, interruption: Interruption, enough: int, steady: Callable[[], int] = lambda: 0) -> None:
        self.interruption = interruption
        self.enough = enough
        self.steady = steady
        self.sent_at: list[int] = []
        self.events: list[Segment | list[int]] = []
        self.batches: list[Batch] = []
        self.latest: list[int] = []
        self.punctuality = Punctuality()

    def begin_segment(self, segment: Segment) -> None:
        self.events.append(segment)

    def write(self, batch: Batch) -> None:
        assert [len(messages.payloads) for messages in batch.topics[:2]] == [len(batch.samples)] * 2
        self.batches.append(batch)
        self.events.append(batch.samples.stamps_ns.tolist())
        self.sent_at += [self.steady()] * len(batch.samples)
        self.interruption.requested = self.interruption.requested or len(self.sent_at) >= self.enough

    def ready(self) -> bool:
        return True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        self.latest.append(punctuality.lateness_ns)
        self.punctuality = punctuality
        return NEVER

    @property
    def stamps(self) -> list[int]:
        return [stamp for event in self.events if isinstance(event, list) for stamp in event]

    @property
    def segments(self) -> list[Segment]:
        return [event for event in self.events if isinstance(event, Segment)]

    def sensor_stamps(self, topic: str) -> list[int]:
        return [
            stamp
            for batch in self.batches
            for messages in batch.topics
            if messages.topic == topic
            for stamp in messages.times_ns
        ]


class ScriptedTime(Mailbox):
    """A mailbox in which a script of calls, each at a time of the steady clock, comes in; then the run ends."""

    def __init__(self, interruption: Interruption) -> None:
        super().__init__()
        self.now = 0
        self.oversleep_ns = 0
        self.waits: list[float] = []
        self.script: list[tuple[int, Callable[[], object]]] = []
        self.answers: list[object] = []
        self._interruption = interruption

    def steady(self) -> int:
        return self.now

    def request(self, function: Callable[[], object]) -> object:  # type: ignore[override]
        """The script runs in the owner's thread: it has no one to wait for."""
        return function()

    def wait(self, seconds: float) -> Call[object] | None:
        asked = (max(0, round(seconds * NS)) or COST) + self.oversleep_ns
        self.waits.append(seconds)
        if not self.script:
            self._interruption.requested = True
            return None
        at, action = self.script[0]
        if self.now + asked < at:
            self.now += asked
            return None
        self.now = max(self.now, at)
        del self.script[0]
        return Call(lambda: self._note(action))

    def _note(self, action: Callable[[], object]) -> None:
        try:
            self.answers.append(action())
        except Exception as error:
            self.answers.append(error)


class ScriptedRun:
    """A run whose calls are given beforehand: steady times (ns, from 0) and actions on ``self.live``.

    Parameters
    ----------
    factor, paused
        As those of `LiveRun`, like ``wall`` and ``warn``.
    sinks : sequence of Sink
        Others than the one that keeps what comes.
    **parameters
        Of the scenario; the stamps begin at ``start_ns``.
    """

    def __init__(
        self,
        *,
        factor: float = 1.0,
        paused: bool = False,
        wall: Callable[[], int] | None = None,
        sinks: Sequence[Sink] = (),
        start_ns: int = NS,
        warn: Callable[[str], object] = print,
        **parameters: object,
    ) -> None:
        self.interruption = Interruption()
        self.scenario = Scenario.from_parameters({"motion": "closed_form", **parameters})
        self.time = ScriptedTime(self.interruption)
        self.sink = KeepingSink(self.interruption, NEVER, self.time.steady)
        self.live = LiveRun(
            Simulation(self.scenario, start_ns),
            [*sinks, self.sink],
            self.time,
            self.interruption,
            self.time.steady,
            wall=wall,
            factor=factor,
            paused=paused,
            warn=warn,
        )

    def stall(self, length_ns: int) -> Callable[[], object]:
        """An action during which so much time passes."""
        return lambda: setattr(self.time, "now", self.time.now + length_ns)

    def play(self, *script: tuple[int, Callable[[], object]]) -> list[object]:
        """Run through a script; return what its actions returned or raised."""
        self.time.script = list(script)
        self.live.run()
        return self.time.answers
