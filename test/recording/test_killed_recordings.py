"""A headless recording killed at random instants: what is recovered is the beginning of the whole, and certified."""

from __future__ import annotations

import itertools
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag

from lie_rigid_body.certificate import certify
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.recovery import recover

DURATION = "100000"
"""Duration that is asked for, s, which no recording reaches before it is killed. It needs 1.8 GB of free room."""
RUNS = {
    "new": ["-p", "motion:=closed_form", "-p", "imu_rate:=50.0", "--duration", DURATION],
    "to replace another": ["-p", "motion:=closed_form", "--compression", "lz4", "--duration", DURATION, "--force"],
}


def killed(folder: Path, kind: str, size: int) -> int:
    """Kill a recording that has so many bytes, and hold what is recovered of it against what it would have been."""
    folder.mkdir()
    out, old = folder / "out.mcap", b""
    if "--force" in RUNS[kind]:
        old = write_bag(out, count=5).read_bytes()
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(out), *RUNS[kind], "--quiet"]
    with subprocess.Popen(command) as process:
        try:
            broken = waited_for(folder, ".*.part" if old else "out.mcap", size)
        finally:
            process.kill()
    assert process.returncode == -signal.SIGKILL
    assert out.read_bytes() == old if old else check([str(out)]) == 2
    return recovered(broken, folder / "fixed.mcap")


def waited_for(folder: Path, pattern: str, size: int) -> Path:
    """The file of a pattern, once it has so many bytes."""
    while not (found := [path for path in folder.glob(pattern) if path.stat().st_size >= size]):
        time.sleep(0.001)
    return found[0]


def recovered(broken: Path, fixed: Path) -> int:
    """The samples of a bag that is certified, from the first one on; 0 if no message is whole."""
    try:
        recover(broken, fixed, overwrite=False)
    except BagError:
        return 0
    recording = read_bag(fixed)
    assert certify(recording).passed
    stamps = recording.poses.stamps_ns
    np.testing.assert_array_equal(stamps, np.arange(len(stamps)) * stamps[1:2].sum())
    return len(stamps)


@pytest.mark.long
@pytest.mark.parametrize("kills", [2, pytest.param(15, marks=pytest.mark.slow)])
def test_what_is_recovered_is_the_beginning(tmp_path: Path, kills: int) -> None:
    randomness = random.Random(kills)
    for i, kind in zip(range(kills), itertools.cycle(RUNS), strict=False):
        size = randomness.randint(1, 3_000_000)
        assert killed(tmp_path / str(i), kind, size) > 0 or size < 1_500_000  # of one chunk not all may be written
