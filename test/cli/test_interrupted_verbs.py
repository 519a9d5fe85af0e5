"""Every verb that is asked to end while it works ends with 130 and one line, and leaves no part of a file."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from lie_rigid_body.cli.record import main as record

PROGRAM = """
import os, sys
from importlib import import_module
from lie_rigid_body.__main__ import main

def send_itself(number, place):
    # in place of a call: the signal, and then the call
    module, _, name = place.partition(":")
    holder = import_module(f"lie_rigid_body.{module}")
    if "." in name:
        holder, name = getattr(holder, name.partition(".")[0]), name.partition(".")[2]
    call = getattr(holder, name)

    def struck(*arguments, **options):
        setattr(holder, name, call)
        print(f"at {place}", *sorted(os.listdir(".")), flush=True)
        os.kill(os.getpid(), int(number))
        return call(*arguments, **options)

    setattr(holder, name, struck)

*blows, verb = sys.argv[1].split(";")
for blow in blows:
    send_itself(*blow.split(" "))
sys.exit(main(verb.split()))
"""
CHUNK = "recording.mcap_file:McapFile.add_chunk"
READ = "recording.bag_files:BagFiles.read"
WRITTEN = "recording.output_file:OutputFile.commit"
DISCARDED = "recording.output_file:OutputFile.discard"
RECOVER = "recover bag.mcap -o new.mcap"
VERBS = {
    "check bag.mcap": READ,
    "check bag.mcap --report new.html": WRITTEN,
    "plot bag.mcap -o new.png": WRITTEN,
    "evaluate bag.mcap --estimate /pose": READ,
    "evaluate bag.mcap --estimate /pose --plot new.png": WRITTEN,
    "evaluate bag.mcap --estimate /pose --report new.html": WRITTEN,
    RECOVER: CHUNK,
    "recover run -o new": CHUNK,
    "record new.mcap --duration 1": "console:scenario",
    "explain": "console:scenario",
    "scenarios": "console:say",
}
"""Commands, and the call at which the signal comes."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of a bag, and a folder of it."""
    assert record([str(tmp_path / "bag.mcap"), "--duration", "0.1", "--quiet"]) == 0
    (tmp_path / "run").mkdir()
    shutil.copy(tmp_path / "bag.mcap", tmp_path / "run" / "run_0.mcap")
    return tmp_path


def run(folder: Path, verb: str, *blows: tuple[int, str], program: str = PROGRAM) -> subprocess.CompletedProcess[str]:
    if "--report" in verb and not find_spec("plotly"):
        pytest.skip("plotly is not installed")
    told = ";".join([*(f"{int(number)} {place}" for number, place in blows), verb])
    command = [sys.executable, "-c", program, told]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


@pytest.mark.parametrize(
    ("verb", "number"),
    [*((verb, signal.SIGTERM) for verb in VERBS), (RECOVER, signal.SIGINT), (RECOVER, signal.SIGHUP)],
)
def test_a_verb_that_is_interrupted_says_so_and_leaves_nothing(folder: Path, verb: str, number: int) -> None:
    before = names(folder)
    ended = run(folder, verb, (number, VERBS[verb]))
    assert (ended.returncode, ended.stderr) == (130, f"lie-rigid-body {verb.split()[0]}: error: interrupted\n")
    assert ended.stdout.startswith(f"at {VERBS[verb]} ")
    assert (" new" in ended.stdout) == (VERBS[verb] in {WRITTEN, CHUNK})
    assert names(folder) == before


@pytest.mark.parametrize("verb", ["plot bag.mcap -o new.png --force", f"{RECOVER} --force"])
def test_an_older_file_outlives_an_interruption(folder: Path, verb: str) -> None:
    old = folder / verb.split()[3]
    old.write_text("old")
    before = names(folder)
    ended = run(folder, verb, (signal.SIGTERM, WRITTEN))
    assert (ended.returncode, ended.stderr.count("\n")) == (130, 1)
    assert ".part" in ended.stdout
    assert names(folder) == before
    assert old.read_text() == "old"


@pytest.mark.parametrize(
    ("first", "second"),
    [(signal.SIGTERM, signal.SIGTERM), (signal.SIGHUP, signal.SIGTERM), (signal.SIGTERM, signal.SIGINT)],
)
def test_a_second_request_does_not_tear_the_cleaning_up(folder: Path, first: int, second: int) -> None:
    """As ``timeout`` sends to the process, and to its group, and a terminal that closes does."""
    before = names(folder)
    ended = run(folder, RECOVER, (first, WRITTEN), (second, DISCARDED))
    assert (ended.returncode, ended.stderr) == (130, "lie-rigid-body recover: error: interrupted\n")
    assert f"at {DISCARDED} bag.mcap new.mcap" in ended.stdout
    assert names(folder) == before


def test_a_terminal_that_closes_ends_nothing_under_nohup(folder: Path) -> None:
    program = f"import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n{PROGRAM}"
    ended = run(folder, "plot bag.mcap -o new.png", (signal.SIGHUP, WRITTEN), program=program)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (folder / "new.png").exists()
