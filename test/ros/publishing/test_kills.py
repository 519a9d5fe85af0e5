"""A recording node killed at a random instant: what was whole on the disk is recovered, and certified.

That it flushes twice a second is held without a process, in `test_recorder`.
"""

from __future__ import annotations

import random
import signal
import time
from pathlib import Path

import pytest
from broken_bag import stamps_in_whole_chunks
from simulator_process import SimulatorProcess, assignments, eventually

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.recovery import recover

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NS = 1_000_000_000
EARLY = 3
"""Kills before anything is waited for, mostly before anything was written to the disk."""


def recovered_until(bag: Path, fixed: Path) -> int:
    """The stamp of the last sample recovered, ns, of a bag that is certified; 0 if it holds no whole message."""
    try:
        recover(bag, fixed, overwrite=False)
    except BagError:
        return 0
    recording = read_bag(fixed)
    certificate = certify(recording)
    assert certificate.passed, certificate.messages
    return int(recording.poses.stamps_ns[-1])


@pytest.mark.parametrize("seed", range(12))
def test_what_was_written_before_a_kill_is_recovered(tmp_path: Path, seed: int) -> None:
    randomness, bag = random.Random(seed), tmp_path / "killed.mcap"
    # in a namespace of its own, as others go on to see for a while what dies without a word
    given = (*assignments(imu_rate=50.0, record_path=bag), "--ros-args", "-r", f"__ns:=/run_{seed}")
    with SimulatorProcess(*given) as simulator:
        if seed >= EARLY:
            flushed = randomness.randint(1, 4)
            eventually(lambda: len({t // NS for t in stamps_in_whole_chunks(bag)}) >= flushed, "what is written first")
        time.sleep(randomness.uniform(0.0, 0.5))
        written = stamps_in_whole_chunks(bag) if bag.exists() else []
        simulator.process.send_signal(signal.SIGKILL)
        assert simulator.wait() == -signal.SIGKILL
    assert recovered_until(bag, tmp_path / "fixed.mcap") >= max(written, default=0)
