"""The loop and its mailbox, without ROS and without waiting."""

from __future__ import annotations

from threading import Thread

import numpy as np
import pytest
from fake_time import NS, ScriptedRun

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.ros.timing.live_run import FAR_BEHIND_NS, STEPS_PER_BATCH, RunState
from lie_rigid_body.ros.timing.requests import ClosedError, ControlError, Mailbox
from lie_rigid_body.ros.timing.sink import MAX_BATCH
from lie_rigid_body.scenario import Scenario
from sampled import sampled


def nothing() -> None:
    """What is done at the end of a script."""


def test_a_run_that_is_woken_seldom_does_not_fall_behind_for_ever() -> None:
    """Each wait takes 22 ms longer, as on a machine that is busy with other things."""
    run = ScriptedRun(rate=1000.0)
    run.time.oversleep_ns = 22_000_000
    run.play((20 * NS, nothing))
    assert len(run.sink.stamps) > 6000
    assert max(run.sink.latest) < 1.02 * FAR_BEHIND_NS


@pytest.mark.parametrize(("rate", "wait"), [(50.0, 0.02), (1e5, 0.001)])
def test_waiting_reaches_to_the_next_sample_but_not_below_a_millisecond(rate: float, wait: float) -> None:
    run = ScriptedRun(rate=rate)
    run.play((NS, nothing))
    assert {round(w, 9) for w in run.time.waits} == {wait}


def test_reset_begins_with_the_next_sample() -> None:
    run = ScriptedRun()
    wanted = Scenario.from_parameters({"initial_body_rate": [0, 0, 9], "rate": 50})
    run.play((NS // 5 - 1, lambda: run.live.reset(wanted)), (2 * NS - 1, nothing))
    _, second = run.sink.segments
    assert second.start_ns == NS + NS // 5
    assert run.sink.events.index(second) == 1 + 20
    assert run.sink.stamps[:20] == [NS + k * 10_000_000 for k in range(20)]
    assert run.sink.stamps[20:] == [second.start_ns + k * 20_000_000 for k in range(90)]
    assert second.scenario.initial_body_rate == (0.0, 0.0, 9.0)


def test_where_the_stamps_end_the_run_pauses_until_a_reset() -> None:
    told = list[str]()
    run = ScriptedRun(rate=20.0, factor=0.0, start_ns=MAX_EPOCH_NS - 5 * NS, warn=told.append)
    *_, refused = run.play((2 * NS, run.live.resume), (3 * NS, nothing), (4 * NS, lambda: run.live.reset(run.scenario)))
    assert run.sink.stamps[-1] == MAX_EPOCH_NS
    assert len(run.sink.stamps) == 101
    assert run.live.state is RunState.PAUSED
    assert len(told) == 2
    assert isinstance(refused, ParameterError)


PATH = [number for k in range(5) for number in (k / 10.0, *[0.1 * k] * 3, 0.0, 0.0, 0.0, 1.0)]
"""Knots of 0.4 s."""


@pytest.mark.parametrize("factor", [0.0, 1.0, 7.0])
def test_the_run_ends_with_the_last_pose_of_its_path(factor: float) -> None:
    told = list[str]()
    run = ScriptedRun(motion="path", path_knots=PATH, imu_rate=30.0, factor=factor, warn=told.append)
    run.play((5 * NS, nothing))
    assert run.sink.stamps == [NS + k * 10_000_000 for k in range(41)]
    assert len(run.sink.sensor_stamps("imu/data_raw")) == 13
    assert run.interruption.requested
    assert len(told) == 1


def test_a_path_that_is_reset_begins_anew_and_steps_end_with_it() -> None:
    run = ScriptedRun(motion="path", path_knots=PATH)
    answers = run.play(
        (NS // 5 - 1, run.live.pause),
        (NS // 4, lambda: run.live.step(30)),
        (NS // 3, lambda: run.live.reset(run.scenario)),
        (NS // 2, run.live.resume),
        (2 * NS, nothing),
    )
    assert isinstance(answers[1], ControlError)
    second = run.sink.segments[1]
    assert run.sink.stamps[-1] == second.start_ns + 400_000_000


def test_a_clock_that_no_stamp_can_show_is_refused_at_the_start() -> None:
    with pytest.raises(ParameterError):
        ScriptedRun(imu_rate=10.0, imu_clock_offset=-5.0).play()


def test_failed_reset_is_answered_and_changes_nothing() -> None:
    def fail() -> None:
        raise InputError("no")

    run = ScriptedRun()
    answers = run.play((NS // 5, fail), (NS, nothing))
    assert isinstance(answers[0], InputError)
    assert len(run.sink.segments) == 1
    assert set(np.diff(run.sink.stamps).tolist()) == {10_000_000}


@pytest.mark.parametrize(("max_step", "most"), sampled([(1e-4, 20), (0.01, MAX_BATCH), (2e-6, 1)], every=3))
def test_batches_are_bounded_by_their_work(max_step: float, most: int) -> None:
    run = ScriptedRun(factor=0.0, motion="moving_chart", max_step=max_step)
    run.play((5_000_000, nothing))
    assert max(len(event) for event in run.sink.events if isinstance(event, list)) == most
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
    run = ScriptedRun()
    run.play((NS, nothing))
    with pytest.raises(ClosedError):
        Mailbox.request(run.time, int)
