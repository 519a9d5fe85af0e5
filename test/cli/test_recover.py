"""``recover`` as its users meet it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.cli.recover import main as recover


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """A bag that lacks its end."""
    path = tmp_path / "broken.mcap"
    assert record([str(path), "--duration", "20", "-p", "motion:=closed_form", "--chunk-size", "20000", "--quiet"]) == 0
    os.truncate(path, path.stat().st_size // 2)
    return path


def test_it_says_how_much_and_up_to_which_stamp(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before, fixed = broken.read_bytes(), broken.with_name("my fixed.mcap")
    assert recover([str(broken), "-o", str(fixed)]) == 0
    much, wrong, remedy = capsys.readouterr().out.splitlines()
    count = int(much.partition(" ")[0])
    assert 1000 < count < 3000
    # messages are the scenario, then a pose and a twist every 10 ms
    last = (count - 2) // 2 * 0.01
    assert f"{count} messages on 3 topics, stamps 0.000000000 to {last:.2f}0000000 s, in {fixed} (" in much
    assert wrong.startswith(f"{broken} breaks off in the record at byte ")
    assert remedy == f"certify them with: lie-rigid-body check '{fixed}'"
    assert check([str(fixed)]) == 0
    assert broken.read_bytes() == before


def test_an_existing_file_is_kept_without_force(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fixed = broken.with_name("fixed.mcap")
    fixed.write_text("precious")
    assert recover([str(broken), "-o", str(fixed)]) == 2
    assert "exists and is kept: give another name, or --force" in capsys.readouterr().err
    assert fixed.read_text() == "precious"
    assert recover([str(broken), "-o", str(fixed), "--force"]) == 0
    assert check([str(fixed)]) == 0


@pytest.mark.parametrize("name", ["broken.mcap", "link.mcap"])
def test_the_input_is_never_replaced(broken: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    before = broken.read_bytes()
    broken.with_name("link.mcap").symlink_to(broken)
    assert recover([str(broken), "-o", str(broken.with_name(name)), "--force"]) == 2
    assert "is the broken file itself" in capsys.readouterr().err
    assert broken.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (".", "is a folder"),
        ("none.mcap", "does not exist"),
        ("text", "does not begin as an MCAP file"),
        ("empty", "does not begin as an MCAP file"),
        ("head", "holds no whole message"),
    ],
)
def test_what_holds_nothing_is_refused_in_one_line(
    broken: Path, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    folder = broken.parent
    (folder / "text").write_text("hello")
    (folder / "empty").touch()
    (folder / "head").write_bytes(broken.read_bytes()[:60])
    assert recover([str(folder / name), "-o", str(folder / "fixed.mcap")]) == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.count("\n") == 1
    assert not (folder / "fixed.mcap").exists()


def test_a_killed_recording_is_recovered_and_certified(tmp_path: Path) -> None:
    broken, fixed = tmp_path / "killed.mcap", tmp_path / "fixed.mcap"
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(broken), "-p", "motion:=closed_form"]
    with subprocess.Popen([*command, "--duration", "100000", "--quiet"]) as process:
        while not broken.exists() or broken.stat().st_size < 300_000:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    assert recover([str(broken), "-o", str(fixed)]) == 0
    assert check([str(fixed)]) == 0
