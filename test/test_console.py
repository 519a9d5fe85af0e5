"""Whatever becomes of stdout, users see one line at most, and a status that means what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from lie_rigid_body.cli.record import main as record

ANSWERS = [
    "--help",
    "scenarios --json",
    "check {bag}",
    "explain",
    "evaluate {bag} --estimate /pose",
]
WRITERS = ["record {new} --duration 0.1", "plot {bag} -o {new}.png"]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("console") / "bag.mcap"
    assert record([str(path), "--duration", "0.1", "--quiet"]) == 0
    return path


def run(command: str, bag: Path, folder: Path, redirection: str) -> subprocess.CompletedProcess[str]:
    arguments = command.format(bag=bag, new=folder / "new.mcap")
    line = f"{sys.executable} -m lie_rigid_body {arguments} {redirection}"
    return subprocess.run(line, shell=True, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("command", [*ANSWERS, *WRITERS])
def test_full_stdout_is_told_in_one_line(command: str, bag: Path, tmp_path: Path) -> None:
    done = run(command, bag, tmp_path, ">/dev/full")
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert "stdout cannot be written: No space left on device" in line


@pytest.mark.parametrize("command", [*ANSWERS, *WRITERS])
def test_closed_stdout_is_nobodys_fault(command: str, bag: Path, tmp_path: Path) -> None:
    done = run(command, bag, tmp_path, ">&-")
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("command", ANSWERS)
def test_reader_who_leaves_hears_no_complaint(command: str, bag: Path, tmp_path: Path) -> None:
    done = run(command, bag, tmp_path, "| true")
    assert done.stderr == ""
