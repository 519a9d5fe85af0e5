"""Other Pythons that are asked to call functions, each a real process."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.system.console import program
from lie_rigid_body.system.interpreters import Interpreter

LIMIT_S = 60.0
WITH_PROC = pytest.mark.skipif(not Path("/proc").is_dir(), reason="there is no /proc")
HANGING = """
import os, threading, time
from functools import partial
from lie_rigid_body.system.interpreters import Interpreter

other = Interpreter()
print(other.ask(os.getpid, 60.0), flush=True)
other.ask(partial(time.sleep, 600.0), 600.0)
"""
IMPORTING = """
from lie_rigid_body.system.interpreters import Interpreter
import slow

Interpreter().ask(slow.answer, 600.0)
"""
SLOW = """
import os, sys, time
from pathlib import Path

def answer():
    pass

if "lie_rigid_body.system.interpreters" in sys.modules and sys.argv == ["-c"] and os.getpid() == os.getsid(0):
    Path(__file__).with_name("pid").write_text(f"{os.getpid()}.")
    time.sleep(600.0)
"""
GUARDING = """
import subprocess, time
from lie_rigid_body.system.interpreters import guarded

program = subprocess.Popen(["/bin/sh", "-c", "sleep 600 & echo begun; sleep 600"], start_new_session=True)
with guarded(program):
    print("guarded", flush=True)
    time.sleep(600.0)
"""


@pytest.mark.slow
def test_reply_is_what_the_function_returns_or_raises():
    other = Interpreter()
    try:
        assert not other.is_running
        first = other.ask(os.getpid, LIMIT_S)
        assert first == other.ask(os.getpid, LIMIT_S) != os.getpid()
        with pytest.raises(FilterError, match="ValueError"):
            other.ask(partial(int, "three"), LIMIT_S)
        with pytest.raises(FilterError, match=_made_here.__name__):
            other.ask(_made_here, LIMIT_S)
        assert first == other.ask(os.getpid, LIMIT_S)
        with pytest.raises(FilterError, match="SystemExit: enough"):
            other.ask(partial(sys.exit, "enough"), LIMIT_S)
        assert other.ask(partial(print, "nowhere"), LIMIT_S) is None
        with pytest.raises(EOFError, match=r"^ended its process, status 3$"):
            other.ask(partial(os._exit, 3), LIMIT_S)
        assert not other.is_running
        assert other.ask(os.getpid, LIMIT_S) != first
        with pytest.raises(TimeoutError, match=r"^did not return within 0.5 s$"):
            other.ask(partial(time.sleep, 600.0), 0.5)
        with pytest.raises(InputError, match="of the package"):
            other.ask(partial(_raise, "of the package"), LIMIT_S)
    finally:
        other.end()


def test_what_else_comes_than_a_reply_ends_the_process():
    other, garbage = Interpreter(), "arbage garbage"
    code = f"import os\nfor fd in range(3, 50):\n try: os.write(fd, {garbage.encode()!r})\n except OSError: pass"
    with pytest.raises(EOFError):
        other.ask(partial(exec, code), LIMIT_S)
    assert not other.is_running


def _made_here():
    return lambda: "what another process does not find"


def _raise(words):
    raise InputError(words)


def leave_a_file():
    """The name of a file that is left in the folder of temporary files."""
    handle, name = tempfile.mkstemp()
    os.close(handle)
    return name


@WITH_PROC
def test_process_that_nobody_can_ask_any_more_is_ended():
    other = Interpreter()
    status = Path("/proc", str(other.ask(os.getpid, LIMIT_S)), "stat")
    del other
    _wait_for_end(status)


@pytest.mark.slow
@pytest.mark.parametrize("is_late", [True, False])
def test_temporary_files_of_a_process_go_with_it(tmp_path, monkeypatch, is_late):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    interpreter = Interpreter()
    assert Path(interpreter.ask(leave_a_file, 60.0)).is_relative_to(tmp_path)
    if is_late:
        with pytest.raises(TimeoutError):
            interpreter.ask(partial(time.sleep, 1000.0), 0.01)
    else:
        interpreter.end()
    assert [*tmp_path.iterdir()] == []


@WITH_PROC
def test_process_that_hangs_ends_with_the_one_that_asked():
    asking = subprocess.Popen([sys.executable, "-c", HANGING], stdout=subprocess.PIPE, text=True)
    assert asking.stdout is not None
    status = Path("/proc", asking.stdout.readline().strip(), "stat")
    asking.kill()
    asking.communicate()
    _wait_for_end(status)


@WITH_PROC
@pytest.mark.parametrize("kill", [subprocess.Popen.kill, subprocess.Popen.terminate])
def test_process_that_is_amid_an_import_ends_with_the_one_that_asked(tmp_path, kill):
    """It takes no notice of its pipes meanwhile."""
    (tmp_path / "slow.py").write_text(SLOW)
    asking, told = subprocess.Popen([sys.executable, "-c", IMPORTING], cwd=tmp_path), tmp_path / "pid"
    while not told.is_file() or not told.read_text().endswith("."):
        assert asking.poll() is None
        time.sleep(0.01)
    kill(asking)
    asking.communicate()
    _wait_for_end(Path("/proc", told.read_text().strip("."), "stat"))


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="there are no groups of processes")
def test_a_program_ends_with_what_it_started_where_its_process_is_killed(tmp_path):
    """All hold one end of a pipe, which is read to its end."""
    asking = subprocess.Popen([sys.executable, "-c", GUARDING], stdout=subprocess.PIPE)
    assert asking.stdout is not None
    assert {asking.stdout.readline() for _ in range(2)} == {b"begun\n", b"guarded\n"}
    asking.kill()
    assert asking.communicate()[0] == b""


def _wait_for_end(status):
    """Wait until a process is no more, or a zombie; its file may be gone at any moment."""
    with suppress(FileNotFoundError, ProcessLookupError):
        while status.read_text().split()[2] != "Z":
            time.sleep(0.01)


def test_a_command_has_the_name_of_the_installation_that_asks(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/opt/ws/lib/lie_rigid_body/check", "a.mcap"])
    assert Interpreter().ask(partial(program, "recover"), 20.0) == "ros2 run lie_rigid_body recover"
