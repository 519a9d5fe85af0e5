"""Files from outside are read within bounds, whatever they are."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.report import write_plot, write_report
from lie_rigid_body.scenario.parameter_file import LARGEST_FILE, gather, read_parameter_file
from lie_rigid_body.system import bounded_input
from lie_rigid_body.system.bounded_input import load_yaml, open_file, read_text
from said import refusals

refused = refusals(
    {
        InputError: {
            "aliases": "x, line {line}, column .* aliases .* are not read",
            "nested": "nested deeper than {levels} levels",
            "no YAML": "not readable as YAML",
            "long": "longer than the {bytes} bytes",
            "device": "{path} is a device",
            "pipe": "is a pipe",
            "open pipe": "is a pipe that nobody closed within {seconds} s",
            "no path": "is no path: give that of|let the name end in",
        }
    }
)
WAITING = "waiting for whoever writes into the pipe {path}, {seconds} s at most\n"
PARAMETERS = b"/**: {ros__parameters: {rate: 10.0}}"


def bomb(levels: int) -> str:
    """Each line has nine times the values of the one before."""
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join(9 * [f'*a{i - 1}'])}]" for i in range(1, levels)]
    return "\n".join(lines)


@pytest.fixture
def pipe() -> Iterator[tuple[str, int]]:
    """The path of a pipe as the shell gives it for ``<(command)``, and the end to write to."""
    ours, theirs = os.pipe()
    yield f"/dev/fd/{ours}", theirs
    os.close(ours)


def test_a_text_that_multiplies_is_refused() -> None:
    with refused("aliases", line=2):
        load_yaml(bomb(8), "x")


@pytest.mark.parametrize("text", [21 * "[", 21 * "{", 21 * "{a: [1, "])
def test_deep_brackets_are_refused_before_they_are_read(text: str) -> None:
    with refused("nested", levels=20):
        load_yaml(text, "x")


@pytest.mark.parametrize(
    "text",
    [10_000 * "- ", 10_000 * "? ", "!!bool x", "!!int ''", "!!timestamp x", "\0", r'["\ud800"]', r'{"\uDFFF": 1}'],
)
def test_whatever_pyyaml_raises_is_one_error(text: str) -> None:
    with refused("no YAML") as caught:
        load_yaml(text, "x")
    assert "\n" not in str(caught.value)


def test_a_file_has_a_largest_size(tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    path.write_bytes(PARAMETERS + b" " * (LARGEST_FILE - len(PARAMETERS)))
    assert read_parameter_file(path) == {"rate": 10.0}
    os.truncate(path, 2**40)
    with refused("long", bytes=LARGEST_FILE):
        read_parameter_file(path)


def test_a_device_is_refused() -> None:
    with refused("device", path="/dev/zero"):
        read_text("/dev/zero", 10)


def test_a_pipe_of_the_shell_is_read_once(pipe: tuple[str, int]) -> None:
    path, writer = pipe
    os.write(writer, PARAMETERS)
    os.close(writer)
    assert gather(None, [path], []) == {"rate": 10.0}


def test_a_pipe_is_not_read_beyond_the_limit(pipe: tuple[str, int]) -> None:
    path, writer = pipe
    os.write(writer, bytes(1000))
    with refused("long", bytes=999):
        read_text(path, 999)
    os.close(writer)


def test_a_wait_for_a_pipe_is_told_and_only_if_there_is_one(
    pipe: tuple[str, int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bounded_input, "SILENT_WAIT", 0.0)
    path, writer = pipe
    os.write(writer, PARAMETERS)
    ahead = threading.Timer(0.05, os.close, [writer])
    ahead.start()
    assert gather(None, [path], []) == {"rate": 10.0}
    ahead.join()
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(bounded_input, "LONGEST_WAIT", 0.05)
    reader, writer = os.pipe()
    with refused("open pipe", seconds=0.05):
        read_text(f"/dev/fd/{reader}", 100)
    os.close(reader)
    os.close(writer)
    assert capsys.readouterr().err == WAITING.format(path=f"/dev/fd/{reader}", seconds=0.05)


def test_nobody_waits_for_ever_for_a_writer(
    pipe: tuple[str, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounded_input, "LONGEST_WAIT", 0.05)
    os.mkfifo(tmp_path / "fifo")
    path, writer = pipe
    os.write(writer, b"begun")
    for waiting in (path, tmp_path / "fifo"):
        with refused("open pipe", seconds=0.05):
            read_text(waiting, 100)
        with refused("pipe"):
            open_file(waiting)
    os.close(writer)


@pytest.mark.parametrize("given", [None, 5, b"a.mcap", ["a.mcap"]])
def test_what_is_no_path_is_refused_wherever_python_takes_one(given: Any) -> None:
    """A number would be a descriptor to the system, such as that of stdin."""
    run = simulate(duration=0.1)
    score = run.score(run.truth.attitude_xyzw, diagnosed=False)
    takers: list[Callable[[Any], object]] = [
        run.to_bag,
        Run.from_bag,
        read_bag,
        Campaign.from_file,
        read_parameter_file,
        lambda path: write_plot(score, path),
        lambda path: write_report(score, path),
    ]
    for take in takers:
        with refused("no path"):
            take(given)
