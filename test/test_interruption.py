"""A signal that is handled does not decide how the process ends."""

from __future__ import annotations

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from lie_rigid_body.console import status_of

BEGIN = """
import os, signal
from lie_rigid_body.console import status_of
from lie_rigid_body.interruption import Interruption
FROM_A_STRING = "os.kill(os.getpid(), signal.SIGINT); import time; time.sleep(5)"
"""
WITH_INTERRUPTION = """
def main():
    with Interruption() as interruption:
        try:
            with interruption.allowed():
                exec(FROM_A_STRING)
        except KeyboardInterrupt:
            return 7
"""
WITHOUT = """
def main():
    return status_of("test", lambda: exec(FROM_A_STRING))
"""


IMPATIENT = """
from lie_rigid_body import interruption as module

def main():
    # another signal, while the code from a string runs that clears CPython's note of the one before
    module.exec = lambda text: exec("signal.raise_signal(signal.SIGINT)")
    interruption = Interruption()
    interruption.install()
    signal.raise_signal(signal.SIGINT)
    try:
        with interruption.allowed():
            pass
    except KeyboardInterrupt:
        return 7
"""


@pytest.mark.parametrize(("body", "status"), [(WITH_INTERRUPTION, 7), (WITHOUT, 130), (IMPATIENT, 7)])
def test_a_signal_in_code_from_a_string_ends_the_process_as_any_other(body: str, status: int, tmp_path: Path):
    """As while a library is imported."""
    (tmp_path / "program.py").write_text(f"{BEGIN}{body}\nraise SystemExit(main())\n")
    command = [sys.executable, "-m", "program"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == status, ended.stderr


HANGUP = """
import signal, sys
from lie_rigid_body.interruption import Interruption
signal.signal(signal.SIGHUP, getattr(signal, sys.argv[1]))
with Interruption() as interruption:
    signal.raise_signal(signal.SIGHUP)
raise SystemExit(7 if interruption.requested else 0)
"""


@pytest.mark.parametrize(("before", "status"), [("SIG_DFL", 7), ("SIG_IGN", 0)])
def test_a_hangup_is_heeded_unless_nohup_said_otherwise(before: str, status: int) -> None:
    ended = subprocess.run([sys.executable, "-c", HANGUP, before], check=False)
    assert ended.returncode == status


PUT_OFF = """
import signal
from lie_rigid_body.interruption import Interruption, put_off
with Interruption() as interruption:
    try:
        with interruption.allowed():
            with put_off():
                signal.raise_signal(signal.SIGTERM)
                print("whole")
            print("not interrupted")
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_what_is_put_off_interrupts_at_the_end() -> None:
    ended = subprocess.run([sys.executable, "-c", PUT_OFF], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines() == ["whole", "interrupted"]


def test_handlers_are_again_what_they_were_and_those_of_others_stay() -> None:
    """As ``main`` may be called in a process that lives on, and in a thread of one."""

    def own(number: int, frame: object) -> None:
        heard.append(number)

    def action() -> int:
        inside.append([signal.getsignal(number) for number in numbers])
        signal.raise_signal(signal.SIGHUP)
        signal.raise_signal(signal.SIGTERM)
        return 0

    heard: list[int] = []
    inside: list[list[object]] = []
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, own)
    before = [signal.getsignal(number) for number in numbers]
    assert status_of("test", lambda: status_of("test", action)) == 130
    assert [signal.getsignal(number) for number in numbers] == before
    assert heard == [signal.SIGHUP]
    assert inside[0][1] not in before

    signal.signal(signal.SIGTERM, own)
    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(status_of, "test", lambda: 3).result() == 3
    assert status_of("test", action) == 0
    assert heard == [signal.SIGHUP, signal.SIGHUP, signal.SIGTERM]
