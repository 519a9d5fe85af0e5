"""Blocks of code of the pages, and a reader who follows a page from its first line to its last."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w./-]+)\n")
STATUS = re.compile(r"  # status (\d+)$")

LANGUAGES = {
    "python": "saved as the file that its first line names, or run in the session of the page",
    "yaml": "saved as the file that its first line names",
    "bash": "run line by line; a comment tells a status other than 0",
    "console": "as bash, with a prompt",
    "text": "printed by the commands before it",
    "json": "printed by the session of the page",
    "none": "a drawing",
}
"""What becomes of a block."""

PROGRAMS = {"python": "", "lie-rigid-body": "-m lie_rigid_body", "pytest": "-m pytest -p no:cacheprovider"}
"""Programs of the package, as arguments of this Python."""
OTHERS = {"echo", "g++", "sed", "timeout"}

NOT_RUN = {
    r"make ": "sets up environments, and runs this suite: the workflow test.yml does",
    r"git clone |python benchmarks/public_filters\.py ": "wants the network: the page has what the benchmark printed",
    r"(python3 -m )?pip install ": "wants the network: test/packaging installs the wheel in an environment of its own",
    r"(source|rosdep|colcon|export|ros2|rviz2) ": "wants ROS 2 from apt: test_ros2_commands.py holds the lines",
    r"python -m lie_rigid_body\.ros\.listen\b": "wants a node beside it: test/ros/test_listen.py",
    r"lie-rigid-body sim .*lockstep_topic": "waits for a filter without end: test/ros/test_lockstep_run.py",
    r"lie-rigid-body (diagnose|league) --node 'ros2 ": "wants a filter of ROS 2: test/ros/test_node_estimator.py",
    r"python examples/complementary_filter/": "a node without end: test/ros/test_live_evaluate.py",
    r"dask |lie-rigid-body campaign .*--scheduler": "wants hosts of the reader: test/campaign/test_campaign_results.py",
}
"""Commands that no test runs, and why; what holds them instead."""


def blocks(text: str, *languages: str) -> list[str]:
    """The blocks of a page that are of these languages."""
    return [block for language, block in FENCED.findall(text) if language in languages]


def commands(*shown: str) -> list[str]:
    """The command lines of blocks, without the prompt."""
    return [line.removeprefix("$ ") for block in shown for line in block.splitlines()]


def program(line: str) -> str:
    return line.split()[0]


def is_run(line: str) -> bool:
    return not any(re.match(pattern, line) for pattern in NOT_RUN)


@contextmanager
def environment(folder: Path) -> Iterator[dict[str, str]]:
    """The environment of a reader, whose commands are those of this Python."""
    from ros_domains import own_domain  # by locks that only POSIX has

    programs = folder / "bin"
    programs.mkdir()
    for name, arguments in PROGRAMS.items():
        (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments} "$@"\n', encoding="utf-8")
        (programs / name).chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "COV"))}
    path = os.pathsep.join([str(programs), os.environ["PATH"]])
    with own_domain() as domain:
        yield {**kept, "PATH": path, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def follow(text: str, folder: Path, environment: dict[str, str]) -> None:
    """Save each file, run each command and the blocks of Python, and find what was printed in what the page shows."""
    said, session, shown = "", "", []
    for language, block in FENCED.findall(text):
        if language in ("python", "yaml") and (named := FILE.match(block)):
            (folder / named[1]).parent.mkdir(parents=True, exist_ok=True)
            (folder / named[1]).write_text(block, encoding="utf-8")
        elif language == "python":
            session += block
        elif language == "text":
            assert " ".join(block.split()) in " ".join(said.split())
        elif language == "json":
            shown.append(block)
        elif language in ("bash", "console"):
            said = "".join(run(line, folder, environment) for line in filter(is_run, commands(block)))
    if session:
        (folder / "session.py").write_text(session, encoding="utf-8")
        said = run("python session.py", folder, environment)
    assert all(block in said for block in shown)


def run(line: str, folder: Path, environment: dict[str, str]) -> str:
    """Run a command, which ends with status 0 or with the one that the page says, and return what it printed."""
    assert program(line) in {*PROGRAMS, *OTHERS}, f"{line}: what cannot be run belongs into NOT_RUN"
    done = subprocess.run(
        ["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    status = STATUS.search(line)
    by_shell = done.returncode if done.returncode >= 0 else 128 - done.returncode  # as it tells of a signal
    assert by_shell == (int(status[1]) if status else 0), f"{line}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr
