"""The one executable, and the table of contents of the package."""

from __future__ import annotations

import sys
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import pytest

import lie_rigid_body
from lie_rigid_body.__main__ import EXTRAS, VERBS, main
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.scenario import parameter_file
from lie_rigid_body.scenario.parameter_file import scenario_files


def test_help_names_every_verb(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    assert [verb for verb in VERBS if verb not in said] == []


def test_version_and_extras(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["--version"]) == 0
    first, _, *extras = capsys.readouterr().out.splitlines()
    assert first == f"lie-rigid-body {lie_rigid_body.__version__}"
    told = {line.split()[0]: line for line in extras}
    declared = {*metadata.metadata("lie_rigid_body").get_all("Provides-Extra", [])}
    assert {*told} == {*EXTRAS} == declared - {"bench", "docs", "league", "lint", "test"}
    assert told["cluster"].endswith(" pip install 'lie-rigid-body[cluster]'")
    for name, modules in EXTRAS.items():
        there = all(find_spec(module) for module in modules)
        assert ("pip install" not in told[name]) == there


@pytest.mark.parametrize("argv", [[], ["fly"], ["--fly"], ["", "record"]])
def test_no_verb_or_an_unknown_one_is_one_line_that_names_them(argv, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(argv) == 2
    said = capsys.readouterr()
    assert (said.out, len(said.err.splitlines())) == ("", 1)
    assert len(said.err) <= 200
    wanted = [repr(argv[0])] if argv else VERBS
    assert [verb for verb in wanted if verb not in said.err] == []


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_explains_itself(verb: str, capfd: pytest.CaptureFixture[str]) -> None:
    if verb == "sim" and find_spec("rclpy") is None:
        pytest.skip("rclpy is not installed")
    assert main([verb, "--help"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert verb in out


def test_sim_without_ros_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    if "lie_rigid_body.ros" in sys.modules:  # the module that is imported meanwhile is not that of other tests
        monkeypatch.setattr(lie_rigid_body, "ros", sys.modules["lie_rigid_body.ros"])
    for name in [name for name in sys.modules if name.startswith("lie_rigid_body.ros")]:
        monkeypatch.delitem(sys.modules, name)
    assert main(["sim"]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert "rclpy" in said


def test_public_names_are_there() -> None:
    names = {name: getattr(lie_rigid_body, name) for name in lie_rigid_body.__all__}
    assert [name for name, value in names.items() if name != "__version__" and value.__name__ != name] == []
    assert set(dir(lie_rigid_body)) >= set(names)
    assert not hasattr(lie_rigid_body, "Bicycle")


def test_scenarios_in_a_zip_file_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "packages.zip").touch()
    monkeypatch.setattr(parameter_file, "CONFIG", tmp_path / "packages.zip" / "lie_rigid_body" / "config")
    with pytest.raises(InputError):
        scenario_files()
