"""``inspect`` of a log: its text, JSON, page, parameter file and repaired readings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.cli.inspect import main
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.estimates.programs import lines_of
from lie_rigid_body.scenario.parameter_file import read_parameter_file

KICKS = [20.0, 0.5, 1.0, -0.7, 30.0, -1.0, 0.8, 0.6, 40.0, 0.3, -0.9, 1.2, 50.0, 0.7, 0.3, -1.0]
IRON = [20e-6, -15e-6, 10e-6]


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(
        duration=60.0,
        initial_body_rate=[0.0, 0.0, 0.0],
        kicks=KICKS,
        imu_rate=100.0,
        gyro_rate="integrated",
        magnetometer_rate=25.0,
        sensor_grade="mems",
        magnetometer_hard_iron=IRON,
        translation="carried",
        sway_acceleration=[0.5, 0.5, 0.5],
    )


@pytest.fixture(scope="module")
def logs(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a healthy log, the same with the gyro in degrees, and the truth 0.1 s late."""
    folder = tmp_path_factory.mktemp("logs")
    header, *rows = lines_of(run)
    folder.joinpath("healthy.csv").write_text("\n".join([header, *rows, ""]))
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[1:4] = [rate and repr(float(np.degrees(float(rate)))) for rate in row[1:4]]
    wrong = [",".join(row) for row in cells]
    folder.joinpath("degrees.csv").write_text("\n".join([header, *wrong, ""]))
    truth = np.column_stack([run.t_ns / 1e9 + 0.1, np.zeros((len(run.t_ns), 3)), run.truth.attitude_xyzw])
    np.savetxt(folder / "truth.tum", truth, fmt="%.9f")
    return folder


def test_a_healthy_log_passes_and_says_what_was_taken_for_what(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(logs / "healthy.csv")]) == 0
    first, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("The gyro is gyro_x")


def test_a_mistake_has_status_1_and_is_undone_in_the_repaired_log(
    run: Run, logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fixed = tmp_path / "fixed.csv"
    assert main([str(logs / "degrees.csv"), "--json", "--out", str(fixed)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [mistake["code"] for mistake in found["mistakes"]] == ["gyro_units"]
    again = Run.from_log(fixed)
    assert np.allclose(again.imu.gyro, run.imu.gyro, rtol=1e-12)
    assert np.array_equal(again.imu.t_ns, run.imu.t_ns)
    assert main([str(fixed)]) == 0


def test_the_parameter_file_is_one_and_has_what_the_log_shows(logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine.yaml"
    assert main([str(logs / "degrees.csv"), "--parameters", str(out)]) == 1
    given = read_parameter_file(out)
    assert given["imu_rate"] == 100.0
    assert given["gyro_resolution"] == pytest.approx(np.radians(1.0) / 16.384, rel=1e-9)
    assert given["magnetometer_hard_iron"] == pytest.approx(IRON, abs=2e-6)
    assert "gyro_range" not in given
    assert record([str(tmp_path / "like.mcap"), "--duration", "1", "--params-file", str(out), "--quiet"]) == 0
    assert main([str(logs / "degrees.csv"), "--parameters", str(out)]) == 2


@pytest.mark.slow
def test_a_late_truth_is_named(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(logs / "healthy.csv"), "--truth", str(logs / "truth.tum"), "--json"]) == 1
    (mistake,) = json.loads(capsys.readouterr().out)["mistakes"]
    assert mistake["code"] == "truth_late"
    assert float(mistake["repair"].split()[0]) == pytest.approx(-0.1, abs=0.01)


@pytest.mark.slow
def test_the_page_has_pictures(logs: Path, tmp_path: Path) -> None:
    assert main([str(logs / "degrees.csv"), "--report", str(tmp_path / "page.html")]) == 1
    page = (tmp_path / "page.html").read_text()
    assert (
        page.count("<svg") == 3 + 3 + 3
    )  # readings and Allan deviations of three sensors, and fields on pairs of axes
    assert "gyro_units" in page


def test_columns_are_named_by_an_option(logs: Path, tmp_path: Path) -> None:
    readings = np.loadtxt(logs / "healthy.csv", delimiter=",", skiprows=1, usecols=range(7))
    np.savetxt(tmp_path / "bare.csv", readings, delimiter=",", fmt="%.17g")
    fields = ["t", *(f"{sensor}_{axis}" for sensor in ("gyro", "accelerometer") for axis in "xyz")]
    columns = ",".join(f"{field}={number}{':ns' * (number == 1)}" for number, field in enumerate(fields, 1))
    assert main([str(tmp_path / "bare.csv"), "--columns", columns]) == 0
    assert main([str(tmp_path / "bare.csv"), "--columns", "t"]) == 2
