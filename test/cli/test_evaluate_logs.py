"""``evaluate`` of trajectories, as users of evo call it, and of an estimator on a log."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from evaluating import refused, scored

from lie_rigid_body import Run, inspect, simulate
from lie_rigid_body.estimates.programs import lines_of
from lie_rigid_body.lie import quaternion

FILTER = """
import numpy as np
from lie_rigid_body.lie import quaternion

def estimate(run):
    t_ns = run.imu.t_ns
    attitude = [np.array([0.0, 0.0, 0.0, 1.0])]
    for before, now, rate in zip(t_ns, t_ns[1:], run.imu.gyro[1:]):
        attitude.append(quaternion.multiply(attitude[-1], quaternion.exp(rate * (now - before) / 1e9)))
    assert run.truth is None
    return np.array(attitude)
"""
PROGRAM = """
import sys
import numpy as np
from types import SimpleNamespace
from own_filter import estimate

rows = [line.split(",") for line in sys.stdin.read().splitlines()[1:]]
rows = [row for row in rows if row[1]]
imu = SimpleNamespace(t_ns=[int(row[0]) for row in rows], gyro=np.array([row[1:4] for row in rows], dtype=float))
for stamp, attitude in zip(imu.t_ns, estimate(SimpleNamespace(imu=imu, truth=None))):
    print(stamp, *attitude.tolist(), sep=",")
"""


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate("hand", duration=10.0, sensor_grade="mems")


@pytest.fixture(scope="module")
def folder(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log, the truth, two estimates in files, a bag, a filter and a program."""
    folder = tmp_path_factory.mktemp("logs")
    folder.joinpath("hand.csv").write_text("\n".join([*lines_of(run), ""]))
    run.to_bag(folder / "own.mcap")
    turned = quaternion.multiply(run.truth.attitude_xyzw, quaternion.exp(np.array([0.0, 0.0, 0.02])))
    for name, attitude in (("truth", run.truth.attitude_xyzw), ("a", turned), ("b", turned[::-1])):
        poses = np.column_stack([run.t_ns / 1e9, np.zeros((len(run.t_ns), 3)), attitude])
        np.savetxt(folder / f"{name}.tum", poses, fmt="%.12f")
    folder.joinpath("own_filter.py").write_text(FILTER)
    folder.joinpath("own_program.py").write_text(PROGRAM)
    return folder


@pytest.fixture
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)
    return folder


def test_a_trajectory_is_scored_beside_another_and_beside_a_bag(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    beside_bag = scored(capsys, "own.mcap", "--estimate", "a.tum")
    assert beside_bag["total_deg"]["rms"] == pytest.approx(np.degrees(0.02), rel=1e-6)
    assert beside_bag["findings"] == []
    assert "no file" in refused(capsys, "truth.tum", "--estimate", "/pose")
    found = scored(capsys, "truth.tum", "--estimate", "a.tum", "--estimate", "b.tum")["estimates"]
    assert found[0]["total_deg"]["rms"] == pytest.approx(np.degrees(0.02), rel=1e-6)
    assert found[1]["total_deg"]["rms"] > 10.0


def test_an_estimator_is_scored_on_a_log_with_a_truth(
    run: Run, here: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "scored.mcap"
    by_function = scored(capsys, "hand.csv", "own_filter:estimate", "--truth", "truth.tum", "--out", out)
    program = shlex.join([sys.executable, "own_program.py"])
    by_program = scored(capsys, "hand.csv", "--command", program, "--truth", "truth.tum")
    assert by_program["total_deg"] == by_function["total_deg"]
    again = scored(capsys, out, "--estimate", "/own_filter_estimate")
    assert again["total_deg"]["rms"] == pytest.approx(by_function["total_deg"]["rms"], rel=1e-12)
    assert inspect(out).passed
    assert np.array_equal(Run.from_log(out).imu.gyro, run.imu.gyro)


@pytest.mark.slow
def test_an_estimator_on_a_bag_with_a_scenario_has_a_bound(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert scored(capsys, "own.mcap", "own_filter:estimate")["cramer_rao_bound"] is not None


def test_without_a_truth_the_estimates_are_kept_with_status_2(
    run: Run, here: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "kept.mcap"
    assert "--truth" in refused(capsys, "hand.csv", "own_filter:estimate", "--out", out)
    kept = scored(capsys, out, "--estimate", "/own_filter_estimate", "--truth", "truth.tum")
    assert kept["samples"] == len(run.imu.t_ns)


@pytest.mark.parametrize(
    "arguments",
    [
        "hand.csv",
        "hand.csv own_filter:estimate --estimate a.tum",
        "hand.csv own_filter:estimate --command x",
        "own.mcap --estimate a.tum --columns t=1",
        "hand.csv own_filter:nothing",
        "hand.csv own_filter:estimate --topic pose:=/x",
    ],
)
def test_what_does_not_go_together_is_one_line(arguments: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    from lie_rigid_body.__main__ import main

    assert main(["evaluate", *arguments.split()]) == 2
    assert capsys.readouterr().err.count("\n") == 1
