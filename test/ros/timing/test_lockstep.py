"""Lock-step without ROS: a filter that the test is, on a steady clock that the test holds."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any

import pytest
from fake_time import NS, KeepingSink

from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import Lockstep
from lie_rigid_body.ros.timing.requests import Call, Mailbox
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interruption import Interruption
from said import numbers
from sampled import sampled

BENCH = {"motion": "closed_form", "rate": 100.0, "imu_rate": 100.0, "magnetometer_rate": 100.0}


class FilteredTime(Mailbox):
    """A mailbox into which answers come, each so long after the filter could make it."""

    def __init__(self, delay_ns: int) -> None:
        super().__init__()
        self.now = 5 * NS
        self.calls: dict[int, Call[object]] = {}
        self.waits: list[float] = []
        self.delay_ns = delay_ns
        self.answers: list[tuple[int, Callable[[], object]]] = []

    def steady(self) -> int:
        return self.now

    def post(self, function: Callable[[], object]) -> None:
        self.answers.append((self.now + self.delay_ns, function))

    def wait(self, seconds: float) -> Call[object] | None:
        self.waits.append(seconds)
        end = self.now + max(0, round(seconds * NS))
        self.answers.sort(key=itemgetter(0))
        if len(self.waits) in self.calls:
            return self.calls.pop(len(self.waits))
        if self.answers and self.answers[0][0] <= end:
            at, function = self.answers.pop(0)
            self.now = max(self.now, at)
            return Call(function)
        self.now = end
        return None


class PairingFilter(KeepingSink):
    """A filter that answers where it has a reading of each sensor with the same stamp, as the example node does."""

    def __init__(self, interruption: Interruption, enough: int, time: FilteredTime, topics: set[str]) -> None:
        super().__init__(interruption, enough, time.steady)
        self.time, self.topics = time, topics
        self.waiting: dict[str, set[int]] = {topic: set() for topic in topics}
        self.answered: list[int] = []
        self.unanswered_when_sent: list[int] = []
        self.silent_from = 10**9
        self.lockstep: Lockstep | None = None

    def write(self, batch: Batch) -> None:
        super().write(batch)
        self.unanswered_when_sent.append(len(self.time.answers))
        for messages in batch.topics:
            if messages.topic in self.topics:
                for payload in messages.payloads:
                    self.hear(messages.topic, stamp_of(payload))

    def hear(self, topic: str, stamp: int) -> None:
        self.waiting[topic].add(stamp)
        if all(stamp in stamps for stamps in self.waiting.values()) and len(self.answered) < self.silent_from:
            assert self.lockstep is not None
            self.answered.append(stamp)
            self.time.post(partial(self.lockstep.hear, stamp))
            self.waiting = {name: {s for s in stamps if s > stamp} for name, stamps in self.waiting.items()}


def stamp_of(payload: bytes) -> int:
    return int.from_bytes(payload[4:8], "little") * NS + int.from_bytes(payload[8:12], "little")


TOPICS = {"imu": "imu/data_raw", "magnetometer": "imu/mag"}


class Run:
    def __init__(
        self,
        *,
        heard: tuple[str, ...] = ("imu", "magnetometer"),
        delay_ns: int = 0,
        factor: float = 0.0,
        enough: int = 300,
        timeout_ns: int = NS,
        paused: bool = False,
        ready_at: int = 0,
        **parameters: object,
    ) -> None:
        self.interruption = Interruption()
        self.time = FilteredTime(delay_ns)
        self.looks = 0

        def look() -> tuple[str, ...] | None:
            self.looks += 1
            return heard if self.looks > ready_at else None

        self.lockstep = Lockstep("/imu/data", look, timeout_ns)
        self.filter = PairingFilter(self.interruption, enough, self.time, {TOPICS[name] for name in heard})
        self.filter.lockstep = self.lockstep
        self.scenario = Scenario.from_parameters({**BENCH, **parameters})
        self.live = LiveRun(
            Simulation(self.scenario, NS),
            [self.filter],
            self.time,
            self.interruption,
            self.time.steady,
            factor=factor,
            paused=paused,
            lockstep=self.lockstep,
        )


def test_each_reading_is_answered_before_the_next_is_sent() -> None:
    run = Run(delay_ns=3_000_000)
    run.live.run()
    assert len(run.filter.answered) == 300
    assert set(run.filter.unanswered_when_sent) == {0}
    # as fast as the filter, and no faster
    assert run.time.now - 5 * NS == pytest.approx(300 * 3_000_000, rel=0.01)


@pytest.mark.parametrize(("delay_ns", "period_ns"), [(1_000_000, 5_000_000), (8_000_000, 8_000_000)])
def test_the_real_time_factor_is_an_upper_limit(delay_ns: int, period_ns: int) -> None:
    run = Run(delay_ns=delay_ns, factor=2.0)
    run.live.run()
    between = [b - a for a, b in zip(run.filter.sent_at, run.filter.sent_at[1:], strict=False)]
    assert min(between) >= period_ns
    assert sum(between) == pytest.approx(299 * period_ns, rel=0.01)


def test_nothing_is_sent_until_all_are_there_however_long_it_takes() -> None:
    run = Run(ready_at=500, timeout_ns=NS)
    run.live.run()
    assert run.time.now > 50 * NS
    assert run.filter.stamps[0] == NS


@pytest.mark.parametrize(
    ("parameters", "share"),
    sampled(
        [
            ({"magnetometer_rate": 25.0}, 0.25),
            ({"imu_rate": 25.0}, 0.25),
            ({"magnetometer_rate": 30.0}, 0.1),
            ({"imu_dropout_probability": 0.3}, 0.7),
            ({"magnetometer_dropout_probability": 0.3}, 0.7),
            ({"magnetometer_latency": 0.02}, 1.0),
            ({"magnetometer_latency": 0.02, "magnetometer_latency_jitter": 0.05}, 1.0),
            ({"imu_latency": 0.02, "imu_latency_jitter": 0.05}, 1.0),
            ({"imu_latency_jitter": 0.05, "magnetometer_latency_jitter": 0.05}, 1.0),
            ({"imu_clock_offset": 0.001}, 0.0),
            ({"magnetometer_clock_skew": 1e-3}, 0.0),
            ({"imu_clock_offset": -0.02, "magnetometer_rate": 50.0}, 0.5),
        ],
        every=3,
    ),
)
def test_a_filter_that_pairs_its_sensors_never_waits_for_the_run_that_waits_for_it(
    parameters: dict[str, Any], share: float
) -> None:
    run = Run(enough=400, delay_ns=1_000_000, timeout_ns=NS // 10, **parameters)
    run.live.run()
    assert len(run.filter.stamps) == 400
    assert len(set(run.filter.answered)) / 400 == pytest.approx(share, abs=0.08)
    assert {*run.filter.unanswered_when_sent} == {0}


def test_an_answer_that_came_before_the_partners_of_its_reading_is_not_awaited() -> None:
    run = Run(enough=400, delay_ns=1_000_000, timeout_ns=NS // 10, magnetometer_latency=0.02)
    run.filter.topics = {TOPICS["imu"]}
    run.filter.waiting = {TOPICS["imu"]: set()}
    run.live.run()
    assert len(run.filter.answered) == 400


def test_a_sensor_that_the_filter_does_not_hear_is_not_waited_for() -> None:
    run = Run(heard=("imu",), delay_ns=3_000_000, magnetometer_rate=1.0)
    run.live.run()
    assert len(run.filter.answered) == 300


@pytest.mark.parametrize("others", [0, 3])
def test_a_filter_that_gives_no_answer_ends_the_run_with_the_stamp_and_what_came_instead(others: int) -> None:
    run = Run(timeout_ns=2 * NS)
    run.filter.silent_from = 7
    for number in range(others):
        run.time.answers.append((7 * NS, partial(run.lockstep.hear, 5 + number)))
    with pytest.raises(LieRigidBodyError) as failure:
        run.live.run()
    assert numbers(str(failure.value)) == [NS + 7 * 10_000_000, 2, *([3, 7] if others else [])]
    assert len(run.filter.stamps) == 8
    assert 2 * NS <= run.time.now - 5 * NS < 2.5 * NS


def test_a_filter_may_begin_with_a_later_reading() -> None:
    """A reading before its first answer costs a second, and a silent filter the timeout in all."""
    run = Run(timeout_ns=10 * NS)
    begun = {NS + number * 10_000_000 for number in range(3)}
    hear = run.filter.hear
    run.filter.hear = lambda topic, stamp: None if stamp in begun else hear(topic, stamp)  # type: ignore[method-assign]
    run.live.run()
    assert len(run.filter.answered) == 297
    assert 3 * NS <= run.time.now - 5 * NS < 3.6 * NS
    run = Run(timeout_ns=10 * NS)
    run.filter.silent_from = 0
    with pytest.raises(LieRigidBodyError):
        run.live.run()
    assert 10 * NS <= run.time.now - 5 * NS < 10.6 * NS


def test_paused_time_is_left_out_of_the_timeout() -> None:
    run = Run(timeout_ns=2 * NS)
    run.filter.silent_from = 7
    pauses: list[Call[object]] = [Call(run.live.pause), Call(run.live.resume)]
    run.time.calls = {17: pauses[0]}
    waited = run.time.wait

    def wait(seconds: float) -> Call[object] | None:
        if seconds > 100.0:  # paused, with nobody to wake it
            run.time.now += 1000 * NS
            return pauses[1]
        return waited(seconds)

    run.time.wait = wait  # type: ignore[method-assign]
    with pytest.raises(LieRigidBodyError) as failure:
        run.live.run()
    assert NS + 7 * 10_000_000 in numbers(str(failure.value))
    assert 1001.7 * NS <= run.time.now - 5 * NS < 1003 * NS


def test_a_reset_with_the_same_sensors_goes_on_and_with_others_looks_anew() -> None:
    run = Run(delay_ns=1_000_000)
    run.time.calls = {50: Call(partial(run.live.reset, Scenario.from_parameters({**BENCH, "sensor_seed": 4})))}
    run.live.run()
    assert len(run.filter.answered) == 300
    assert run.looks == 1
    run = Run(delay_ns=1_000_000)
    more = Scenario.from_parameters({**BENCH, "sun_sensor_rate": 10.0})
    run.time.calls = {50: Call(partial(run.live.reset, more))}
    run.live.run()
    assert run.looks == 2


@pytest.mark.parametrize("is_spent", [True, False])
def test_a_reading_whose_partner_another_has_spent_is_waited_for_a_second(is_spent: bool) -> None:
    """As by ApproximateTime: imu(1) alone, then both of 2, and it answers imu(1) with the magnetometer's 2."""
    lockstep = Lockstep("/imu/data", lambda: ("imu", "magnetometer"), 10 * NS)
    lockstep.begin_segment(["imu", "magnetometer"])
    now = 0

    def waited(stamp: int) -> int:
        nonlocal now
        lockstep.sent([("magnetometer", stamp), ("imu", stamp)])
        begin = now
        while lockstep.holds(now):
            now += NS // 10
            if is_spent and stamp == 2 and now == begin + NS // 10:
                lockstep.hear(1)
            if stamp in (0, 3):
                lockstep.hear(stamp)
        return now - begin

    assert waited(0) == NS // 10
    lockstep.sent([("imu", 1)])
    assert not lockstep.is_waiting
    if is_spent:
        assert NS < waited(2) < 2 * NS
        assert waited(3) == NS // 10
        now += NS
        with pytest.raises(LieRigidBodyError):
            waited(4)
    else:
        with pytest.raises(LieRigidBodyError):
            waited(2)
    assert now > 10 * NS


def test_the_reading_that_has_spent_a_partner_may_be_older_than_one_that_was_answered() -> None:
    """As by message_filters' synchronizer in Python: imu(1) alone, both of 2 are a pair, then imu(1) takes the 3."""
    lockstep = Lockstep("/imu/data", lambda: ("imu", "magnetometer"), 10 * NS)
    lockstep.begin_segment(["imu", "magnetometer"])
    now = 0

    def waited() -> int:
        nonlocal now
        begin = now
        while lockstep.holds(now):
            now += NS // 10
        return now - begin

    assert not lockstep.holds(now)
    lockstep.sent([("imu", 1)])
    lockstep.sent([("magnetometer", 2), ("imu", 2)])
    lockstep.hear(2)
    lockstep.sent([("magnetometer", 3), ("imu", 3)])
    lockstep.hear(1)
    assert NS < waited() < 2 * NS
    lockstep.sent([("magnetometer", 4), ("imu", 4)])
    lockstep.hear(1)  # once more: it has spent nothing again
    with pytest.raises(LieRigidBodyError):
        waited()
