"""The node starts without the libraries that only some of its users need, and names one that is missed."""

from __future__ import annotations

import signal
import subprocess

import pytest
from simulator_process import DEADLINE, SimulatorProcess, sim_command

pytestmark = pytest.mark.ros


def test_without_a_bag_and_sensors_the_node_needs_few_libraries() -> None:
    with SimulatorProcess(without=["mcap", "zstandard", "scipy", "matplotlib", "tqdm"]) as running:
        assert running.end(signal.SIGINT) == 0
    assert running.errors() == []


def test_a_bag_that_cannot_be_written_is_told_before_the_first_sample(tmp_path) -> None:
    done = subprocess.run(
        sim_command("-p", "record_path:=run.mcap", without=["mcap"]),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    [line] = done.stderr.splitlines()
    assert line.endswith(": pip install mcap")
    assert list(tmp_path.iterdir()) == []
