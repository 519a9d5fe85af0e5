"""What ``record`` refuses for its disk, its files and its steps: status 2, one line on stderr, nothing created."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from lie_rigid_body.cli.record import main
from said import numbers


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])
    return tmp_path


def refusal(arguments: list[str], here: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The one line that a refused command prints."""
    before = {path.name: path.stat().st_mtime_ns for path in here.iterdir()}
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("lie-rigid-body record: error: ")
    assert printed.err.endswith("\n")
    assert printed.err.count("\n") == 1
    assert {path.name: path.stat().st_mtime_ns for path in here.iterdir()} == before
    return printed.err


def test_a_disk_with_too_little_room(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda path: (10**9, 10**9 - 52_000, 52_000))
    line = refusal(["out.mcap", "--duration", "5"], here, capsys)
    assert numbers(line) == [500, 52.5, 52]
    assert main(["out.mcap", "--duration", "4", "--quiet"]) == 0


def test_a_disk_that_fills_up_is_told_in_one_line(tmp_path: Path) -> None:
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000)); "
        "from lie_rigid_body.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [
        sys.executable,
        "-c",
        code,
        "record",
        str(tmp_path / "out.mcap"),
        "-p",
        "motion:=closed_form",
        "--duration",
        "100",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


def test_the_remedy_for_too_long_a_step_is_a_remedy(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["out.mcap", "--duration", "0.01", "-p", "initial_body_rate:=[6000.0, 2.0, 0.0]", "-p", "method:=rkmk4"]
    line = refusal(arguments, here, capsys)
    assert main([*arguments, "-p", f"max_step:={numbers(line)[-1]}", "--quiet"]) == 0


@pytest.mark.parametrize("rate", ["[1e-300, 2e-300, 0.0]", "[1e140, 2e140, 1.0]", "[0.0, 0.0, 0.0]"])
@pytest.mark.filterwarnings("error")
def test_extreme_rates_that_can_be_computed_are_allowed(here: Path, rate: str) -> None:
    arguments = ["out.mcap", "--duration", "0.1", "-p", f"initial_body_rate:={rate}", "-p", "motion:=closed_form"]
    assert main([*arguments, "--quiet"]) == 0
