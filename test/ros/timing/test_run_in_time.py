"""Simulated time runs, stands still, goes on and changes its speed; it never jumps, and no stamp is lost or doubled."""

from __future__ import annotations

import itertools
import math
import random
from fractions import Fraction

import numpy as np
import pytest
from fake_time import NS, ScriptedRun
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.ros.timing.live_run import MIN_WAIT_NS, RunState
from lie_rigid_body.ros.timing.pace import BREATH_NS, CATCH_UP, MAX_CREDIT_NS, STALL_NS
from lie_rigid_body.ros.timing.requests import ControlError, StepRequest
from lie_rigid_body.ros.timing.sink import MAX_BATCH
from lie_rigid_body.scenario import Scenario
from sampled import sampled

MS = 1_000_000
PERIOD = 10 * MS
GAIN_NS = (CATCH_UP - 1) * 2 * BREATH_NS
"""What a late run gains on time in two breaths, ns."""


def nothing() -> None:
    """What is done at the end of a script."""


def truth(count: int, first: int = 0) -> list[int]:
    return [NS + k * PERIOD for k in range(first, first + count)]


def broken_off(stepping: object) -> int:
    """How many steps of a request that was broken off were done."""
    assert isinstance(stepping, StepRequest)
    with pytest.raises(ControlError):
        stepping.wait(0.0)
    return stepping.completed


@pytest.mark.parametrize("factor", [0.1, 0.5, 1 / 3, 1.0, 2.0, 7.7])
def test_samples_go_out_when_the_factor_says(factor: float) -> None:
    run = ScriptedRun(factor=factor)
    run.play((2 * NS, nothing))
    due = [math.ceil(k * PERIOD / Fraction(repr(factor))) for k in range(len(run.sink.stamps))]
    assert run.sink.stamps == truth(len(due))
    assert run.sink.sent_at == due
    assert len(due) >= int(200 * factor)
    assert run.sink.punctuality.missed == run.sink.punctuality.worst_ns == 0


def test_without_a_limit_nothing_is_waited_for() -> None:
    run = ScriptedRun(factor=0.0)
    run.play((100 * MS, nothing))
    assert run.sink.stamps == truth(len(run.sink.stamps))
    assert len(run.sink.stamps) > 20 * MAX_BATCH
    assert run.sink.punctuality.missed == run.sink.punctuality.worst_ns == 0


def test_a_step_is_one_sample_and_what_sensors_read_until_then() -> None:
    run = ScriptedRun(paused=True, imu_rate=250.0, magnetometer_rate=30.0)
    seen: list[tuple[list[int], list[int], list[int]]] = []

    def look() -> None:
        sink = run.sink
        seen.append((sink.stamps, sink.sensor_stamps("imu/data_raw"), sink.sensor_stamps("imu/mag")))

    steps = [(k * NS, action) for k in range(1, 5) for action in (lambda: run.live.step(1), nothing, look)]
    answers = run.play(*steps)
    assert [a.wait(0.0) for a in answers if isinstance(a, StepRequest)] == [True] * 4
    imu = [NS + 4 * MS * k for k in range(20)]
    field = [NS + round(k * NS / 30) for k in range(20)]
    for number, (stamps, imu_stamps, field_stamps) in enumerate(seen):
        last = NS + number * PERIOD
        assert stamps == truth(number + 1)
        assert imu_stamps == [stamp for stamp in imu if stamp <= last]
        assert field_stamps == [stamp for stamp in field if stamp <= last]


@pytest.mark.parametrize("count", [1, 2, MAX_BATCH, MAX_BATCH + 1, 1000])
def test_as_many_steps_as_asked_for(count: int) -> None:
    run = ScriptedRun(paused=True)
    [stepping, _, again, _] = run.play(
        (NS, lambda: run.live.step(count)), (2 * NS, nothing), (3 * NS, lambda: run.live.step(1)), (4 * NS, nothing)
    )
    assert isinstance(stepping, StepRequest)
    assert isinstance(again, StepRequest)
    assert (stepping.completed, stepping.total, stepping.wait(0.0), again.wait(0.0)) == (count, count, True, True)
    assert run.sink.stamps == truth(count + 1)
    assert run.live.state is RunState.PAUSED


def test_steps_that_are_refused_change_nothing() -> None:
    run = ScriptedRun()
    [playing, _, long, second, none, beyond, _] = run.play(
        (NS + 5 * MS, lambda: run.live.step(1)),
        (NS + 6 * MS, run.live.pause),
        (2 * NS, lambda: run.live.step(600)),
        (2 * NS, lambda: run.live.step(1)),
        (3 * NS, lambda: run.live.step(0)),
        (3 * NS, lambda: run.live.step(2**64 - 1)),
        (4 * NS, nothing),
    )
    assert all(isinstance(refused, ControlError) for refused in (playing, second, none))
    assert isinstance(beyond, ParameterError)
    assert beyond.name == "steps"
    assert isinstance(long, StepRequest)
    assert long.wait(0.0)
    assert run.sink.stamps == truth(101 + 600)


@pytest.mark.parametrize("why", ["paused", "resumed", "reset", "stop", "reset_to"])
def test_what_breaks_off_steps_says_how_many_were_done(why: str) -> None:
    run = ScriptedRun(paused=True)
    actions = {
        "paused": run.live.pause,
        "resumed": run.live.resume,
        "reset": lambda: run.live.reset(run.scenario),
        "stop": lambda: run.live.stop(run.scenario),
        "reset_to": lambda: run.live.reset_to({}),
    }
    [stepping, *_] = run.play((NS, lambda: run.live.step(1000)), (NS, actions[why]), (2 * NS, nothing))
    assert broken_off(stepping) == MAX_BATCH
    assert (run.live.state is RunState.PLAYING) == (why == "resumed")
    count = len(run.sink.stamps)
    assert run.sink.stamps == truth(count)
    assert (count == MAX_BATCH) == (why != "resumed")


def test_a_body_whose_samples_take_seconds_is_refused() -> None:
    """No call is answered while a sample is computed."""
    run = ScriptedRun(motion="moving_chart")
    fast = {"initial_body_rate": [1e10 * rate for rate in run.scenario.initial_body_rate]}
    [refused, _] = run.play((NS, lambda: run.live.reset_to(fast)), (2 * NS, nothing))
    assert isinstance(refused, ParameterError)
    assert refused.name == "max_step"
    assert run.sink.stamps == truth(201)


def test_the_end_breaks_off_steps() -> None:
    run = ScriptedRun(paused=True)
    [stepping] = run.play((NS, lambda: run.live.step(1000)))
    assert broken_off(stepping) == 250


def test_time_goes_on_from_where_it_stood() -> None:
    """Resumed twice, and paused twice, as well."""
    run = ScriptedRun()
    pauses = run.play(
        (NS + 5 * MS, run.live.pause),
        (2 * NS, run.live.pause),
        (10 * NS, run.live.resume),
        (10 * NS + 7 * MS, run.live.resume),
        (11 * NS, nothing),
    )[:2]
    assert pauses == [2 * NS + 5 * MS] * 2
    stamps, at = run.sink.stamps, run.sink.sent_at
    assert stamps == truth(201)
    assert at[:101] == [k * PERIOD for k in range(101)]
    assert at[101:] == [10 * NS + 5 * MS + k * PERIOD for k in range(100)]


def most_ahead_ns(run: ScriptedRun) -> float:
    """The most that samples of any stretch of time are ahead of the multiple of that time, ns of steady time."""
    stamps, at = np.array(run.sink.stamps), np.array(run.sink.sent_at)
    ahead = (stamps - stamps[0]) / run.live.factor - CATCH_UP * (at - at[0])
    return float((ahead - np.minimum.accumulate(ahead)).max())


@pytest.mark.parametrize(
    ("rate", "factor"), sampled(itertools.product([30.0, 400.0, 1000.0, 2e4], [0.5, 1.0, 2.0]), every=4)
)
def test_a_late_run_sends_an_even_stream(rate: float, factor: float) -> None:
    """Over every time a multiple of what passes of simulated time, and no more; until it is late no longer."""
    run, late = ScriptedRun(rate=rate, factor=factor), NS // 10
    caught_up = late + math.ceil(late / (CATCH_UP - 1)) + 100 * MS
    run.play((10 * MS, run.stall(late)), (caught_up, nothing))
    stamps, at = run.sink.stamps, np.array(run.sink.sent_at)
    assert stamps == [NS + round(k * NS / Fraction(repr(rate))) for k in range(len(stamps))]
    assert run.sink.punctuality.worst_ns >= late - NS / rate / factor
    assert run.sink.latest[-1] <= MS
    assert most_ahead_ns(run) <= CATCH_UP * MIN_WAIT_NS
    if rate * factor * BREATH_NS * CATCH_UP <= NS:
        assert np.diff(at).min() >= NS / rate / factor / CATCH_UP - 2


@pytest.mark.parametrize(("rate", "factor"), [(1000.0, 1.0), (250.0, 2.0), (1e4, 1.0)])
def test_late_wakings_bring_no_burst(rate: float, factor: float) -> None:
    """What goes out at once came due while the run was woken late; after a stall it is one sample."""
    run, script, at = ScriptedRun(rate=rate, factor=factor), [(10 * MS, 200 * MS)], 210 * MS
    randomness = random.Random(3)
    for _ in range(60):
        at += randomness.randrange(5 * MS)
        script.append((at, randomness.choice([MS // 10, MS // 2, MS, 2 * MS, 4 * MS, 8 * MS, 30 * MS])))
        at += script[-1][1]

    run.play(*((at, run.stall(late)) for at, late in script), (at + 20 * MS, nothing))
    period = NS / rate / factor
    moments, counts = np.unique(run.sink.sent_at, return_counts=True)
    for silence, count in zip(np.diff(moments).tolist(), counts[1:].tolist(), strict=True):
        assert (count - 1) * period <= min(silence, MAX_CREDIT_NS) + GAIN_NS
        assert count == 1 or silence < STALL_NS + 5 * MS
    assert most_ahead_ns(run) <= MAX_CREDIT_NS + GAIN_NS + 2
    if rate * factor <= 1000.0:  # the subscribers that keep 10 samples have so long to take them
        sent_at = np.array(run.sink.sent_at)
        assert (sent_at[10:] - sent_at[:-10]).min() >= 5 * MS


def test_the_first_sample_is_stamped_when_the_run_begins() -> None:
    """Whatever was done before: the stamps are the time of day at which the samples are sent."""
    day = 1_700_000_000 * NS
    run = ScriptedRun(rate=1000.0, imu_rate=300.0, wall=lambda: day + run.time.now)
    run.time.now += 34 * MS
    run.play((NS, nothing))
    [segment] = run.sink.segments
    assert (segment.start_ns, segment.scenario.epoch_ns, segment.first_sample) == (day + 34 * MS, day + 34 * MS, 0)
    assert run.sink.stamps == [day + at for at in run.sink.sent_at]
    assert run.sink.sensor_stamps("imu/data_raw")[0] == segment.start_ns
    assert len(run.sink.stamps) > 900


def test_the_time_of_day_is_asked_once() -> None:
    """Later steps, in either direction, change no stamp; neither does a reset, nor a pause."""
    day, hour = 1_700_000_000 * NS, 3600 * NS
    days = itertools.chain([day], itertools.cycle([day - hour, day + hour]))
    run = ScriptedRun(rate=100.0, imu_rate=30.0, wall=lambda: next(days))
    run.play(
        (NS, lambda: run.live.reset(run.scenario)),
        (2 * NS, run.live.pause),
        (3 * NS, run.live.resume),
        (4 * NS, lambda: None),
    )
    assert run.sink.stamps[0] == day
    assert set(np.diff(run.sink.stamps).tolist()) == {NS // 100}
    assert len(run.sink.stamps) == pytest.approx(300, abs=2)


@pytest.mark.parametrize(("before", "after"), [(1.0, 2.0), (2.0, 0.5), (0.5, 3.0), (0.0, 1.0)])
def test_another_factor_acts_from_now_without_a_jump(before: float, after: float) -> None:
    run, now = ScriptedRun(factor=before), 4 * MS
    run.play((now, lambda: run.live.change_factor(after)), (now + NS, nothing))
    stamps, at = run.sink.stamps, run.sink.sent_at
    assert stamps == truth(len(stamps))
    later = [k for k, moment in enumerate(at) if moment > now]
    reached = before * now if before else stamps[later[0] - 1] - NS + PERIOD - 1
    due = [now + math.ceil((stamps[k] - NS - Fraction(reached)) / Fraction(after)) for k in later]
    assert [abs(at[k] - moment) <= 1 for k, moment in zip(later, due, strict=True)] == [True] * len(due)
    assert len(later) >= int(after * NS / PERIOD)


def test_a_factor_changed_while_paused_acts_when_time_goes_on() -> None:
    run = ScriptedRun(rate=1000.0)
    run.play(
        (5 * MS + 1, run.live.pause),
        (NS, lambda: run.live.change_factor(0.01)),
        (2 * NS, nothing),
        (2 * NS, run.live.resume),
        # 50 ms late is in time when samples are 100 ms apart
        (2 * NS + 950 * MS, run.stall(100 * MS)),
        (4 * NS, nothing),
    )
    assert 10 <= len(run.sink.stamps) - 6 <= 20
    assert run.sink.sent_at[6] > 2 * NS + 99 * MS
    assert (run.sink.punctuality.missed, run.sink.punctuality.worst_ns) == (0, 50 * MS + 100)


def test_time_paused_while_catching_up_stands_at_what_was_sent() -> None:
    run = ScriptedRun()
    stalled = NS + 5 * MS, run.stall(30 * NS)
    [_, halted, *_] = run.play(stalled, (2 * NS, run.live.pause), (100 * NS, run.live.resume), (101 * NS, nothing))
    sent = 101 + 1
    assert halted == NS + sent * PERIOD - 1
    assert run.sink.stamps == truth(len(run.sink.stamps))
    assert run.sink.sent_at[sent:] == [100 * NS + 1 + k * PERIOD for k in range(len(run.sink.stamps) - sent)]
    assert run.sink.latest[-1] == 0


@pytest.mark.slow
@example([(100 * MS, 50 * MS)])  # late by just a period
@given(st.lists(st.tuples(st.integers(0, 100 * MS), st.integers(0, 80 * MS)), max_size=8))
@pytest.mark.parametrize(("rate", "factor"), [(100.0, 1.0), (100.0, 2.0), (5000.0, 1.0), (30.0, 0.5)])
@settings(max_examples=25)
def test_missed_deadlines_are_those_of_the_definition(
    rate: float, factor: float, stalls: list[tuple[int, int]]
) -> None:
    run, script, at = ScriptedRun(rate=rate, factor=factor), [], 0
    for gap, length in stalls:
        at += gap
        script.append((at, run.stall(length)))
    run.play(*script, (at + 200 * MS, nothing))
    lateness = [
        moment - math.ceil((stamp - NS) / Fraction(repr(factor)))
        for stamp, moment in zip(run.sink.stamps, run.sink.sent_at, strict=True)
    ]
    deadline = max(MS, math.ceil(NS / Fraction(repr(rate)) / Fraction(repr(factor))))
    punctuality = run.sink.punctuality
    assert punctuality.sent == len(lateness)
    assert punctuality.missed == sum(late > deadline for late in lateness)
    assert punctuality.worst_ns == max(lateness)


def test_to_stop_is_to_pause_at_the_start() -> None:
    run = ScriptedRun()
    states: list[RunState] = []
    answers = run.play(
        (NS + 5 * MS, lambda: run.live.stop(run.scenario)),
        (2 * NS, lambda: states.append(run.live.state)),
        (2 * NS, lambda: run.live.step(1)),
        (3 * NS, run.live.resume),
        (4 * NS, lambda: states.append(run.live.state)),
    )
    _, second = run.sink.segments
    assert (answers[0], second.start_ns) == (second, truth(1, 101)[0])
    assert states == [RunState.STOPPED, RunState.PLAYING]
    assert isinstance(answers[2], ControlError)
    assert run.sink.stamps == truth(len(run.sink.stamps))
    # time stands just before the start
    assert run.sink.sent_at[101] == 3 * NS + 1
    batch = next(batch for batch in run.sink.batches if batch.samples.stamps_ns[0] == second.start_ns)
    assert batch.samples.states[0].attitude_xyzw.tolist() == [0.0, 0.0, 0.0, 1.0]


def test_the_latest_sample_is_the_next_one_where_a_motion_begins() -> None:
    run = ScriptedRun(paused=True)
    wanted = Scenario.from_parameters({"motion": "closed_form", "initial_body_rate": [0.0, 0.0, 2.0]})
    answers = run.play(
        (NS, lambda: run.live.latest),
        (2 * NS, lambda: run.live.step(3)),
        (3 * NS, lambda: run.live.latest),
        (3 * NS, lambda: run.live.reset(wanted)),
        (3 * NS, lambda: run.live.latest),
    )
    stamps = [answer[0] for answer in answers if isinstance(answer, tuple)]
    assert stamps == [NS, NS + 2 * PERIOD, NS + 3 * PERIOD]
    last = answers[-1]
    assert isinstance(last, tuple)
    assert last[1].body_rate.tolist() == [0.0, 0.0, 2.0]


ACTIONS = ["pause", "resume", "reset", "stop", "step", "steps", "half", "double", "unlimited", "stall"]


@given(st.lists(st.tuples(st.integers(0, 20 * MS), st.sampled_from(ACTIONS)), max_size=20))
@settings(max_examples=40)
def test_no_stamp_is_lost_or_doubled_whatever_comes(rain: list[tuple[int, str]]) -> None:
    run, at = ScriptedRun(rate=333.3, imu_rate=1000.0, magnetometer_rate=77.0), 0
    live = run.live
    actions = {
        "pause": live.pause,
        "resume": live.resume,
        "reset": lambda: live.reset(run.scenario),
        "stop": lambda: live.stop(run.scenario),
        "step": lambda: live.step(1),
        "steps": lambda: live.step(700),
        "half": lambda: live.change_factor(0.5),
        "double": lambda: live.change_factor(2.0),
        "unlimited": lambda: live.change_factor(0.0) if live.state is not RunState.PLAYING else None,
        "stall": run.stall(3 * NS),
    }
    script = []
    for gap, name in rain:
        at += gap
        script.append((at, actions[name]))
    answers = run.play(*script, (at + 20 * MS, nothing))
    assert [a for a in answers if isinstance(a, Exception) and not isinstance(a, ControlError)] == []
    for stamps, rate in (
        (run.sink.stamps, 333.3),
        (run.sink.sensor_stamps("imu/data_raw"), 1000.0),
        (run.sink.sensor_stamps("imu/bias"), 1000.0),
        (run.sink.sensor_stamps("imu/mag"), 77.0),
    ):
        assert stamps == [NS + round(k * NS / Fraction(repr(rate))) for k in range(len(stamps))]
