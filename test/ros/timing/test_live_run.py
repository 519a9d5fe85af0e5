"""The loop without ROS and without waiting: a steady clock that the test holds."""

from __future__ import annotations

from threading import Thread

import numpy as np
import pytest
from fake_time import NS, FakeTime, KeepingSink

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.ros.timing.live_run import FAR_BEHIND_NS, STEPS_PER_BATCH, LiveRun, RunState
from lie_rigid_body.ros.timing.requests import Call, ClosedError, Mailbox
from lie_rigid_body.ros.timing.sink import MAX_BATCH
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interruption import Interruption


def run(time: FakeTime, enough: int, factor: float = 1.0, **parameters: object) -> KeepingSink:
    interruption = Interruption()
    sink = KeepingSink(interruption, enough)
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form", **parameters}), NS)
    LiveRun(simulation, [sink], time, interruption, time.steady, factor=factor).run()
    return sink


def test_a_run_that_is_woken_seldom_does_not_fall_behind_for_ever() -> None:
    """Each wait takes 22 ms longer, as on a machine that is busy with other things."""
    sink = run(FakeTime(dict.fromkeys(range(1000), 22_000_000)), 6000, rate=1000.0)
    assert max(sink.latest) < 1.02 * FAR_BEHIND_NS


def test_waiting_reaches_to_the_next_sample_but_not_below_a_millisecond() -> None:
    slow, fast = FakeTime({}), FakeTime({})
    run(slow, 100, rate=50.0)
    run(fast, 5000, rate=1e5)
    assert {round(w, 9) for w in slow.waits} == {0.02}
    assert {round(w, 9) for w in fast.waits} == {0.001}


def test_reset_begins_with_the_next_sample() -> None:
    time = FakeTime({})
    interruption = Interruption()
    sink = KeepingSink(interruption, 100)
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form"}), NS)
    live = LiveRun(simulation, [sink], time, interruption, time.steady)
    time.calls[20] = Call(lambda: live.reset(Scenario.from_parameters({"initial_body_rate": [0, 0, 9], "rate": 50})))
    live.run()
    _, second = sink.segments
    assert second.start_ns == NS + 20 * 10_000_000
    assert sink.events.index(second) == 1 + 20
    assert sink.stamps[:20] == [NS + k * 10_000_000 for k in range(20)]
    assert sink.stamps[20:] == [second.start_ns + k * 20_000_000 for k in range(80)]
    assert second.scenario.initial_body_rate == (0.0, 0.0, 9.0)


def test_where_the_stamps_end_the_run_pauses_until_a_reset() -> None:
    time, interruption, told = FakeTime({}), Interruption(), list[str]()
    sink = KeepingSink(interruption, 10_000)
    simulation = Simulation(Scenario.from_parameters({"rate": 20.0, "motion": "closed_form"}), MAX_EPOCH_NS - 5 * NS)
    live = LiveRun(simulation, [sink], time, interruption, time.steady, factor=0.0, warn=told.append)
    time.calls[20] = Call(live.resume)
    time.calls[30] = Call(live.quit)
    live.run()
    assert sink.stamps[-1] == MAX_EPOCH_NS
    assert len(sink.stamps) == 101
    assert live.state is RunState.PAUSED
    assert len(told) == 2
    with pytest.raises(ParameterError):
        live.reset(simulation.segment.scenario)


def test_a_clock_that_no_stamp_can_show_is_refused_at_the_start() -> None:
    interruption = Interruption()
    given = {"motion": "closed_form", "imu_rate": 10.0, "imu_clock_offset": -5.0}
    live = LiveRun(Simulation(Scenario.from_parameters(given), NS), [], FakeTime({}), interruption)
    with pytest.raises(ParameterError):
        live.run()


def test_failed_reset_is_answered_and_changes_nothing() -> None:
    def fail() -> None:
        raise InputError("no")

    call: Call[object] = Call(fail)
    sink = run(FakeTime({}, {20: call}), 100)
    assert len(sink.segments) == 1
    assert set(np.diff(sink.stamps).tolist()) == {10_000_000}
    with pytest.raises(InputError):
        call.outcome.result()


@pytest.mark.parametrize(("max_step", "most"), [(0.01, MAX_BATCH), (1e-4, 20), (2e-6, 1)])
def test_batches_are_bounded_by_their_work(max_step: float, most: int) -> None:
    sink = run(FakeTime({}), most + 5, factor=0.0, motion="moving_chart", max_step=max_step)
    assert max(len(event) for event in sink.events if isinstance(event, list)) == most
    assert most * 0.01 / max_step <= STEPS_PER_BATCH or most == 1


def asked(mailbox: Mailbox) -> tuple[Thread, list[object]]:
    """A thread that asks for 42, and what it gets."""
    got: list[object] = []

    def ask() -> None:
        try:
            got.append(mailbox.request(lambda: 42))
        except ClosedError as error:
            got.append(error)

    thread = Thread(target=ask, daemon=True)
    thread.start()
    return thread, got


@pytest.mark.parametrize("closed", [False, True])
def test_a_call_from_another_thread_is_carried_out_by_the_owner_whose_end_keeps_the_answer(closed: bool) -> None:
    mailbox = Mailbox()
    thread, got = asked(mailbox)
    call = mailbox.wait(10.0)
    assert call is not None
    call.carry_out()
    if closed:
        mailbox.close()
    thread.join(10.0)
    assert got == [42]


@pytest.mark.parametrize("taken", [False, True])
def test_a_closed_mailbox_refuses_what_waits_what_was_taken_and_what_comes(taken: bool) -> None:
    """A signal may come just after the owner has taken a call."""
    mailbox = Mailbox()
    thread, got = asked(mailbox)
    while mailbox._calls.empty():
        pass
    if taken:
        assert mailbox.wait(10.0) is not None
    mailbox.close()
    thread.join(10.0)
    later, refused = asked(mailbox)
    later.join(10.0)
    assert [type(each) for each in (*got, *refused)] == [ClosedError, ClosedError]


def test_a_run_that_has_ended_refuses_what_comes() -> None:
    time = FakeTime({})
    run(time, 5)
    thread, got = asked(time)
    thread.join(10.0)
    assert [type(each) for each in got] == [ClosedError]
