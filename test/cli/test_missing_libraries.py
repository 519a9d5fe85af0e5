"""A library that is not installed is told in one line, with what to install; what does not need it works without."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from lie_rigid_body.system import console

WITHOUT = """
import sys
library, *arguments = sys.argv[1:]
sys.modules[library] = None  # what Python itself writes there for a module that is not to be found
from lie_rigid_body.__main__ import main
for line in arguments:
    print(main(line.split()), flush=True)
    print(file=sys.stderr, flush=True)
"""


def run_without(library: str, folder: Path, *lines: str) -> list[tuple[int, list[str]]]:
    """Exit status and complaint of each command line, in one process without a library."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, library, *lines], cwd=folder, capture_output=True, text=True, check=True
    )
    statuses = [int(line) for line in done.stdout.splitlines() if line.isdigit()]
    complaints = [part.splitlines() for part in done.stderr.split("\n\n")]
    return list(zip(statuses, complaints, strict=False))


@pytest.mark.parametrize("library", ["mcap", "zstandard"])
def test_bags_want_one_line_of_installation(library: str, tmp_path: Path) -> None:
    (tmp_path / "bag.mcap").write_bytes(b"\x89MCAP0\r\n")
    verbs = [
        "record new.mcap --duration 1",
        "check bag.mcap",
        "plot bag.mcap -o bag.png",
        "evaluate bag.mcap --estimate e",
    ]
    for verb, (status, complaint) in zip(verbs, run_without(library, tmp_path, *verbs), strict=True):
        assert status == 2
        [line] = complaint
        assert line.startswith(f"lie-rigid-body {verb.split()[0]}: error: ")
        assert line.endswith(f": pip install {library}")
    assert [path.name for path in tmp_path.iterdir()] == ["bag.mcap"]


def test_verbs_without_bags_need_no_mcap(tmp_path: Path) -> None:
    assert run_without("mcap", tmp_path, "scenarios", "explain --scenario dzhanibekov") == [(0, []), (0, [])]


def test_a_module_of_ours_that_is_missing_is_no_installation(capsys: pytest.CaptureFixture[str]) -> None:
    def broken() -> int:
        raise ModuleNotFoundError("No module", name="lie_rigid_body.nowhere")

    assert console.status_of("lie-rigid-body", broken) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "pip" not in line


def test_the_name_for_pip_may_differ() -> None:
    assert console.missing_library(ModuleNotFoundError(name="yaml.nodes")).endswith(": pip install PyYAML")
