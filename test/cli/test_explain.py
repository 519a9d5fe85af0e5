"""``explain``: its JSON, and the shape of its text; what it says is in `words_of_verbs`."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

from lie_rigid_body.cli.explain import main
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files

SEPARATRIX = ["-p", "inertia:=[3.0, 4.0, 6.0]", "-p", "initial_body_rate:=[-2.0, 3.0, 1.0]"]


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


@pytest.mark.parametrize("name", scenario_files())
def test_every_scenario_is_explained(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = text(capsys, ["--scenario", name])
    assert said.startswith(f"{name}: ")
    assert len([line for line in said.splitlines()[2:] if line[:1].strip()]) == 4  # headings
    # the first lines quote the scenario's own words and numbers
    assert max(map(len, said.splitlines()[2:])) <= 110
    assert not {"nan", "inf", "None"} & set(said.replace(",", " ").split())
    content = facts(capsys, ["--scenario", name])
    Scenario.from_parameters(content["parameters"])
    assert len(content["axes"]) == 3


def test_the_flips_of_the_wing_nut(capsys: pytest.CaptureFixture[str]) -> None:
    content = facts(capsys, ["--scenario", "dzhanibekov"])
    assert content["regime"] == "about_largest"
    assert content["circulation"]["period_s"] == pytest.approx(39.105734, rel=1e-7)
    assert content["circulation"]["flips"]["sudden"] is True
    assert content["axes"][1]["spin"]["verdict"] == "unstable"
    assert [entry["unit"] for entry in content["conserved"]] == ["J", "kg m²/s"]


def test_the_symmetric_top_conserves_one_momentum_more(capsys: pytest.CaptureFixture[str]) -> None:
    content = facts(capsys, ["--scenario", "symmetric_top"])
    assert content["symmetric_top"]["body_precession_rate_rad_s"] == pytest.approx(1.6)
    assert content["conserved"][-1]["values"] == [3.6]
    assert content["conserved_body_momenta"] == [{"direction": [0.0, 0.0, 1.0], "momentum_kg_m2_s": 3.6}]
    assert content["circulation"]["flips"] is None


def test_the_sphere_conserves_all(capsys: pytest.CaptureFixture[str]) -> None:
    conserved = facts(capsys, ["--scenario", "spherical_top"])["conserved"]
    assert conserved[-1]["values"] == pytest.approx([0.3, -0.8, 1.1])


def test_numbers_without_end_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    content = facts(capsys, SEPARATRIX)
    assert content["regime"] == "separatrix"
    assert content["circulation"]["period_s"] is None
    assert content["circulation"]["flips"]["interval_s"] is None
    assert content["circulation"]["flips"]["first_s"] == pytest.approx(0.935881, rel=1e-6)
