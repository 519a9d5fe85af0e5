"""Files from outside are read within bounds, whatever they are."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.report import write_plot, write_report
from lie_rigid_body.scenario.parameter_file import MAX_FILE_BYTES, read_parameter_file
from lie_rigid_body.system.bounded_input import load_yaml, read_text

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
    with pytest.raises(InputError, match=r"x, line 2, column .* aliases .* are not read"):
        load_yaml(bomb(8), "x")


@pytest.mark.parametrize(
    "text",
    [10_000 * "- ", 10_000 * "? ", "!!bool x", "!!int ''", "!!timestamp x", "\0", 60_000 * "[", 60_000 * "{a: "],
)
def test_whatever_pyyaml_raises_is_one_error(text: str) -> None:
    with pytest.raises(InputError, match="not readable as YAML") as caught:
        load_yaml(text, "x")
    assert "\n" not in str(caught.value)


def test_a_file_has_a_largest_size(tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    path.write_bytes(PARAMETERS + b" " * (MAX_FILE_BYTES - len(PARAMETERS)))
    assert read_parameter_file(path) == {"rate": 10.0}
    os.truncate(path, 2**40)
    with pytest.raises(InputError, match=f"longer than the {MAX_FILE_BYTES} bytes"):
        read_parameter_file(path)


def test_a_device_is_refused() -> None:
    with pytest.raises(InputError, match="/dev/zero is a device"):
        read_text("/dev/zero", 10)


def test_a_pipe_is_not_read_beyond_the_limit(pipe: tuple[str, int]) -> None:
    path, writer = pipe
    os.write(writer, bytes(1000))
    with pytest.raises(InputError, match="longer than the 999 bytes"):
        read_text(path, 999)
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
        with pytest.raises(InputError, match=r"is no path: give that of|let the name end in"):
            take(given)
