"""What the README and the first pages show works: commands and Python run, and what they print is what they say."""

from __future__ import annotations

import re
import shlex
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from lie_rigid_body.__main__ import main
from lie_rigid_body.scenario.parameter_table import PARAMETERS
from lie_rigid_body.sensors import SENSORS
from reader import ROOT, blocks, commands

README = (ROOT / "README.md").read_text(encoding="utf-8")
NAMES = ("reference/imu.md", "sensors.md", "reference/commands.md", "reference/parameters.md", "reference/python.md")
IMU_PAGE, SENSORS_PAGE, COMMANDS_PAGE, PARAMETERS_PAGE, PYTHON_PAGE = (
    (ROOT / "docs" / name).read_text(encoding="utf-8") for name in NAMES
)
LAUNCH_PAGE = (ROOT / "docs" / "reference" / "launch.md").read_text(encoding="utf-8")


def started(program: str, text: str = README) -> list[list[str]]:
    lines = commands(*blocks(text, "bash", "console"))
    return [shlex.split(line, comments=True) for line in lines if line.startswith(program)]


@pytest.fixture(scope="module")
def worked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[list[str], int, str]]]:
    """A folder in which the headless commands ran in their order, and each with its status and errors."""
    folder, runs = tmp_path_factory.mktemp("readme"), []
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for _, *arguments in started("lie-rigid-body", COMMANDS_PAGE):
            with redirect_stderr(StringIO()) as complained:
                status = main(arguments)
            runs.append((arguments, status, complained.getvalue()))
    return folder, runs


def test_headless_commands_run_in_their_order(worked):
    folder, runs = worked
    assert len(runs) >= 6
    assert [run for run in runs if run[1] != 0] == []
    assert (folder / "flips.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("code", blocks(PYTHON_PAGE, "python"))
def test_python_runs(code, worked, monkeypatch):
    monkeypatch.chdir(worked[0])
    exec(compile(code, "python.md", "exec"), {})


def test_the_first_screen_prints_the_score_that_it_shows():
    [code], [score, _] = blocks(README, "python"), blocks(README, "text")
    with redirect_stdout(StringIO()) as printed:
        exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})
    rows = [line.rsplit(maxsplit=5) for line in printed.getvalue().splitlines()]
    for name, *numbers in [line.rsplit(maxsplit=5) for line in score.splitlines()[1:]]:
        found = next(row[1:] for row in rows if row and row[0] == name)
        assert list(map(float, found)) == pytest.approx(list(map(float, numbers)), rel=2e-3), name


@pytest.mark.slow
def test_the_first_screen_shows_what_diagnose_says(tmp_path, monkeypatch):
    [code], [_, said] = blocks(README, "python"), blocks(README, "text")
    [[_, *arguments]] = started("lie-rigid-body")
    (tmp_path / "my_filter.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with redirect_stdout(StringIO()) as printed:
        assert main(arguments) == 1
    assert printed.getvalue().split()[: len(said.split())] == said.split()


def test_the_readme_is_short_and_begins_with_the_two_commands():
    lines = README.splitlines()
    assert len(lines) <= 150
    assert next(i for i, line in enumerate(lines) if line.startswith("make test")) < 40


def test_make_targets_exist():
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    shown = [words[1] for words in started("make")]
    assert shown == ["sim", "test"]
    assert {*shown, "test-oldest"} <= set(targets)


def test_every_launch_file_is_shown():
    launched = started("ros2 launch", LAUNCH_PAGE)
    assert {words[3] for words in launched} == {file.name for file in (ROOT / "launch").glob("*.launch.py")}


def test_parameter_tables_name_every_parameter_with_its_default():
    for parameter in PARAMETERS:
        page = f"{IMU_PAGE}\n{SENSORS_PAGE}" if parameter.name in SENSORS.parameters else PARAMETERS_PAGE
        rows = [line for line in page.splitlines() if line.startswith("| `")]
        row = next(row for row in rows if f"`{parameter.name}`" in row.split("|")[1])
        default = parameter.default
        if isinstance(default, tuple):
            shown = re.findall(r"-?[\d.]+(?:e-?\d+)?", row.split("|")[3])
            assert tuple(map(float, shown)) == default
        elif isinstance(default, bool):
            assert f"`{str(default).lower()}`" in row
        else:
            assert f"`{default}`" in row or f"`'{default}'`" in row
