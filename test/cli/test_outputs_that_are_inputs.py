"""An output that is an input itself is refused before any work, by whichever name, with ``--force`` too."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from lie_rigid_body.__main__ import main
from lie_rigid_body.scenario import parameter_file

LINKS = {"s.html": "bag.mcap", "s.png": "bag.mcap", "run.png": "bags/run/run_0.mcap", "named.html": "bags/run/named"}
"""Symbolic links."""
COMMANDS = (
    "check bag.html --report bag.html",
    "check bag.mcap --report s.html",
    "check other.mcap bag.mcap --report bag.html",
    "check bags/run --report named.html",
    "check bags --report named.html",
    "plot bag.png -o bag.png",
    "plot bags/run -o run.png",
    "evaluate bag.html --estimate /pose --report bag.html",
    "evaluate bag.mcap --estimate /pose --plot s.png",
    "evaluate other.mcap --estimate /pose --truth bag.mcap --report bag.html",
    "evaluate bag.html --estimate /pose --out bag.mcap",
    "evaluate other.mcap --estimate /pose --truth bag.html --out bag.mcap",
    "record ./given.yaml --params-file given.yaml --duration 1",
    "record link.yaml --params-file other.yaml --params-file given.yaml --duration 1",
    "record link.yaml --scenario given --duration 1",
    "campaign campaign.html --out out --workers 1 --report campaign.html",
    "campaign of_program.yaml --out out --workers 1 --report program.html",
    "league --command ./program.html --report program.html",
    "league --with program.html --report program.html",
    "diagnose --command ./program.html --report program.html",
    "diagnose --node ./program.html --report program.html",
    "recover bag.mcap -o bag.mcap",
    "recover bag.mcap -o s.html",
    "recover bag.mcap -o bag.html",
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where ``bag.html`` and ``bag.png`` are the bag itself, and ``link.yaml`` is the parameter file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(parameter_file, "CONFIG", tmp_path)
    assert main(["record", "bag.mcap", "--duration", "0.1", "--quiet"]) == 0
    shutil.copy("bag.mcap", "other.mcap")
    Path("given.yaml").write_text("/**: {ros__parameters: {rate: 50.0}}")
    shutil.copy("given.yaml", "other.yaml")
    Path("campaign.html").write_text("{runs: 1, seed: 1, duration: 0.1}")
    Path("of_program.yaml").write_text(
        "{runs: 1, seed: 1, duration: 0.1, estimators: {mine: {command: ./program.html}}}"
    )
    Path("program.html").write_text("#!/bin/sh\nexec awk -F, 'NR > 1 {print $1 \",0,0,0,1\"}'\n")
    Path("program.html").chmod(0o755)
    run = Path("bags/run")
    run.mkdir(parents=True)
    for name in ("run_0.mcap", "named"):
        shutil.copy("bag.mcap", run / name)
    (run / "metadata.yaml").write_text("rosbag2_bagfile_information: {relative_file_paths: [run_0.mcap, named]}")
    for name, target in (("bag.html", "bag.mcap"), ("bag.png", "bag.mcap"), ("link.yaml", "given.yaml")):
        os.link(target, name)
    for name, target in LINKS.items():
        Path(name).symlink_to(target)
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("force", [[], ["--force"]])
def test_no_input_is_lost(folder: Path, capfd: pytest.CaptureFixture[str], command: str, force: list[str]) -> None:
    before = contents(folder)
    assert main([*command.split(), *force]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert contents(folder) == before


def test_metadata_of_a_folder_are_an_input_whatever_is_wrong_with_it(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    metadata, page = folder / "bags" / "run" / "metadata.yaml", folder / "page.html"
    metadata.write_text("none")
    for target in (metadata, metadata.with_name("run_0.mcap")):
        page.symlink_to(target)
        assert main(["check", "bags/run", "bag.mcap", "--report", "page.html", "--force"]) == 2
        assert str(target.relative_to(folder)) in capfd.readouterr().err
        page.unlink()


def test_a_picture_and_a_page_are_two_files(folder: Path) -> None:
    (folder / "old.html").write_text("old")
    os.link("old.html", "old.png")
    command = "evaluate bag.mcap --estimate /pose --plot old.png --report old.html --force"
    assert main(command.split()) == 2
    assert (folder / "old.html").read_text() == "old"


@pytest.mark.usefixtures("asked_here")
def test_a_page_in_a_folder_of_bags_is_none_of_its_inputs(folder: Path) -> None:
    for name in ("named", "metadata.yaml"):
        (folder / "bags" / "run" / name).unlink()
    for given, page in (("bags", "bags/page.html"), ("bags/run", "bags/run/page.html")):
        for _ in range(2):
            assert main(["check", given, "--report", page, "--force"]) == 0
