"""``scenarios``, and each of them recorded."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body.cli import record, scenarios
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files
from lie_rigid_body.simulation import Segment


@pytest.fixture(autouse=True)
def as_installed_with_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])


def test_each_is_listed_with_what_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert scenarios.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0::3] == list(scenario_files())
    assert all(line.startswith("    ") and line.endswith(".") for line in lines[1::3])


def test_programs_get_every_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    assert scenarios.main(["--json"]) == 0
    entries = json.loads(capsys.readouterr().out)
    assert [entry.pop("name") for entry in entries] == list(scenario_files())
    assert all(entry.pop("description") for entry in entries)
    for entry in entries:
        assert Path(entry.pop("file")).is_file()
        Scenario.from_parameters(entry)


def test_it_is_called_otherwise_where_ros_installed_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["/opt/ws/lib/lie_rigid_body/scenarios"])
    assert scenarios.main(["all"]) == 2
    assert capsys.readouterr().err.startswith("ros2 run lie_rigid_body scenarios: error: ")


@pytest.mark.parametrize("name", scenario_files())
def test_each_records_the_exact_motion(name: str, tmp_path: Path) -> None:
    out = tmp_path / "out.mcap"
    # the same exact motion, integrated where the file itself asks for the closed form
    integrated = ["-p", "motion:=moving_chart"] if name == "slow_dzhanibekov" else []
    assert record.main([str(out), "--scenario", name, "--duration", "20", "--quiet", *integrated]) == 0
    recording = read_bag(out)
    scenario = Segment.from_json(recording.scenario_texts[0][1]).scenario
    exact = ClosedForm(scenario.body(), scenario.start()).at(recording.poses.stamps_ns)
    error = 2.0 * np.linalg.norm(recording.poses.values[:, 3:] - exact.attitude_xyzw, axis=1)
    assert scenario.motion == "moving_chart"
    assert error.max() < 2e-9  # rad; a minute then stays far below the 1e-7 of a certificate
    assert np.abs(recording.twists.values[:, 3:] - exact.body_rate).max() < 1e-8 * np.abs(exact.body_rate).max()
