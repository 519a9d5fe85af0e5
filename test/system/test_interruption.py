"""The first signal decides how a process ends; a second, later, ends what closes."""

from __future__ import annotations

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from lie_rigid_body.system.console import status_of
from lie_rigid_body.system.interruption import Interruption

BEGIN = """
import atexit, signal, time
from lie_rigid_body.system import interruption as module
from lie_rigid_body.system.console import status_of
from lie_rigid_body.system.interruption import Interruption

def send(*numbers):
    for number in numbers:
        signal.raise_signal(number)

def waiting(action=lambda: time.sleep(5)):
    with Interruption.current().allowed():
        action()
    return 3

def ends_with(action, to_the_end=True):
    raise SystemExit(status_of("test", action, to_the_end=to_the_end))

INT, TERM = signal.SIGINT, signal.SIGTERM

class Last:
    def __del__(self):
        send(INT)

def destroyed():
    last = Last()
"""
PROGRAMS = {
    "one": ("ends_with(lambda: waiting(lambda: send(INT)))", 130),
    "a hangup": ("ends_with(lambda: waiting(lambda: send(signal.SIGHUP)))", 130),
    "a hangup under nohup": (
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\nends_with(lambda: waiting(lambda: send(signal.SIGHUP)))",
        3,
    ),
    "where it is noted": ("ends_with(lambda: send(INT, TERM) or 7)", 7),
    "noted before it is allowed": ("ends_with(lambda: send(TERM) or waiting())", 130),
    "the second and the third while closing": (
        """
def closing():
    try:
        return waiting(lambda: send(INT))
    finally:
        send(TERM, INT)
ends_with(closing)
""",
        130,
    ),
    "a later one while closing": (
        "module.SAME_REQUEST_S = 0.05\nends_with(lambda: send(INT) or time.sleep(0.1) or send(TERM) or 7)",
        -signal.SIGTERM,
    ),
    "a later one where no exception left the code": (
        """
module.SAME_REQUEST_S = 0.05
def lost():
    destroyed()
    time.sleep(0.1)
    send(INT)
ends_with(lambda: waiting(lost))
""",
        130,
    ),
    "amid a destructor": (
        """
def lost():
    destroyed()
    time.sleep(5)
ends_with(lambda: waiting(lost))
""",
        130,
    ),
    "amid an import": (
        """
def importing():
    import struck
    time.sleep(5)
ends_with(lambda: waiting(importing))
""",
        130,
    ),
    "while what the verb began ends": ("ends_with(lambda: atexit.register(send, INT, TERM, INT) and 7)", 7),
}
STRUCK = """
import signal
try:
    signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt:
    raise ImportError("its initialisation failed") from None  # as libraries in C do
"""


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_first_signal_decides_and_a_later_one_ends_what_closes(name: str, tmp_path: Path) -> None:
    program, status = PROGRAMS[name]
    (tmp_path / "program.py").write_text(f"{BEGIN}{program}\n")
    (tmp_path / "struck.py").write_text(STRUCK)
    command = [sys.executable, "-m", "program"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert ended.returncode == status, ended.stderr
    assert ended.stderr.splitlines() == (["test: error: interrupted"] if status == 130 else [])


def test_handlers_are_again_what_they_were_and_those_of_others_stay() -> None:
    """As ``main`` may be called in a process that lives on, and in a thread of one."""

    def own(number: int, frame: object) -> None:
        heard.append(number)

    def action() -> int:
        inside.append([signal.getsignal(number) for number in numbers])
        with Interruption.current().allowed():
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
