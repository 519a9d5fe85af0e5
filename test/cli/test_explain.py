"""``explain``: the text, the JSON, and one clear line for what cannot be explained."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.cli.explain import main
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files

SEPARATRIX = ["-p", "inertia:=[3.0, 4.0, 6.0]", "-p", "initial_body_rate:=[-2.0, 3.0, 1.0]"]
LAST_FLIP_GONE = [*SEPARATRIX, "-p", "initial_body_rate:=[2.0, 3.0, 1.0]"]
REST = ["-p", "initial_body_rate:=[0.0, 0.0, 0.0]"]
STEADY = ["-p", "initial_body_rate:=[0.0, 1.0, 0.0]"]
EQUATORIAL = ["--scenario", "symmetric_top", "-p", "initial_body_rate:=[1.0, 0.0, 0.0]"]
HUGE = ["-p", "initial_body_rate:=[1.0e150, 1.0, 1.0e150]", "-p", "motion:=closed_form"]
TINY = ["-p", "inertia:=[1.0e-30, 1.0e-30, 1.5e-30]", "-p", "initial_body_rate:=[1.0e-300, 0.0, 1.0e-300]"]
UNUSUAL = [SEPARATRIX, LAST_FLIP_GONE, REST, STEADY, EQUATORIAL, HUGE, TINY]


@pytest.fixture(autouse=True)
def as_installed_with_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])


def text(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> str:
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def facts(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    content = json.loads(text(capsys, [*arguments, "--json"]), parse_constant=refuse)
    assert isinstance(content, dict)
    return content


def test_the_errors_of_sensors_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    given = ["-p", "imu_rate:=100.0", "-p", "sensor_grade:=mems", "-p", "gyro_turn_on_bias:=0.125"]
    shown = text(capsys, given)
    assert "Sensors, of the grade mems" in shown
    assert "gyro_turn_on_bias             0.125\n" in shown
    assert "accelerometer_misalignment    [0.005, -0.005, 0.005]\n" in shown
    assert "magnetometer" not in shown
    assert "Sensors" not in text(capsys, [])
    assert facts(capsys, given)["parameters"]["sensor_grade"] == "mems"


def test_faults_are_shown_of_sensors_that_are_on(capsys: pytest.CaptureFixture[str]) -> None:
    given = ["-p", "magnetometer_rate:=10.0", "-p", "imu_latency:=0.1", "-p", "magnetometer_stuck_interval:=5.0"]
    shown = text(capsys, given)
    assert re.search(r"magnetometer_stuck_interval +5\n", shown)
    assert "imu_latency" not in shown
    assert re.search(r"imu_orientation +true\n", text(capsys, ["-p", "imu_rate:=9.0", "-p", "imu_orientation:=true"]))


@pytest.mark.parametrize("name", scenario_files())
def test_every_scenario_is_explained(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = text(capsys, ["--scenario", name])
    assert said.startswith(f"{name}: ")
    for heading in ("Body, ", "Motion", "Spinning ", "Conserved"):
        assert sum(line.startswith(heading) for line in said.splitlines()) == 1
    # the first lines quote the scenario's own words and numbers
    assert max(map(len, said.splitlines()[2:])) <= 110
    assert not {"nan", "inf", "None"} & set(said.replace(",", " ").split())
    content = facts(capsys, ["--scenario", name])
    Scenario.from_parameters(content["parameters"])
    assert len(content["axes"]) == 3


def test_the_flips_of_the_wing_nut(capsys: pytest.CaptureFixture[str]) -> None:
    said = text(capsys, ["--scenario", "dzhanibekov"])
    assert "asymmetric top" in said
    assert "It is flat" in said
    assert "every 19.5529 s, the first 10.9169 s after the start" in said
    assert "grows as exp(0.577422 t)" in said
    content = facts(capsys, ["--scenario", "dzhanibekov"])
    assert content["regime"] == "about_largest"
    assert content["circulation"]["period_s"] == pytest.approx(39.105734, rel=1e-7)
    assert content["circulation"]["flips"]["sudden"] is True
    assert content["axes"][1]["spin"]["verdict"] == "unstable"
    assert [entry["unit"] for entry in content["conserved"]] == ["J", "kg m²/s"]


def test_the_symmetric_top_conserves_one_momentum_more(capsys: pytest.CaptureFixture[str]) -> None:
    said = text(capsys, ["--scenario", "symmetric_top"])
    assert "angular momentum in the body along [0, 0, 1]: 3.6 kg m²/s" in said
    assert "no nutation" in said
    content = facts(capsys, ["--scenario", "symmetric_top"])
    assert content["symmetric_top"]["body_precession_rate_rad_s"] == pytest.approx(1.6)
    assert content["conserved_body_momenta"] == [{"direction": [0.0, 0.0, 1.0], "momentum_kg_m2_s": 3.6}]
    assert content["circulation"]["flips"] is None


def test_the_sphere_conserves_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert "angular momentum in the body, all components: [0.3, -0.8, 1.1]" in text(
        capsys, ["--scenario", "spherical_top"]
    )


def test_numbers_without_end_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    content = facts(capsys, SEPARATRIX)
    assert content["regime"] == "separatrix"
    assert content["circulation"]["period_s"] is None
    assert content["circulation"]["flips"]["interval_s"] is None
    assert content["circulation"]["flips"]["first_s"] == pytest.approx(0.935881, rel=1e-6)


@pytest.mark.parametrize("arguments", UNUSUAL)
def test_unusual_motions_are_explained(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert "Conserved" in text(capsys, arguments)
    assert all(axis["spin"]["spin_rate_rad_s"] > 0.0 for axis in facts(capsys, arguments)["axes"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (SEPARATRIX, "one, 0.935881 s after the start"),
        (LAST_FLIP_GONE, "none any more"),
        (REST, "The body is at rest"),
        (STEADY, "A steady rotation about axis 2 (intermediate). It is unstable"),
        (EQUATORIAL, "A steady rotation about [1, 0, 0] in the body. It is neutral"),
        (["--scenario", "asymmetric_top"], "not suddenly"),
        (["--scenario", "tossed_phone"], "circle axis 1 (smallest), on a closed curve"),
        (["--scenario", "tumbling_cubesat"], "circle axis 3 (largest), on a closed curve"),
        (["--scenario", "prolate_top"], "circle axis 1 (axis of symmetry), on a circle"),
    ],
)
def test_each_regime_has_its_words(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in " ".join(text(capsys, arguments).split())


def test_a_changed_scenario_loses_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    changed = text(capsys, ["--scenario", "dzhanibekov", "-p", "initial_body_rate:=[1.0, 0.0, 0.1]"])
    assert changed.startswith("inertia [1, 2, 3] kg m², initial body rate [1, 0, 0.1] rad/s\n")


def test_a_parameter_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "own.yaml"
    file.write_text("/**:\n  ros__parameters:\n    inertia: [2.0, 3.0, 4.0]\n")
    assert facts(capsys, ["--params-file", str(file)])["axes"][0]["moment_kg_m2"] == 2.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--scenario", "dzanibekov"], "did you mean dzhanibekov or "),
        (["-p", "inertia:=[1.0, 1.0, 3.0]"], "triangle inequality"),
        (["-p", "inertia:=[1.0, 2.0]"], "give 3 or 6 finite numbers"),
        (["-p", "intertia:=[1.0, 2.0, 3.0]"], "did you mean inertia?"),
        (["--params-file", "absent.yaml"], "does not exist"),
        (["dzhanibekov"], "unrecognized arguments"),
    ],
)
def test_bad_input_is_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("lie-rigid-body explain: error: ")
    assert words in err


def test_as_a_process() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "lie_rigid_body", "explain"], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stderr) == (0, "")
