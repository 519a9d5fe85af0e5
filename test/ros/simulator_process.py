"""The node as its own process, and a client as another; ended by their process ids, waited for with deadlines."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from threading import Event, Thread
from types import TracebackType

DEADLINE = 60.0
"""s: far beyond what a loaded machine takes; only a failure waits as long."""
LAST_LINE = "Ctrl-C ends it."
CLIENT = Path(__file__).with_name("stream_client.py")
RAW_CLIENT = Path(__file__).with_name("raw_client.py")


def sim_command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "lie_rigid_body", "sim", *arguments]


class SimulatorProcess:
    """A running ``sim``; leaving the context kills it if it still runs."""

    def __init__(self, *arguments: str, preexec: Callable[[], None] | None = None) -> None:
        self.process = subprocess.Popen(
            sim_command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=preexec
        )
        self.said: list[str] = []
        self.complained: list[str] = []
        self._running = Event()
        self._readers = [
            Thread(target=self._read, args=(stream, lines), daemon=True)
            for stream, lines in ((self.process.stdout, self.said), (self.process.stderr, self.complained))
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, stream: object, lines: list[str]) -> None:
        for line in stream:  # type: ignore[attr-defined]
            lines.append(line.rstrip("\n"))
            if line.rstrip("\n") == LAST_LINE:
                self._running.set()
        if lines is self.said:
            self._running.set()  # it ended

    def __enter__(self) -> SimulatorProcess:
        assert self._running.wait(DEADLINE), "sim did not start"
        assert self.process.poll() is None, self.complained
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.kill()
        self.wait()

    def end(self, *numbers: signal.Signals) -> int:
        """Send signals one after the other, and return the exit status."""
        for number in numbers:
            self.process.send_signal(number)
        return self.wait()

    def end_impatiently(self, *numbers: signal.Signals) -> int:
        """Send the signals over and over until the process has ended, and return the exit status."""
        end = time.monotonic() + DEADLINE
        for number in cycle(numbers):
            if self.process.poll() is not None or time.monotonic() > end:
                return self.wait()
            self.process.send_signal(number)
            time.sleep(0.002)
        raise AssertionError("no signals")

    def wait(self) -> int:
        status = self.process.wait(DEADLINE)
        for reader in self._readers:
            reader.join(DEADLINE)
        return status


def start_client(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, str(CLIENT), *arguments], stderr=subprocess.PIPE, text=True)


class RawClient:
    """A process that keeps the bytes of every message; leaving the context kills it if it still runs."""

    def __init__(self, out: Path, namespace: str, *topics: str) -> None:
        self._out = out
        command = [sys.executable, str(RAW_CLIENT), str(out), namespace, *topics]
        self._process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)

    def __enter__(self) -> RawClient:
        ready = self._out.with_name(f"{self._out.name}.ready")
        eventually(lambda: ready.exists() or self._process.poll() is not None, "a client that listens")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait(DEADLINE)

    def finish(self) -> dict[str, list[bytes]]:
        """Let what is under way arrive, and return the messages of each topic."""
        self._out.with_name(f"{self._out.name}.stop").touch()
        finish_client(self._process)
        seen: dict[str, list[bytes]] = pickle.loads(self._out.read_bytes())
        return seen


def finish_client(client: subprocess.Popen[str]) -> None:
    try:
        _, complaint = client.communicate(timeout=DEADLINE)
    finally:
        client.kill()
    assert client.returncode == 0, complaint


def cpu_seconds(pid: int) -> float:
    """What a process has used of the processors so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def eventually(condition: Callable[[], bool], what: str) -> None:
    """Wait for a condition, not for a time."""
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end, f"waited {DEADLINE:g} s for {what}"
        time.sleep(0.01)
