"""A second signal at once changes nothing of how a node ends, wherever it is; a later one ends what closes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest
from simulator_process import LAST_LINE, assignments, without_lateness

from lie_rigid_body.recording.bag_reader import read_bag
from said import numbers
from sampled import sampled
from two_signals import DEADLINE, PAIRS, STRUCK, VERB, ended_by_the_second, fill, full_pipe, started, struck

pytestmark = pytest.mark.ros
INT, TERM = signal.SIGINT, signal.SIGTERM
EVALUATE = ["evaluate", "--ros-args", "-r", "estimate:=/nobody"]


def simulated(folder: Path, seed: int) -> None:
    """Strike the simulator once, and look at what it leaves."""
    bag, random = folder / f"{seed}.mcap", Random(f"sim {seed}")
    command = [sys.executable, "-c", STRUCK, "sim", *assignments(rate=1000.0, record_path=bag)]
    status, out, err = struck(command, folder, random, 4.0, PAIRS[seed % len(PAIRS)])
    assert (status, without_lateness(err.splitlines())) == (0, [])
    if bag.exists() and (said := numbers(out.splitlines()[-1])[0]):
        assert said == len(read_bag(bag).poses.stamps_ns)


def evaluated(folder: Path, seed: int) -> None:
    """Strike the evaluator once, before anything came that it could score."""
    command = [sys.executable, "-c", STRUCK, *EVALUATE]
    status, out, err = struck(command, folder, Random(f"evaluate {seed}"), 4.0, PAIRS[seed % len(PAIRS)])
    first, *last = [line for line in err.splitlines() if LAST_LINE[:-1] not in line]
    assert (status, out, last) == (130, "", []), err
    assert first.startswith("lie-rigid-body evaluate: error: "), err


LATER = range(1, 4)
STRIKES = [(simulated, [0]), (evaluated, [0]), (simulated, LATER), (evaluated, LATER)]


@pytest.mark.slow
@pytest.mark.parametrize(("strike", "seeds"), sampled(STRIKES, every=4))
def test_a_second_signal_changes_nothing_at_any_moment(strike, seeds, tmp_path: Path) -> None:
    for seed in seeds:
        strike(tmp_path, seed)


@pytest.mark.slow
@pytest.mark.parametrize("numbers", [(INT, TERM, INT), (TERM, INT, TERM)])
def test_a_later_signal_ends_a_simulator_that_closes_for_ever(
    numbers: tuple[signal.Signals, ...], tmp_path: Path
) -> None:
    """It says farewell on stdout, a pipe that became full."""
    read, write = os.pipe()
    process = subprocess.Popen([*VERB, "sim"], cwd=tmp_path, stdout=write, stderr=subprocess.DEVNULL, text=True)
    try:
        said = b""
        while LAST_LINE.encode() not in said:
            said += os.read(read, 4096)
        fill(write)
        assert ended_by_the_second(process, numbers) == -numbers[-1]
    finally:
        process.kill()
        process.wait(DEADLINE)
        os.close(read)
        os.close(write)


@pytest.mark.slow
def test_a_later_signal_ends_an_evaluator_that_cannot_close(tmp_path: Path) -> None:
    with full_pipe() as write:
        process = started([*VERB, *EVALUATE], tmp_path, write)
        try:
            time.sleep(1.0)
            assert ended_by_the_second(process, (INT, TERM, INT)) == -INT
        finally:
            process.kill()
    process.communicate()
