"""Every verb that is asked to end while it works ends with 130 and one line, and leaves no part of a file."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest

from lie_rigid_body.cli.record import main as record

PROGRAM = """
import json, os, signal, sys
from importlib import import_module
from pathlib import Path
from lie_rigid_body.__main__ import main

def send_itself(number, place):
    # in place of a call: the signal, and then the call
    module, _, name = place.partition(":")
    holder = import_module(module)
    if "." in name:
        holder, name = getattr(holder, name.partition(".")[0]), name.partition(".")[2]
    call = getattr(holder, name)

    def struck(*arguments, **options):
        setattr(holder, name, call)
        print(f"at {place}", *sorted(os.listdir(".")), flush=True)
        os.kill(os.getpid(), int(number))
        return call(*arguments, **options)

    setattr(holder, name, struck)

handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
for told in sys.argv[1:]:
    for number, handler in handlers.items():  # as in a process that begins
        signal.signal(number, handler)
    *blows, verb = told.split(";")
    for blow in blows:
        send_itself(*blow.split(" "))
    status = main(verb.split())
    print(chr(0), json.dumps([status, sorted(map(str, Path(".").rglob("*")))]), chr(0), sep="", end="", flush=True)
    print(chr(0), end="", file=sys.stderr, flush=True)
"""
CHUNK = "lie_rigid_body.recording.mcap_writer:McapFile.add_chunk"
READ = "lie_rigid_body.recording.bag_files:BagFiles.contents"
WRITTEN = "lie_rigid_body.system.output_file:OutputFile.commit"
DISCARDED = "lie_rigid_body.system.output_file:OutputFile.discard"
PLOT = "plot bag.mcap -o new.png"
RECOVER = "recover bag.mcap -o new.mcap"
VERBS = {
    "check bag.mcap": READ,
    "check bag.mcap --report new.html": WRITTEN,
    PLOT: WRITTEN,
    "evaluate bag.mcap --estimate /pose": READ,
    "evaluate bag.mcap --estimate /pose --plot new.png": WRITTEN,
    "evaluate bag.mcap --estimate /pose --report new.html": WRITTEN,
    RECOVER: CHUNK,
    "recover run -o new": CHUNK,
    "record new.mcap --duration 1": "lie_rigid_body.cli.record:scenario_of",
    "explain": "lie_rigid_body.cli.explain:scenario_of",
    "scenarios": "lie_rigid_body.system.console:say",
}
"""Commands, and the call at which the signal comes."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of a bag, and a folder of it."""
    assert record([str(tmp_path / "bag.mcap"), "--duration", "0.1", "--quiet"]) == 0
    (tmp_path / "run").mkdir()
    shutil.copy(tmp_path / "bag.mcap", tmp_path / "run" / "run_0.mcap")
    return tmp_path


class Ended(NamedTuple):
    """How a verb ended: its exit status, what it printed, and the files that are there."""

    status: int
    out: str
    err: str
    files: list[str]


def run(folder: Path, *verbs: tuple[str, Sequence[tuple[int, str]]], program: str = PROGRAM) -> list[Ended]:
    """Run verbs one after another in one process, each with signals and the calls at which they come."""
    told = [";".join([*(f"{int(number)} {place}" for number, place in blows), verb]) for verb, blows in verbs]
    environment = os.environ | {"MPLBACKEND": "no_such_window"}  # as Jupyter names one: a picture needs none
    command = [sys.executable, "-c", program, *told]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    said, complained = done.stdout.split("\0"), done.stderr.split("\0")
    assert (done.returncode, len(complained)) == (0, len(verbs) + 1), done.stderr
    ends = [json.loads(end) for end in said[1::2]]
    texts = zip(ends, said[::2], complained, strict=False)
    return [Ended(status, out, err, files) for (status, files), out, err in texts]


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.mark.slow
def test_a_verb_that_is_interrupted_says_so_and_leaves_nothing(folder: Path) -> None:
    before = names(folder)
    verbs = [verb for verb in VERBS if "--report" not in verb or find_spec("plotly")]
    struck = [*((verb, signal.SIGTERM) for verb in verbs), (RECOVER, signal.SIGINT), (RECOVER, signal.SIGHUP)]
    found = run(folder, *((verb, [(number, VERBS[verb])]) for verb, number in struck))
    for (verb, _), ended in zip(struck, found, strict=True):
        assert (verb, ended.status, ended.err.count("\n"), ended.files) == (verb, 130, 1, before)
        assert ended.err.startswith(f"lie-rigid-body {verb.split()[0]}: ")
        assert ended.out.startswith(f"at {VERBS[verb]} ")
        assert (" new" in ended.out) == (VERBS[verb] in {WRITTEN, CHUNK})


@pytest.mark.slow
def test_an_older_file_outlives_an_interruption(folder: Path) -> None:
    for old in ("new.png", "new.mcap"):
        (folder / old).write_text("old")
    before = names(folder)
    for ended in run(folder, *((f"{verb} --force", [(signal.SIGTERM, WRITTEN)]) for verb in (PLOT, RECOVER))):
        assert (ended.status, ended.err.count("\n"), ended.files) == (130, 1, before)
        assert ".part" in ended.out
    assert {(folder / old).read_text() for old in ("new.png", "new.mcap")} == {"old"}


def test_a_second_request_does_not_tear_the_cleaning_up(folder: Path) -> None:
    """As ``timeout`` sends to the process, and to its group, and a terminal that closes does."""
    before = names(folder)
    term, hup, interrupt = signal.SIGTERM, signal.SIGHUP, signal.SIGINT
    pairs = [(term, term), (hup, term), (term, interrupt)]
    for ended in run(folder, *((RECOVER, [(first, WRITTEN), (second, DISCARDED)]) for first, second in pairs)):
        assert (ended.status, ended.err.count("\n"), ended.files) == (130, 1, before)
        assert f"at {DISCARDED} bag.mcap new.mcap" in ended.out


@pytest.mark.slow
def test_a_terminal_that_closes_ends_nothing_under_nohup(folder: Path) -> None:
    program = f"import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n{PROGRAM}"
    drawn, checked = run(folder, (PLOT, [(signal.SIGHUP, WRITTEN)]), ("check bag.mcap", []), program=program)
    assert (drawn.status, drawn.err, "new.png" in drawn.files) == (0, "", True)
    assert (checked.status, checked.err) == (0, "")
