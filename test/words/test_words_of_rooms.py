"""What the rooms say is what the texts of this folder have: `make words` writes a better sentence into one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from sentences import compare, entries, rooms


@pytest.mark.usefixtures("asked_here")
@pytest.mark.parametrize("room", rooms())
def test_what_a_room_says_is_written_down(room: str, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    write = pytestconfig.getoption("--write-words")
    compare(room, f"words_of_{room}.py", entries(room, tmp_path), write=write)
