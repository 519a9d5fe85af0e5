"""What ``record`` refuses: status 2, one line on stderr, nothing created."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lie_rigid_body.cli.record import main

BAD_PARAMETERS = {
    "inertia:=[1.0, -2.0, 3.0]": "inertia: .*-2",
    "inertia:=[1.0, 0.0, 3.0]": "inertia: ",
    "inertia:=[1.0, 2.0, 3.1]": "inertia: .*triangle",
    "inertia:=[1.0, 2.0]": "inertia: .*has 2 numbers: give 3 or 6",
    "inertia:=[1.0, 2.0, .nan]": "inertia: nan is not finite",
    "inertia:=[1.0, 2.0, inf]": "inertia: inf is not finite",
    "inertia:=[1.0, 2.0, 1e400]": "inertia: inf is not finite",
    "inertia:=heavy": "inertia: 'heavy' is not a list",
    "inertia:=[a, b, c]": "inertia: 'a' is not a number",
    "inertia:={a: 1}": "inertia: .*is not a list",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 0.0]": "initial_attitude_xyzw: norm 0 is not 1",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 1.1]": "initial_attitude_xyzw: norm 1.1 is not 1",
    "initial_body_rate:=[0.0, 0.0]": "initial_body_rate: ",
    "rate:=0.0": "rate: 0 is outside",
    "rate:=-5.0": "rate: -5 is outside",
    "rate:=.inf": "rate: inf is not finite",
    "rate:=fast": "rate: 'fast' is not a number",
    "method:=euler": "method: 'euler' is unknown: choose one of",
    "motion:=flying": "motion: 'flying' is unknown: choose one of moving_chart, closed_form",
    "max_step:=0.0": "max_step: 0 is outside",
    "max_step:=100.0": None,
    "inertia:=[1e-320, 1e-320, 1e-320]": "inertia: principal moments .* are beyond double precision",
    "inertia:=[1e308, 1e308, 1e308]": "inertia: principal moments .* are beyond double precision",
    "initial_body_rate:=[1e200, 0.0, 0.0]": "initial_body_rate: 1e.200, 0, 0 rad/s gives an energy of inf",
    "initial_body_rate:=[1e308, 1e308, 1e308]": "initial_body_rate: .*a momentum of inf",
    "initial_body_rate:=[1e-160, 2e-161, 0.0]": "initial_body_rate: .* beyond double precision",
    "initial_body_rate:=[1e140, 0.0, 0.0]": "initial_body_rate: .* steps between samples, .*: .* or use closed_form",
    "world_frame:=/world": "world_frame: '/world' is not a frame name",
    "body_frame:=''": "body_frame: '' is not a frame name",
    "stamped_twist:=1": "stamped_twist: 1 is not a bool",
    "epoch_ns:=1.5": "epoch_ns: 1.5 is not an integer",
    "epoch_ns:=-1": "epoch_ns: -1 is outside",
    "epoch_ns:=2147483647000000000": "epoch_ns: sample 999 would be stamped .* start earlier",
    "inertai:=[1.0, 2.0, 3.0]": "inertai: no such parameter: did you mean inertia?",
    "rate=5": "'rate=5' is not NAME:=VALUE",
    "rate:=[1.0": "not readable as YAML",
}
BAD_USAGE = {
    "": "the following arguments are required: OUT.mcap, --duration",
    "out.mcap": "required: --duration",
    "--duration 1": "required: OUT.mcap",
    "out.mcap --duration": "argument --duration: expected one argument",
    "out.mcap --duration 1 --fast": "unrecognized arguments: --fast",
    "out.mcap --dur 1": "required: --duration",
    "out.mcap other.mcap --duration 1": "unrecognized arguments: other.mcap",
    "out.mcap --duration 0": "--duration 0 is not a time from",
    "out.mcap --duration -1": "--duration -1 is not a time from",
    "out.mcap --duration nan": "--duration nan is not a time from",
    "out.mcap --duration inf": "--duration inf is not a time from",
    "out.mcap --duration 1_0": "--duration 1_0 is not a time from",
    "out.mcap --duration ٣": "--duration ٣ is not a time from",
    "out.mcap --duration soon": "--duration soon is not a time from",
    "out.mcap --duration 1e999999999": "--duration 1e999999999 is not a time from",
    "out.mcap --duration 1e-999999999": "--duration 1e-999999999 is not a time from",
    "out.mcap --duration 5e9": "epoch_ns: sample .* would be stamped .* sample for a shorter time",
    "out.mcap --duration 1 --compression gzip": "argument --compression: invalid choice: 'gzip'",
    "out.mcap --duration 1 --chunk-size 0": "--chunk-size 0 is not a number of bytes from 1 to 16777216: give for",
    "out.mcap --duration 1 --chunk-size 1e6": "--chunk-size 1e6 is not a number of bytes",
    "out.mcap --duration 1 --chunk-size 16777217": "--chunk-size 16777217 is not a number of bytes",
    "out.mcap --duration 1 --scenario none": "scenario 'none' is unknown: the scenarios are asymmetric_top, ",
    "out.mcap --duration 1 --scenario dzanibekov": "did you mean dzhanibekov?",
    "out.mcap --duration 1 --params-file none.yaml": "none.yaml does not exist",
    "out.mcap --duration 1 --params-file .": "is a folder",
    "out.mcap --duration 1 --params-file bad.yaml": "bad.yaml, line 2, column 1: not readable as YAML",
    "out.mcap --duration 1 --params-file other.yaml": "no section for the node /lie_rigid_body, only for /talker",
    "none/out.mcap --duration 1": "folder none does not exist: make it",
    ". --duration 1": ". is a folder",
    "bad.yaml --duration 1": "bad.yaml exists and is kept: give another name, or --force",
    "bad.yaml/out.mcap --duration 1": "Not a directory",
    "/proc/out.mcap --duration 1": "/proc/out.mcap cannot be created: No such file",
    "fifo --duration 1 --force": "fifo is not a regular file",
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "bad.yaml").write_text("/**: [1,\n")
    (tmp_path / "other.yaml").write_text("talker: {ros__parameters: {rate: 1.0}}")
    os.mkfifo(tmp_path / "fifo")
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


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("assignment", [name for name, said in BAD_PARAMETERS.items() if said])
def test_bad_parameters(here: Path, capsys: pytest.CaptureFixture[str], assignment: str) -> None:
    line = refusal(["out.mcap", "--duration", "10", "-p", assignment], here, capsys)
    said = BAD_PARAMETERS[assignment]
    assert said
    assert re.search(said, line)


@pytest.mark.parametrize("command", BAD_USAGE)
def test_bad_usage(here: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert re.search(BAD_USAGE[command], refusal(command.split(), here, capsys))


def test_a_disk_with_too_little_room(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda path: (10**9, 10**9 - 52_000, 52_000))
    line = refusal(["out.mcap", "--duration", "5"], here, capsys)
    assert "out.mcap: 500 samples need about 52.5 kB and 52 kB are free there: record a shorter time" in line
    assert main(["out.mcap", "--duration", "4", "--quiet"]) == 0


def test_a_file_gives_the_same_refusal_as_an_assignment_and_is_named(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "flat.yaml").write_text("/**:\n  ros__parameters:\n    inertia: [1.0, 2.0, 3.1]\n")
    (here / "good.yaml").write_text("/**:\n  ros__parameters:\n    rate: 10.0\n")
    (here / "unknown.yaml").write_text("/**:\n  ros__parameters:\n    speed: 10.0\n")
    given = ["out.mcap", "--duration", "10", "--params-file", "flat.yaml", "--params-file", "good.yaml"]
    line = refusal(given, here, capsys)
    assert "error: flat.yaml: inertia: " in line
    assert "triangle" in line
    assert "error: rate: " in refusal([*given, "-p", "rate:=0.0"], here, capsys)
    assert "error: unknown.yaml: speed: " in refusal([*given, "--params-file", "unknown.yaml"], here, capsys)


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
    assert "out.mcap cannot be written: File too large; " in done.stderr
    assert "lie-rigid-body recover" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_remedy_for_too_long_a_step_is_a_remedy(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["out.mcap", "--duration", "0.01", "-p", "initial_body_rate:=[6000.0, 2.0, 0.0]", "-p", "method:=rkmk4"]
    line = refusal(arguments, here, capsys)
    found = re.search("give at most (.*) s, or use closed_form", line)
    assert found
    assert main([*arguments, "-p", f"max_step:={found[1]}", "--quiet"]) == 0


@pytest.mark.parametrize("rate", ["[1e-300, 2e-300, 0.0]", "[1e140, 2e140, 1.0]", "[0.0, 0.0, 0.0]"])
@pytest.mark.filterwarnings("error")
def test_extreme_rates_that_can_be_computed_are_allowed(here: Path, rate: str) -> None:
    arguments = ["out.mcap", "--duration", "0.1", "-p", f"initial_body_rate:={rate}", "-p", "motion:=closed_form"]
    assert main([*arguments, "--quiet"]) == 0
