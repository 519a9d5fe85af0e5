"""Each tutorial is followed from its first line to its last, in a folder of its own, as a reader would."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from ros_domains import own_domain

TUTORIALS = Path(__file__).parent.parent / "docs" / "tutorials"
PAGES = {page.stem: page.read_text(encoding="utf-8") for page in sorted(TUTORIALS.glob("*.md"))}
BLOCK = re.compile(r"^```(bash|python|text|yaml)\n(.*?)^```", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w./-]+)\n")
STATUS = re.compile(r"  # status (\d+)$")
LIVE = {"bag_to_certificate", "filter_node_in_ci"}
"""Tutorials that start the node."""

COMMANDS = {"python": "", "lie-rigid-body": "-m lie_rigid_body", "pytest": "-m pytest -p no:cacheprovider"}


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[dict[str, str]]:
    """The environment of a reader, whose commands are those of this Python."""
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, arguments in COMMANDS.items():
        (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments} "$@"\n', encoding="utf-8")
        (programs / name).chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "COV"))}
    path = os.pathsep.join([str(programs), os.environ["PATH"]])
    with own_domain() as domain:
        yield {**kept, "PATH": path, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def follow(text: str, folder: Path, environment: dict[str, str]) -> None:
    """Save each file, run each command and the blocks of Python, and find what was printed in what the page shows."""
    said, session = "", ""
    for language, block in BLOCK.findall(text):
        if language in ("python", "yaml") and (named := FILE.match(block)):
            (folder / named[1]).parent.mkdir(parents=True, exist_ok=True)
            (folder / named[1]).write_text(block, encoding="utf-8")
        elif language == "python":
            session += block
        elif language == "text":
            assert " ".join(block.split()) in " ".join(said.split())
        else:
            said = "".join(run(line, folder, environment) for line in block.splitlines())
    if session:
        (folder / "session.py").write_text(session, encoding="utf-8")
        run("python session.py", folder, environment)


def run(line: str, folder: Path, environment: dict[str, str]) -> str:
    """Run a command, which ends with status 0 or with the one that the page says, and return what it printed."""
    done = subprocess.run(
        ["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    status = STATUS.search(line)
    by_shell = done.returncode if done.returncode >= 0 else 128 - done.returncode  # as it tells of a signal
    assert by_shell == (int(status[1]) if status else 0), f"{line}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


@pytest.mark.long
def test_the_session_of_the_paper(tmp_path: Path, reader: dict[str, str]) -> None:
    follow(PAGES["paper_in_an_hour"], tmp_path, reader)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.ros] * (n in LIVE)) for n in PAGES if n != "paper_in_an_hour"],
)
def test_a_tutorial(name: str, tmp_path: Path, reader: dict[str, str]) -> None:
    follow(PAGES[name], tmp_path, reader)


def test_a_command_that_fails_ends_the_tutorial(tmp_path: Path, reader: dict[str, str]) -> None:
    follow("```bash\nfalse  # status 1\n```\n```bash\necho a  b\n```\n```text\na b\n```\n", tmp_path, reader)
    for wrong in (
        "```bash\nfalse\n```\n",
        "```bash\ntrue  # status 1\n```\n",
        "```bash\necho a\n```\n```text\nb\n```\n",
    ):
        with pytest.raises(AssertionError):
            follow(wrong, tmp_path, reader)


def test_workflows_are_yaml() -> None:
    for text in PAGES.values():
        for language, block in BLOCK.findall(text):
            assert language != "yaml" or yaml.safe_load(block)
