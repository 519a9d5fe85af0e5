"""A headless recording killed at random instants: what is recovered is the beginning of the whole, and certified."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from lie_rigid_body.certificate import certify
from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.recovery import recover

KILLS = 100


@pytest.mark.slow
def test_what_is_recovered_is_the_beginning(tmp_path: Path, record_property: Callable[[str, object], None]) -> None:
    randomness, recovered = random.Random(3), list[int]()
    arguments = ["-p", "motion:=closed_form", "-p", "imu_rate:=50.0", "--duration", "1000000", "--quiet"]
    for number in range(KILLS):
        broken, fixed = tmp_path / f"{number}.mcap", tmp_path / f"{number}-fixed.mcap"
        with subprocess.Popen([sys.executable, "-m", "lie_rigid_body", "record", broken, *arguments]) as process:
            while not broken.exists():
                assert process.poll() is None
                time.sleep(0.001)
            time.sleep(randomness.uniform(0.0, 0.2))
            process.send_signal(signal.SIGKILL)
        try:
            recover(broken, fixed, overwrite=False)
        except BagError:
            continue
        recording = read_bag(fixed)
        stamps = recording.poses.stamps_ns
        assert stamps.tolist() == list(range(0, len(stamps) * 10_000_000, 10_000_000))
        assert certify(recording).passed
        recovered.append(len(stamps))
        broken.unlink()
        fixed.unlink()
    record_property("kills", KILLS)
    record_property("with whole chunks, recovered", len(recovered))
    record_property("samples, at most", max(recovered))
