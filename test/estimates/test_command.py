"""Estimators as programs and as functions: what they do wrong is told in one line."""

from __future__ import annotations

import importlib
import json
import math
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import attitude_error, diagnose
from lie_rigid_body.cli import diagnose as verb
from lie_rigid_body.cli import league
from lie_rigid_body.estimates.estimators import told
from lie_rigid_body.estimates.programs import HEADER, CommandEstimator
from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.league import CASES, playing
from lie_rigid_body.runs import Estimate
from lie_rigid_body.testing import command_estimator, node_estimator
from untyped import simulate

EXAMPLE = Path(__file__).parents[2] / "examples" / "command_filter" / "gyro_only.cpp"
AT_REST = [0.0, 0.0, 0.0, 1.0]


@pytest.fixture(scope="module")
def run():
    rates = {"imu_rate": 100.0, "magnetometer_rate": 30.0, "gyro_rate": "integrated"}
    return simulate("tumbling_cubesat", duration=2.0, initial_attitude_xyzw=AT_REST, **rates)


def python(tmp_path: Path, source: str, timeout_s: float = 30.0) -> CommandEstimator:
    (tmp_path / "a filter.py").write_text(f"import os, sys, time\n{source}\n")
    return CommandEstimator(f"{sys.executable} '{tmp_path / 'a filter.py'}'", timeout_s)


def test_a_program_is_given_every_reading_to_the_last_bit(run, tmp_path):
    estimate = python(tmp_path, "open(sys.argv[0] + '.csv', 'w').write(sys.stdin.read())\nprint('1,0,0,0,1')")
    estimate(run)
    header, *lines = (tmp_path / "a filter.py.csv").read_text().splitlines()
    assert header == HEADER
    rows = [line.split(",") for line in lines]
    assert {len(row) for row in rows} == {10}
    assert [int(row[0]) for row in rows] == sorted({*run.imu.t_ns.tolist(), *run.magnetometer.t_ns.tolist()})
    imu = np.array([row[1:7] for row in rows if row[1]], dtype=float)
    assert np.array_equal(imu, np.hstack([run.imu.gyro, run.imu.specific_force]))
    assert np.array_equal(np.array([row[7:] for row in rows if row[7]], dtype=float), run.magnetometer.field)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_the_example_in_cpp_is_exact_with_integrated_rates(run, tmp_path):
    program = tmp_path / "gyro_only"
    subprocess.run(["g++", "-O2", "-Wall", "-Werror", "-o", program, EXAMPLE], check=True, timeout=120)
    t_ns, attitude = CommandEstimator(str(program))(run)
    assert np.array_equal(t_ns, run.imu.t_ns)
    truth = run.attitude().at(t_ns)
    assert attitude_error(attitude, truth).total.max() < 1e-9


def test_a_line_of_names_is_no_attitude_and_answers_may_be_fewer(run, tmp_path):
    t_ns, attitude = python(tmp_path, "print('t_ns, x, y, z, w')\nprint('7,0,0,0,1')")(run)
    assert (t_ns.tolist(), attitude.tolist()) == ([7], [AT_REST])


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("", ["prints no attitude"]),
        ("sys.stderr.write('no calib.yaml')", ["prints no attitude", "no calib.yaml"]),
        ("print('1,0,0,0,1')\nprint('2,0,0,zero,1')", ["line 2", "zero"]),
        ("print('1,0,0,1')", ["line 1"]),
        ("print('1.5,0,0,0,1')", ["line 1", "1.5"]),
        ("print('1,0,0,0,1')\nprint('2,0,0,0,1_0')", ["line 2", "1_0"]),
        ("print('2_0,0,0,0,1')", ["line 1", "2_0"]),
        ("print(chr(0x661) + ',0,0,0,1')", ["line 1"]),
        ("print('1,0,0,0,' + chr(0x661))", ["line 1"]),
        ("print('99999999999999999999,0,0,0,1')", ["line 1", "9999"]),
        ("print('1,0,0,0,1')\nprint('2,nan,0,0,1')", ["line 2", "2,nan"]),
        ("print('1,0,0,0,0')", ["line 1", "1,0,0,0,0"]),
        ("print('1,1e400,0,0,0')", ["line 1", "1e400"]),
        ("sys.exit('the gain is missing')", ["status 1", "the gain is missing"]),
        ("os.abort()", ["status -6"]),
        ("sys.stderr.write('no calib.yaml')\nprint('hello')", ["line 1", "hello", ": no calib.yaml"]),
        ("sys.stderr.write(300 * 'a' + ' end')\nsys.exit(3)", ["status 3", ": …aaa", "aaa end"]),
        ("sys.stdout.buffer.write(bytes([255, 254, 10]))", ["line 1"]),
    ],
)
def test_what_a_program_does_wrong_is_told_in_one_line(run, tmp_path, source, told):
    with pytest.raises(InputError) as error:
        python(tmp_path, source)(run)
    line = str(error.value)
    assert "\n" not in line
    for part in told:
        assert part in line


@pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="no files in memory on this system")
def test_a_full_disk_is_no_fault_of_the_program(run, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "there is none"))
    t_ns, _ = python(tmp_path, "print('7,0,0,0,1')")(run)
    assert t_ns.tolist() == [7]


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_program_that_prints_without_end_is_ended(run, tmp_path, stream):
    lines = 1 + len({*run.imu.t_ns.tolist(), *run.magnetometer.t_ns.tolist()})
    with pytest.raises(InputError, match=str(2**20 + 256 * lines)):
        python(tmp_path, f"while True:\n    sys.{stream}.write(4096 * '1')")(run)


@pytest.mark.slow
def test_a_program_that_hangs_is_ended_with_what_it_started(run, tmp_path):
    child = "import subprocess\nchild = subprocess.Popen(['sleep', '600'])\n"
    hanging = python(tmp_path, f"{child}open(sys.argv[0] + '.pid', 'w').write(str(child.pid))\nchild.wait()", 2.0)
    with pytest.raises(InputError, match="within 2 s"):
        hanging(run)
    process = Path("/proc", (tmp_path / "a filter.py.pid").read_text(), "stat")
    with suppress(FileNotFoundError, ProcessLookupError):  # it is no more
        while process.read_text().split()[2] != "Z":
            time.sleep(0.01)


@pytest.mark.parametrize(
    "command",
    [b"true", 5, None, "", "/no/such/program", "true \0", "true \ud800", "\ud800", 5000 * "a", "/" + 5000 * "a"],
)
def test_what_is_no_program_is_refused(run, command):
    with pytest.raises(InputError):
        CommandEstimator(command)(run)


@pytest.mark.parametrize("timeout", ["60", None, True, math.nan, 0.0, -1.0, math.inf, 1e7])
@pytest.mark.parametrize("make", [command_estimator, node_estimator])
def test_what_is_no_time_is_refused(make, timeout):
    with pytest.raises(InputError):
        make("cat", timeout)


def test_what_cannot_be_started_is_told_by_its_kind(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a_file").touch()
    Path("a_folder").mkdir()
    Path("a_program").touch(mode=0o755)
    kinds = {"a_folder": "a folder", "./a_folder": "a folder", "./a_file": "not executable", "a_program": "not on PATH"}
    for command, fault in kinds.items():
        with pytest.raises(InputError, match=fault):
            CommandEstimator(command)(run)


@pytest.mark.parametrize("make", [command_estimator, node_estimator])
def test_what_is_no_run_is_refused(make):
    with pytest.raises(InputError):
        make("cat")(None)


STILL = """awk -F, 'NR > 1 && $2 {print $1 ",0,0,0,1"}'"""
"""A program that starts at once, as it is started hundreds of times."""
WITH_AWK = pytest.mark.skipif(shutil.which("awk") is None, reason="awk is not installed")


@WITH_AWK
@pytest.mark.slow
def test_a_program_is_ranked_as_a_function_is(capsys):
    assert league.main(["--command", STILL, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert row["filter"] == STILL
    assert all(not result["failure"] for result in row["results"].values())


@pytest.mark.slow
@WITH_AWK
def test_a_program_is_played_and_diagnosed_as_a_function_is(capsys, monkeypatch):
    monkeypatch.setattr(playing, "CASES", CASES[:2])
    row = playing.play("still", command_estimator(STILL), workers=2, timeout_s=60.0, progress=lambda: None)
    assert [result.failure for result in row.results.values()] == ["", ""]
    found = diagnose(command_estimator(STILL), max_runs=1, workers=2, imu_rate=25.0, magnetometer_rate=25.0)
    assert not found.passed
    assert [probe.passed for probe in found.probes if probe.code == "follows"] == [False]
    for main in (league.main, verb.main):
        assert main(["a:b", "--command", STILL]) == 2
    assert verb.main(["--command", "/no/such/program"]) == 2
    assert verb.main([]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 4


def test_place_of_an_error_is_a_line_of_the_user_or_none():
    def failed(function, *arguments):
        try:
            function(*arguments)
        except Exception as error:
            return told(error)

    assert f" {Path(__file__).name} line " in failed(_raise, "of the package")
    assert f" {Path(__file__).name} line " in failed(Estimate, "nothing")
    assert told(FilterError("of the package")) == "of the package"
    with pytest.raises(ValueError) as caught:
        shlex.split('"')
    assert ".py" not in told(caught.value.with_traceback(caught.tb.tb_next))


def test_place_of_an_error_in_an_installed_filter_is_its_first_line(tmp_path, monkeypatch):
    folder = tmp_path / "site-packages"
    folder.mkdir()
    (folder / "installed_filter.py").write_text("import json\n\ndef estimate(run):\n    return json.loads(run)\n")
    monkeypatch.syspath_prepend(folder)
    estimate = importlib.import_module("installed_filter").estimate
    with pytest.raises(ValueError) as caught:
        estimate("no JSON")
    assert " installed_filter.py line 4" in told(caught.value.with_traceback(caught.tb.tb_next))


def _raise(words):
    raise InputError(words)
