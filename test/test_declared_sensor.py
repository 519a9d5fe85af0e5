"""A sensor that is registered before rooms make their tables of the sensors is one like the others."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.slow
@pytest.mark.parametrize("which", ["not slow", "slow"])
def test_a_declared_sensor_is_one_like_the_others(which: str) -> None:
    """The tests of a horizon sensor, which is imported before anything else into a process of its own."""
    options = ["-q", "-p", "horizon_sensor", "-p", "no:cacheprovider", "--noconftest"]
    options += ["-m", which if find_spec("rclpy") else f"{which} and not ros"]
    command = [sys.executable, "-m", "pytest", *options, str(HERE / "declared_sensor.py")]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(HERE)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
