"""Processes that get a second signal within 60 ms after the first, and another while they close."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random

DEADLINE = 120.0
LONGEST_GAP_S = 0.06
LOST_S = 20.0
"""Time, s, after which a signal counts as lost."""
VERB = [sys.executable, "-m", "lie_rigid_body"]
PAIRS = ((signal.SIGINT, signal.SIGTERM), (signal.SIGINT, signal.SIGINT))
STRUCK = """
import sys
from lie_rigid_body.system import interruption
interruption.SAME_REQUEST_S = 10.0  # a loaded machine may stand still for a second between two signals
from lie_rigid_body.__main__ import main
sys.exit(main())
"""
STRUCK_WITHOUT_NUMBA = "import sys; sys.modules['numba'] = None" + STRUCK


def heeds_signals(process: int) -> bool:
    """Whether a process is past the first line of its entry point: Python alone does not handle SIGTERM."""
    status = Path(f"/proc/{process}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught.split()[1], 16) >> signal.SIGTERM - 1 & 1)


def started(command: Sequence[str | Path], folder: Path, stderr: int = -1) -> subprocess.Popen[str]:
    """A process that heeds signals, and has begun nothing else."""
    process = subprocess.Popen(command, cwd=folder, stdout=-1, stderr=stderr, text=True)
    end = time.monotonic() + DEADLINE
    while not heeds_signals(process.pid):
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.0005)
    return process


def struck(
    command: Sequence[str | Path], folder: Path, random: Random, longest_s: float, pair: Sequence[signal.Signals]
) -> tuple[int, str, str]:
    """Status, stdout and stderr of a process that gets two signals at a random moment of its set-up and work."""
    process = started(command, folder)
    try:
        for number, wait in zip(
            pair, (random.uniform(0.0, longest_s), random.uniform(0.0, LONGEST_GAP_S)), strict=True
        ):
            time.sleep(wait)
            with suppress(ProcessLookupError):
                process.send_signal(number)
        try:
            out, err = process.communicate(timeout=LOST_S)
        except subprocess.TimeoutExpired:  # amid a library in C that was imported
            process.send_signal(pair[0])
            out, err = process.communicate(timeout=DEADLINE)
    finally:
        process.kill()
    return process.returncode, out, err


def ended_by_the_second(process: subprocess.Popen[str], numbers: Sequence[signal.Signals]) -> int:
    """Status of a process that closes for ever: it outlives the first signal, and those that come within a second."""
    *first, last = numbers
    for number in first:
        process.send_signal(number)
    time.sleep(0.1)
    assert process.poll() is None
    end = time.monotonic() + DEADLINE
    while process.poll() is None and time.monotonic() < end:
        time.sleep(1.1)  # later ones end it, wherever a loaded machine took the first
        process.send_signal(last)
    return process.wait(1.0)


@contextmanager
def full_pipe() -> Iterator[int]:
    """A pipe in which there is no room: who has something to say into it closes for ever.

    Afterwards nobody reads it, which ends them; until then they may hold the other pipes of their parent open.
    """
    read, write = os.pipe()
    fill(write)
    try:
        yield write
    finally:
        os.close(read)
        os.close(write)


def fill(pipe: int) -> None:
    """Write into a pipe until there is no room for a byte."""
    flags = fcntl.fcntl(pipe, fcntl.F_GETFL)
    fcntl.fcntl(pipe, fcntl.F_SETFL, flags | os.O_NONBLOCK)
    with suppress(BlockingIOError):
        while True:
            os.write(pipe, bytes(4096))
    with suppress(BlockingIOError):
        while True:
            os.write(pipe, b"\0")
    fcntl.fcntl(pipe, fcntl.F_SETFL, flags)
