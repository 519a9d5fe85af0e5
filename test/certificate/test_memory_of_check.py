"""The largest memory of `check`, whatever its bag: measured on bags that take most of it for their length."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from sensor_bags import write

from lie_rigid_body.cli.record import main as record

MEMORY = 300 * 2**20
"""What it may take, bytes: its libraries and compiled loops, and some ten thousand messages."""
RUN = """
import sys
from pathlib import Path
from lie_rigid_body.__main__ import main
assert main(["check", sys.argv[1]]) == 0
(peak,) = [line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM")]
print(peak.split()[1], file=sys.stderr)
"""
"""The largest memory in KiB is that of the process alone: what `wait4` gives may be that of its parent."""
LOSING = ("imu_rate:=1000.0", "imu_dropout_probability:=0.5")
LARGE = ("imu_rate:=200.0", "gyro_noise_density:=0.001")


def recorded(path: Path, rate: float, duration: float, parameters: tuple[str, ...], *options: str) -> None:
    values = [word for name in ("motion:=closed_form", f"rate:={rate}", *parameters) for word in ("-p", name)]
    assert (
        record([str(path), "--scenario", "dzhanibekov", *values, "--duration", str(duration), "--quiet", *options]) == 0
    )


def reset_often(path: Path) -> None:
    fast = {"motion": "closed_form", "rate": 100.0, "imu_rate": 500.0, "magnetometer_rate": 500.0}
    write(
        path, *[({**fast, "initial_body_rate": [0.1, 1.0, 0.5 + i * 1e-4]}, 1.0) for i in range(600)], chunk_size=2**19
    )


BAGS: dict[str, Callable[[Path], None]] = {
    "half of the readings are lost": lambda path: recorded(path, 10.0, 800.0, LOSING),
    "the largest chunks": lambda path: recorded(path, 1000.0, 900.0, LARGE, "--chunk-size", str(2**24)),
    "resets": reset_often,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BAGS)
def test_check_stays_within_its_memory(
    name: str, tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    path = tmp_path / "bag.mcap"
    BAGS[name](path)
    done = subprocess.run([sys.executable, "-c", RUN, str(path)], capture_output=True, text=True, check=True)
    memory = 1024 * int(done.stderr)
    record_property("largest memory, MiB", memory // 2**20)
    assert memory < MEMORY
