"""``scenarios`` and ``explain``: lists, JSON, shapes of texts; `words_of_verbs` has words."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.cli import scenarios
from lie_rigid_body.cli.explain import main
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files


@pytest.fixture(autouse=True)
def as_installed_with_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])


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


KICKS = ["-p", "kicks:=[1.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 4.0, 0.3, 1.0, 0.2]"]


def test_arcs_kicks_and_sway_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    """The sway against its harmonics, added up over a thousand periods of the slowest."""
    plain = facts(capsys, ["--scenario", "dzhanibekov"])
    assert [arc["regime"] for arc in plain["arcs"]] == [plain["regime"]]
    assert (plain["kicks"], plain["sway"]) == ({"count": 0, "rests": 0, "period_s": None}, None)
    once = facts(capsys, KICKS)
    assert [(arc["begin_s"], arc["regime"]) for arc in once["arcs"]] == [
        *((0.0, "about_largest"), (1.5, "rest"), (2.0, "steady"), (4.0, "about_largest"))
    ]
    assert once["kicks"] == {"count": 3, "rests": 1, "period_s": None}
    again = facts(capsys, [*KICKS, "-p", "kick_period:=5.0"])
    assert [arc["begin_s"] for arc in again["arcs"]] == [0.0, 1.5, 2.0, 4.0, 6.5, 7.0, 9.0, 11.5, 12.0, 14.0]
    assert [arc["regime"] for arc in again["arcs"][4:7]] == [arc["regime"] for arc in again["arcs"][1:4]]
    carried = ["-p", "translation:=carried", "-p", "sway_acceleration:=[1.0, 0.0, 2.0]", "-p", "sway_band:=[0.5, 1.0]"]
    told = facts(capsys, carried)
    centre = Scenario(**told["parameters"]).mass_centre().at(np.arange(400_000) * 5_000_000)
    for name, values in (("speed_m_s", centre.velocity), ("displacement_m", centre.position)):
        values = values - values.mean(axis=0)
        assert np.std(values, axis=0) == pytest.approx(told["sway"][f"{name}_rms"], rel=0.02)
        assert 1.0 < told["sway"][f"{name}_at_most"] / np.linalg.norm(values, axis=1).max() < 2.5


KNOTS = [number for k in range(5) for number in (0.1 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)]
ON_A_PATH = ["-p", "motion:=path", "-p", f"path_knots:={KNOTS}", "-p", "imu_rate:=10.0"]


def test_a_carried_body_without_gravity_and_what_has_no_effect_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    for mode, is_told in (("pivot_gravity", False), ("free_fall", True)):
        assert main([*ON_A_PATH, "-p", f"accelerometer_mode:={mode}", "-p", "sway_seed:=3"]) == 0
        told = capsys.readouterr().out
        assert ("gravity  " in told) == is_told
        assert "sway_seed has no effect" in told


SEPARATRIX = ["-p", "inertia:=[3.0, 4.0, 6.0]", "-p", "initial_body_rate:=[-2.0, 3.0, 1.0]"]


def facts(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    assert main([*arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    content: dict[str, Any] = json.loads(out, parse_constant=refuse)
    return content


@pytest.mark.parametrize("name", scenario_files())
def test_every_scenario_is_explained(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In numbers; `words_of_verbs` has the text."""
    content = facts(capsys, ["--scenario", name])
    Scenario.from_parameters(content["parameters"])
    assert len(content["axes"]) == 3


def test_numbers_without_end_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    content = facts(capsys, SEPARATRIX)
    assert content["regime"] == "separatrix"
    assert content["circulation"]["period_s"] is None
    assert content["circulation"]["flips"]["interval_s"] is None
    assert content["circulation"]["flips"]["first_s"] == pytest.approx(0.935881, rel=1e-6)
