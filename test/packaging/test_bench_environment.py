"""The benchmark finds a Python that PyBullet is built for, or does without it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from test_bootstrap import BASE_PYTHON, executable, find_python, make

ROOT = Path(__file__).resolve().parents[2]
VERSION = "import sys; print(*sys.version_info[:2])"


def test_a_python_for_pybullet_is_310_or_311() -> None:
    found = find_python("bench")
    if found.returncode == 3:
        pytest.skip("no Python 3.10 or 3.11 here")
    version = subprocess.run((found.stdout.strip(), "-c", VERSION), capture_output=True, text=True, check=True).stdout
    assert version.strip() in {"3 10", "3 11"}


@pytest.mark.skipif(sys.version_info < (3, 12), reason="needs a Python that PyBullet is not built for")
def test_another_python_is_not_taken_for_one(tmp_path: Path) -> None:
    python = executable(tmp_path / "python3.11", f'#!/bin/sh\nexec "{BASE_PYTHON}" "$@"\n')
    assert find_python("bench", PYTHON=str(python)).returncode == 3
    assert find_python("headless", PYTHON=str(python)).returncode == 0


def test_without_any_python_it_is_one_clear_line() -> None:
    done = make("bench", "PYTHON=/bin/false")
    assert done.returncode != 0
    ours = [line for line in done.stderr.splitlines() if not line.startswith("make: ***")]
    assert len(ours) == 1
    assert "3.10" in ours[0]


def test_help_and_clean_know_it() -> None:
    assert "make bench" in make().stdout
    assert ".venv-bench" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_its_help_builds_nothing_and_a_mistyped_argument_neither() -> None:
    """PYTHON=/bin/false would stop every set-up."""
    told = make("bench", "PYTHON=/bin/false", "ARGS=--help")
    assert told.returncode == 0
    assert "--save" in told.stdout
    mistyped = make("bench", "PYTHON=/bin/false", "ARGS=--sav")
    assert mistyped.returncode != 0
    assert "'--sav'" in mistyped.stderr
    assert "3.10" not in mistyped.stderr
