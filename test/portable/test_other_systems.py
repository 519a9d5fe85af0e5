"""Names of files and terminals as systems other than POSIX have them."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import pytest

from lie_rigid_body.cli.record import main as record
from lie_rigid_body.scenario.parameter_file import parse_assignment
from lie_rigid_body.system import console
from lie_rigid_body.system.portable import cores


@pytest.mark.parametrize(
    ("name", "quoted"),
    [
        ("C:\\a friend\\run.mcap", '"C:\\a friend\\run.mcap"'),
        ("D:\\it's.mcap", "D:\\it's.mcap"),
        ("\\\\host\\share\\run.mcap", "\\\\host\\share\\run.mcap"),
        ("my runs\\", '"my runs\\\\"'),  # a backslash before a quotation mark takes its meaning away
    ],
)
def test_a_command_names_a_file_as_shells_with_backslashes_read_it(
    name: str, quoted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "sep", "\\")
    assert console.quoted(name) == quoted


def test_an_assignment_has_a_drive_and_its_folders() -> None:
    assert parse_assignment("record_path:=C:\\runs\\a.mcap") == ("record_path", "C:\\runs\\a.mcap")


class Terminal(io.TextIOWrapper):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "ascii"])
def test_a_terminal_of_few_characters_gets_a_bar(
    encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = Terminal(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stderr", stream)
    assert record([str(tmp_path / "run.mcap"), "--duration", "2"]) == 0
    stream.flush()
    assert b"200/200" in stream.buffer.getvalue()  # type: ignore[attr-defined]


def test_cores_are_counted_without_an_affinity(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert cores() == os.cpu_count()
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert cores() == 1
