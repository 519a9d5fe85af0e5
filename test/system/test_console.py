"""Whatever becomes of stdout and stderr, users see one line at most, and a status that means what it says."""

from __future__ import annotations

import errno
import json
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import NoReturn

import pytest

from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.evaluate import main as evaluate
from lie_rigid_body.cli.plot import main as plot
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.cli.recover import main as recover
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.system import console
from sampled import sampled

ANSWERS = [
    "--help",
    "scenarios --json",
    "check {bag}",
    "explain",
]
WRITERS = [
    "record {new} --duration 0.1",
    pytest.param("plot {bag} -o {new}.png", marks=pytest.mark.slow),
    pytest.param("evaluate {bag} --estimate /pose --report {new}.html", marks=pytest.mark.slow),
]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("console") / "bag.mcap"
    assert record([str(path), "--duration", "0.1", "--quiet"]) == 0
    return path


def run(command: str, bag: Path, folder: Path, redirection: str) -> subprocess.CompletedProcess[str]:
    arguments = command.format(bag=bag, new=folder / "new.mcap")
    line = f"{sys.executable} -m lie_rigid_body {arguments} {redirection}"
    return subprocess.run(line, shell=True, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("command", [*sampled(ANSWERS, every=3), *WRITERS])
def test_full_stdout_is_told_in_one_line(command: str, bag: Path, tmp_path: Path) -> None:
    done = run(command, bag, tmp_path, ">/dev/full")
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert "stdout" in line
    assert os.strerror(errno.ENOSPC) in line
    for written in tmp_path.iterdir():
        assert written.name in line


# with an end of stdout that is no error: all answer by the one function that the test above finds in each
@pytest.mark.parametrize("command", sampled(["--help", "check {bag}", WRITERS[0]], every=3))
def test_closed_stdout_is_nobodys_fault(command: str, bag: Path, tmp_path: Path) -> None:
    done = run(command, bag, tmp_path, ">&-")
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


def test_reader_who_leaves_hears_no_complaint(bag: Path, tmp_path: Path) -> None:
    assert run("explain", bag, tmp_path, "| true").stderr == ""


@pytest.mark.parametrize(("arguments", "status"), [([], 0), (["--inertia", "1,2,2.5"], 1)])
def test_reader_who_leaves_changes_no_verdict(bag: Path, arguments: list[str], status: int) -> None:
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "lie_rigid_body", "check", str(bag), *arguments]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, timeout=60, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (status, b"")


@pytest.mark.parametrize("debug", ["", "1"])
def test_full_stderr_changes_no_status(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, debug: str) -> None:
    monkeypatch.setenv(console.DEBUG, debug)
    assert run("check {new}", bag, tmp_path, "2>/dev/full").returncode == 2


@pytest.mark.slow
def test_without_standard_streams_a_bag_is_not_taken_for_one(bag: Path, tmp_path: Path) -> None:
    assert run("record {new} --duration 0.1", bag, tmp_path, "<&- >&- 2>&-").returncode == 0
    assert (tmp_path / "new.mcap").read_bytes() == bag.read_bytes()
    done = run("check none", bag, tmp_path, "2>&-")
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.parametrize("command", sampled(["check {bag}", "explain", "record {new}\udcffé --duration 0.1"], every=3))
def test_stdout_of_few_characters_gets_escapes(
    command: str, bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    done = run(command, bag, tmp_path, "")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()


def test_json_names_every_file(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    odd = tmp_path / "\udcffé.mcap"
    odd.hardlink_to(bag)
    assert check([str(odd), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bag"] == str(odd)


NAMES = ["we ird name", "it's \\ a tab", "$x é", "-o"]


@pytest.mark.usefixtures("asked_here")
@pytest.mark.filterwarnings("ignore:.*use of fork:DeprecationWarning")  # of the threads of pytest's plugins
@pytest.mark.parametrize(
    ("verb", "arguments", "status"),
    [
        (check, "{bag}", 0),
        (check, "{bag} {other}", 0),
        (check, "{bag} {other} --inertia 1,2,2.5", 1),
        (record, "{new} --duration 0.1", 0),
        (recover, "{bag} -o {new}", 0),
        (plot, "{bag} -o {new}.png", 0),
        (evaluate, "{bag} --estimate /pose --plot {new}.png", 0),
    ],
)
def test_the_name_of_a_file_stays_on_its_line(
    verb: console.Main, arguments: str, status: int, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a\nb.mcap").hardlink_to(bag)
    names = {"bag": tmp_path / "a\nb.mcap", "new": tmp_path / "c\nd.mcap", "other": bag}
    assert verb([argument.format(**names) for argument in arguments.split(" ")]) == status
    said = capsys.readouterr().out
    for name in ("a\nb", "c\nd"):
        assert name not in said
    assert r"a\nb.mcap" in said or r"c\nd.mcap" in said


@pytest.mark.parametrize("name", NAMES)
def test_the_shell_finds_the_file_that_a_command_names(name: str) -> None:
    said = subprocess.run(["bash", "-c", f"printf %s {console.quoted(name)}"], capture_output=True, check=True).stdout
    assert said == os.fsencode(name)
    assert console.quoted(name).isprintable()


def test_a_terminal_is_not_controlled_by_what_a_file_says(capsys: pytest.CaptureFixture[str]) -> None:
    console.say("\x1b[2J\nnext")
    console.complain("verb", "\x1b[2J")
    assert capsys.readouterr() == ("\\x1b[2J\nnext\n", "verb: error: \\x1b[2J\n")


def test_an_error_is_one_line_of_which_nothing_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    console.complain("verb", "a\nfolder/" * 1000 + " is no bag: give one")
    assert capsys.readouterr().err == f"verb: error: {'a folder/' * 1000} is no bag: give one\n"


OVERFLOW = """
import numpy as np
from lie_rigid_body.system import console
raise SystemExit(console.status_of("verb", lambda: int(np.isinf(np.full(2, 1e308) * 10.0).all()), to_the_end=True))
"""


@pytest.mark.parametrize(("options", "lines"), [((), 0), (("-W", "default"), 2)])
def test_numbers_beyond_doubles_are_no_lines_on_stderr_unless_python_is_told_so(
    options: tuple[str, ...], lines: int, tmp_path: Path
) -> None:
    (tmp_path / "program.py").write_text(OVERFLOW, encoding="utf-8")
    command = [sys.executable, *options, "program.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (1, lines)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("division by zero"), "this is a bug, .*ZeroDivisionError: division by zero.*DEBUG=1"),
        (UnicodeEncodeError("ascii", "²" * 999, 0, 1, "no"), "this is a bug, .*UnicodeEncodeError.*DEBUG=1"),
        (MemoryError(), "not enough memory"),
        (PermissionError(13, "Permission denied", "a/file"), "Permission denied .a/file."),
        (ImportError("No module named 'numpy'"), "No module named 'numpy'"),
        (BagError("no bag"), "no bag"),
        (SystemExit("a library ends"), "a library ends"),
    ],
)
def test_no_exception_is_a_broken_law(error: BaseException, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert console.status_of("verb", lambda: fail(error)) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("verb: error: ")
    assert re.search(said, line)


def test_a_library_that_fails_as_it_is_imported_is_no_bug(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As numpy.f2py does where SOURCE_DATE_EPOCH is no number."""
    (tmp_path / "odd_library.py").write_text("int('x')\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert console.status_of("verb", lambda: bool(import_module("odd_library"))) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "odd_library.py " in line
    assert console.DEBUG not in line


def fail(error: BaseException) -> NoReturn:
    raise error


def test_the_traceback_of_a_bug_is_shown_on_request(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(console.DEBUG, "1")
    assert console.status_of("verb", lambda: fail(ZeroDivisionError())) == 2
    assert "in fail" in capsys.readouterr().err


def test_a_progress_bar_starts_no_thread() -> None:
    """Where no more threads are allowed, the library would warn about it on stderr."""
    code = "import threading; from lie_rigid_body.system.console import progress as bar; bar(unit='B')"
    code += "; print(threading.active_count())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (found.stdout, found.stderr) == ("1\n", "")
