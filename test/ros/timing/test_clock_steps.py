"""The time of day stepped back or ahead while the node runs: its stamps go on as though nothing had been."""

from __future__ import annotations

import itertools
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from broken_bag import stamps_in_whole_chunks
from fake_time import NS, ScriptedRun
from simulator_process import SimulatorProcess, assignments, eventually

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import read_bag

HOUR = 3600 * NS
DAY = 1_700_000_000 * NS
STEPPING = r"""
#include <time.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

static long begun;

/* 4 s after the first question the time of day goes an hour back, and after 4 s more two hours ahead. */
static long step(void) {
    struct timespec now;
    syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
    if (!begun) begun = now.tv_sec;
    long since = now.tv_sec - begun;
    return since < 4 ? 0 : since < 8 ? -3600 : 3600;
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    int status = syscall(SYS_clock_gettime, clock, now);
    if (clock == CLOCK_REALTIME) now->tv_sec += step();
    return status;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    struct timespec found;
    clock_gettime(CLOCK_REALTIME, &found);
    now->tv_sec = found.tv_sec;
    now->tv_usec = found.tv_nsec / 1000;
    return 0;
}

time_t time(time_t *out) {
    struct timespec found;
    clock_gettime(CLOCK_REALTIME, &found);
    if (out) *out = found.tv_sec;
    return found.tv_sec;
}
"""
"""A library that is loaded before that of C, and steps the clock for the whole process."""
GOES_BACK = "import time; before = time.time(); time.sleep(4.5); print(time.time() < before)"


def test_the_time_of_day_is_asked_once() -> None:
    """Later steps, in either direction, change no stamp; neither does a reset, nor a pause."""
    days = itertools.chain([DAY], itertools.cycle([DAY - HOUR, DAY + HOUR]))
    run = ScriptedRun(rate=100.0, imu_rate=30.0, wall=lambda: next(days))
    run.play(
        (NS, lambda: run.live.reset(run.scenario)),
        (2 * NS, run.live.pause),
        (3 * NS, run.live.resume),
        (4 * NS, lambda: None),
    )
    assert run.sink.stamps[0] == DAY
    assert set(np.diff(run.sink.stamps).tolist()) == {NS // 100}
    assert len(run.sink.stamps) == pytest.approx(300, abs=2)


@pytest.mark.ros
@pytest.mark.slow
def test_a_recording_goes_on_through_steps_of_an_hour(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (compiler := shutil.which("cc")):
        pytest.skip("no C compiler is installed")
    (tmp_path / "step.c").write_text(STEPPING)
    library, bag = tmp_path / "step.so", tmp_path / "stepped.mcap"
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, tmp_path / "step.c"], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(library))
    assert subprocess.check_output([sys.executable, "-c", GOES_BACK]) == b"True\n"
    with SimulatorProcess(*assignments(rate=100.0, imu_rate=20.0, record_path=bag)) as simulator:
        monkeypatch.delenv("LD_PRELOAD")
        # of what is recorded, as the node has seen the clock step twice by then
        eventually(lambda: len(stamps_in_whole_chunks(bag)) > 1200, "12 s of samples")
        assert simulator.end(signal.SIGINT) == 0
    recording = read_bag(bag)
    assert set(np.diff(recording.poses.stamps_ns).tolist()) == {NS // 100}
    assert certify(recording).passed
