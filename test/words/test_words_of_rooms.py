"""What the rooms say is what `words.txt` has: `make words` writes a better sentence into one line of it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from sentences import command_entries, commands, compare, entries, module_of, rooms

OF_ROS = {"ros", "nodes"}
# whose examples take seconds
SLOW = {"certificate", "evaluation", "nodes", "verbs"}
ROOMS = [
    pytest.param(room, marks=[pytest.mark.ros] * (room in OF_ROS) + [pytest.mark.slow] * (room in SLOW))
    for room in rooms()
]


@pytest.mark.usefixtures("asked_here")
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("room", ROOMS)
def test_what_a_room_says_is_written_down(
    room: str,
    tmp_path: Path,
    pytestconfig: pytest.Config,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = module_of(room)
    if hasattr(module, "run"):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])
        told = command_entries(module, tmp_path, capfd, commands(room))
    else:
        told = entries(module, tmp_path)
    compare(room, told, write=pytestconfig.getoption("--write-words"))
