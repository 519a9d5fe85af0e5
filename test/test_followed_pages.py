"""Each block of code of a page is run, or a table says why not: pages with commands are followed as a reader would."""

from __future__ import annotations

import os
import re
import select
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest
import yaml

from lie_rigid_body import Estimate, simulate
from reader import (
    DOCS,
    FENCED,
    FILE,
    LANGUAGES,
    NOT_RUN,
    OTHERS,
    PROGRAMS,
    ROOT,
    blocks,
    commands,
    environment,
    follow,
    is_run,
    program,
)

PAGES = {
    page.relative_to(ROOT).with_suffix("").as_posix(): page.read_text(encoding="utf-8")
    for page in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
}
COMMANDS = {name: commands(*blocks(text, "bash", "console")) for name, text in PAGES.items()}
# test_readme.py follows these two, in its own process
FOLLOWED = {name for name, lines in COMMANDS.items() if any(map(is_run, lines))} - {"README", "docs/reference/commands"}
LIVE = {"docs/tutorials/bag_to_certificate", "docs/tutorials/filter_node_in_ci", "docs/how-to/program"}
"""Pages that start the node, or one of a filter."""


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[dict[str, str]]:
    with environment(tmp_path) as found:
        yield found


def own_files(folder: Path) -> None:
    """What other pages take for there: a clone, the filters of the tutorials, and a bag with two estimates."""
    (folder / "examples").symlink_to(ROOT / "examples")
    for page, name in (("first_filter", "my_filter.py"), ("campaign_with_two_filters", "filters.py")):
        [saved] = (b for b in blocks(PAGES[f"docs/tutorials/{page}"], "python") if b.startswith(f"# {name}\n"))
        (folder / name).write_text(
            saved.replace("DECLINATION = 0.0", "DECLINATION = 4.086"), encoding="utf-8"
        )  # as its page mends it
    run = simulate(
        "tumbling_cubesat",
        duration=45.0,
        rate=50.0,
        imu_rate=50.0,
        magnetometer_rate=50.0,
        accelerometer_mode="pivot_gravity",
    )
    estimate = Estimate(run.attitude().at(run.t_ns))
    run.to_bag(folder / "run.mcap", estimates={"/imu/data": estimate, "/odometry/filtered": estimate})
    shutil.copy(folder / "run.mcap", folder / "filter.mcap")


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.ros] * (n in LIVE)) for n in sorted(FOLLOWED)])
def test_a_page_is_followed(name: str, tmp_path: Path, reader: dict[str, str]) -> None:
    for line in filter(is_run, COMMANDS[name]):
        if program(line) in OTHERS and shutil.which(program(line)) is None:
            pytest.skip(f"{program(line)} is not installed")
    if "/tutorials/" not in name:  # these begin in an empty folder
        own_files(tmp_path)
    follow(PAGES[name], tmp_path, reader)


@pytest.mark.slow
@pytest.mark.ros
def test_the_tutorial_of_a_node_is_followed_where_colcon_has_built_the_package(
    tmp_path: Path, reader: dict[str, str]
) -> None:
    """There is no program of pip then; Python has the package, as it has where a workspace is sourced."""
    (tmp_path / "bin" / "lie-rigid-body").write_text("#!/bin/sh\nexit 127\n")
    follow(PAGES["docs/tutorials/filter_node_in_ci"], tmp_path, reader)


def test_what_the_example_started_ends_with_it_also_where_its_parent_has_ended(tmp_path: Path) -> None:
    """As the node that 'ros2 run' started, where 'ros2' was killed; the child holds the pipe until it ends."""
    spec = spec_from_file_location("example", ROOT / "examples" / "filter_in_ci" / "test_filter_node.py")
    assert spec is not None
    assert spec.loader is not None
    example = module_from_spec(spec)
    spec.loader.exec_module(example)
    with ExitStack() as stack:
        parent = example.started(stack, ["sh", "-c", "sleep 60 &"], stdout=subprocess.PIPE)
        assert parent.wait(timeout=30) == 0
        output = os.dup(parent.stdout.fileno())
    with open(output, "rb") as rest:
        ready, _, _ = select.select([rest], [], [], 10.0)
        assert ready, "its child still runs"
    with ExitStack() as stack:
        example.started(stack, ["true"]).wait(timeout=30)  # nothing is left


def test_a_command_that_fails_ends_the_page(tmp_path: Path, reader: dict[str, str]) -> None:
    follow("```bash\necho && false  # status 1\n```\n", tmp_path, reader)
    follow("```console\n$ echo a  b\n```\n```text\na b\n```\n", tmp_path, reader)
    follow("```python\nprint(1)\n```\n```json\n1\n```\n", tmp_path, reader)
    for wrong in (
        "```bash\necho && false\n```\n",
        "```bash\necho  # status 1\n```\n",
        "```console\n$ echo a\n```\n```text\nb\n```\n",
        "```bash\nunknown  # status 127\n```\n",
        "```python\nprint(1)\n```\n```json\n2\n```\n",
    ):
        with pytest.raises(AssertionError):
            follow(wrong, tmp_path, reader)


@pytest.mark.parametrize("name", PAGES)
def test_every_block_is_found_and_has_a_language(name: str) -> None:
    assert {language for language, _ in FENCED.findall(PAGES[name])} <= set(LANGUAGES)
    for block in blocks(PAGES[name], "python", "yaml"):
        assert FILE.match(block) or not re.match(r"# \S+\.(py|ya?ml)\b", block), "the name stands alone in its line"
    rest = FENCED.sub("", PAGES[name])
    assert "```" not in re.sub(r"`{1,2}[^`\n]+`{1,2}", "", rest)
    assert re.findall(r"\n\n(    (?! *[-*] ).*)", rest) == [], "an indented block has no language: fence it"


def test_pages_in_restructured_text_have_no_block_of_code() -> None:
    for page in DOCS.rglob("*.rst"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"^(?!\.\. ).*::$|code-block|literalinclude", text, re.MULTILINE)


@pytest.mark.parametrize("name", PAGES)
def test_every_command_is_run_or_it_is_told_why_not(name: str) -> None:
    assert {program(line) for line in filter(is_run, COMMANDS[name])} <= {*PROGRAMS, *OTHERS}
    for block in blocks(PAGES[name], "yaml"):
        assert FILE.match(block)
        assert yaml.safe_load(block)


def test_no_reason_is_left_over() -> None:
    lines = [line for shown in COMMANDS.values() for line in shown]
    assert [pattern for pattern in NOT_RUN if not any(re.match(pattern, line) for line in lines)] == []
    assert OTHERS - {program(line) for line in filter(is_run, lines)} == {"echo"}, "which is for pages of this file"
