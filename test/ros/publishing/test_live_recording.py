"""What a recording node leaves behind, however it ends."""

from __future__ import annotations

import os
import re
import resource
import shlex
import signal
import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from broken_bag import stamps_in_whole_chunks
from simulator_process import (
    DEADLINE,
    SimulatorProcess,
    assignments,
    cpu_seconds,
    eventually,
    sim_command,
    without_lateness,
)

from lie_rigid_body.certificate import certify
from lie_rigid_body.cli import check
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.recovery import recover
from sampled import sampled

pytestmark = pytest.mark.ros


def test_what_was_written_before_a_kill_is_recovered(tmp_path: Path) -> None:
    bag = tmp_path / "killed.mcap"
    # in a namespace of its own, as others go on to see for a while what dies without a word
    arguments = ("-p", "rate:=200.0", "-p", f"record_path:={bag}", "--ros-args", "-r", "__ns:=/killed")
    with SimulatorProcess(*arguments) as simulator:
        eventually(lambda: len(stamps_in_whole_chunks(bag)) > 200, "chunks")
        safe = stamps_in_whole_chunks(bag)
        simulator.process.send_signal(signal.SIGKILL)
        assert simulator.wait() == -signal.SIGKILL
    recover(bag, tmp_path / "fixed.mcap", overwrite=False)
    recording = read_bag(tmp_path / "fixed.mcap")
    assert certify(recording).passed
    assert set(np.diff(stamps := recording.poses.stamps_ns).tolist()) == {5_000_000}
    assert {*safe} <= {*stamps.tolist()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "numbers"),
    sampled([("200.0", (signal.SIGHUP, signal.SIGINT)), ("100000.0", (signal.SIGTERM, signal.SIGINT))], every=2),
)
def test_impatient_signals_leave_a_whole_bag(tmp_path: Path, rate: str, numbers: tuple[signal.Signals, ...]) -> None:
    """At the higher rate, which no machine keeps up with, they come in the middle of catching up."""
    bag = tmp_path / "whole bag.mcap"
    with SimulatorProcess("-p", f"rate:={rate}", "-p", f"record_path:='{bag}'") as simulator:
        size = bag.stat().st_size
        eventually(lambda: bag.stat().st_size > size, "samples")
        assert simulator.end(*numbers, signal.SIGINT) == 0
    recording = read_bag(bag)
    assert recording.expected_samples == len(recording.poses.stamps_ns) > 0
    assert set(np.diff(recording.poses.stamps_ns).tolist()) == {round(1e9 / float(rate))}
    assert simulator.said[-1].endswith(f": lie-rigid-body check '{bag}'")


@pytest.mark.slow
def test_the_command_that_certifies_names_the_topics_that_were_remapped(tmp_path: Path) -> None:
    bag, remaps = tmp_path / "a.mcap", ("imu/data_raw:=/imu", "~/faults:=/odd")
    arguments = assignments(record_path=bag, imu_rate=50.0, imu_dropout_probability=0.5)
    with SimulatorProcess(*arguments, "--ros-args", *(word for remap in remaps for word in ("-r", remap))) as simulator:
        eventually(lambda: len(stamps_in_whole_chunks(bag)) > 20, "samples")
        assert simulator.end(signal.SIGTERM) == 0
    command = shlex.split(simulator.said[-1].partition(": lie-rigid-body check ")[2])
    assert sorted(command) == sorted([str(bag), *("--topic",) * 2, *remaps])
    assert check.main(command) == 0


def test_a_bag_without_a_sample_is_not_said_to_be_certified(tmp_path: Path) -> None:
    with SimulatorProcess("-p", "paused:=true", "-p", f"record_path:={tmp_path / 'none.mcap'}") as simulator:
        assert simulator.end(signal.SIGTERM) == 0
    assert simulator.said[-1] == "recorded 0 samples"


@pytest.mark.slow
def test_signal_while_one_sample_takes_long_to_compute(tmp_path: Path) -> None:
    bag = tmp_path / "whole.mcap"
    arguments = ("-p", "rate:=1.0", "-p", "max_step:=1e-6", "-p", f"record_path:={bag}")
    # with numba, which takes its time to load, it is the same pieces of work, in test_record.py
    with SimulatorProcess(*arguments, without=("numba",)) as simulator:
        eventually(lambda: bool(stamps_in_whole_chunks(bag)), "the first sample")
        idle = cpu_seconds(simulator.process.pid)
        eventually(lambda: cpu_seconds(simulator.process.pid) > idle + 0.3, "work on the second sample")
        assert simulator.end(signal.SIGINT) == 0
    assert read_bag(bag).expected_samples == 1


def end_of_a_lost_recording(simulator: SimulatorProcess, bag: Path) -> None:
    """It was told in the log at once, and is the last line when the node ends, with status 2.

    Fast DDS of Kilted complains as well where a limit of files leaves it no shared memory.
    """
    eventually(lambda: simulator.heard(bag.name), "a complaint")
    assert simulator.end(signal.SIGTERM) == 2
    logged, last = (line for line in simulator.errors() if bag.name in line)
    assert re.search(rf"ERROR.*{bag.name} ", logged)
    assert re.match(rf"lie-rigid-body sim: error: .*{bag.name} ", last)
    assert [line for line in simulator.said if "lie-rigid-body check" in line] == []


@pytest.mark.slow
def test_full_disk_ends_the_recording_but_not_the_node(tmp_path: Path) -> None:
    bag = tmp_path / "full.mcap"
    limit = 60_000
    shrink = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit))
    with SimulatorProcess(*assignments(rate=1000.0, record_path=bag), preexec=shrink) as simulator:
        end_of_a_lost_recording(simulator, bag)
    assert bag.stat().st_size <= limit


SMALL_BACKLOG = """
import sys
from lie_rigid_body.system import output_file
output_file.MAX_BACKLOG = 1
from lie_rigid_body.__main__ import main
sys.exit(main(["sim", *sys.argv[1:]]))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "status"), [(0.0, 0), (1.0, 2)])
def test_only_a_run_that_promises_no_time_waits_for_a_disk_that_does_not_keep_up(
    tmp_path: Path, factor: float, status: int
) -> None:
    bag = tmp_path / "whole.mcap"
    arguments = assignments(real_time_factor=factor, record_path=bag, rate=200.0)
    with SimulatorProcess(*arguments, program=["-c", SMALL_BACKLOG]) as simulator:
        eventually(
            lambda: bool(simulator.complained) if status else bag.stat().st_size > 6000, "samples, or a complaint"
        )
        if status:
            end_of_a_lost_recording(simulator, bag)
        else:
            assert simulator.end(signal.SIGINT) == 0


@pytest.mark.slow
@pytest.mark.parametrize("stdout", sampled(["without a reader", "closed"], every=2))
def test_works_without_stdout(tmp_path: Path, stdout: str) -> None:
    bag = tmp_path / "whole.mcap"
    reader, writer = os.pipe()
    os.close(reader)
    redirection = ">&-" if stdout == "closed" else ""
    command = ["sh", "-c", f'exec "$@" {redirection}', "sh", *sim_command("-p", f"record_path:={bag}")]
    with subprocess.Popen(command, stdout=writer, stderr=subprocess.PIPE, text=True) as process:
        os.close(writer)
        try:
            eventually(lambda: bag.exists() and bag.stat().st_size > 6000, "samples")
            process.send_signal(signal.SIGTERM)
            _, complaint = process.communicate(timeout=DEADLINE)
        finally:
            process.kill()
    assert (process.returncode, without_lateness(complaint.splitlines())) == (0, [])
    assert read_bag(bag).pose_topic == "/pose"
