"""Outputs that are inputs: what `words_of_inputs` has is refused, and what else may be one."""

from __future__ import annotations

from pathlib import Path

import pytest
from words_of_inputs import prepare

from lie_rigid_body.__main__ import main


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path)
    return tmp_path


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


@pytest.mark.usefixtures("asked_here")
def test_a_page_in_a_folder_of_bags_is_none_of_its_inputs(folder: Path) -> None:
    for name in ("named", "metadata.yaml"):
        (folder / "bags" / "run" / name).unlink()
    for _ in range(2):
        assert main(["check", "bags/run", "--report", "bags/run/page.html", "--force"]) == 0
