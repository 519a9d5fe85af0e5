"""The node as its own process, and a client as another; ended by their process ids, waited for with deadlines."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from threading import Event, Thread
from types import TracebackType

DEADLINE = 120.0
"""s: far beyond what a loaded machine takes; only a failure waits as long."""
LAST_LINE = "Ctrl-C ends it."
CATCHING_UP = "late, catching up"
"""Words of the log about what is the machine's."""
RAW_CLIENT = Path(__file__).with_name("raw_client.py")


WITHOUT = """
import sys
sys.modules |= dict.fromkeys({libraries})  # None: what Python itself writes there for a module that is not to be found
from lie_rigid_body.__main__ import main
sys.argv.insert(1, "sim")
sys.exit(main())
"""


def sim_command(*arguments: str, without: Sequence[str] = ()) -> list[str]:
    """The command line of the node, with some libraries as if they were not installed."""
    start = ["-c", WITHOUT.format(libraries=without)] if without else ["-m", "lie_rigid_body", "sim"]
    return [sys.executable, *start, *arguments]


def assignments(**values: object) -> list[str]:
    """The arguments that assign parameters."""
    return [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]


def without_lateness(complained: Iterable[str]) -> list[str]:
    """Lines of stderr but for those of being late, which is the machine's."""
    return [line for line in complained if CATCHING_UP not in line]


class SimulatorProcess:
    """A running ``sim``; leaving the context kills it if it still runs."""

    def __init__(
        self,
        *arguments: str,
        domain: int | None = None,
        preexec: Callable[[], None] | None = None,
        without: Sequence[str] = (),
        program: Sequence[str] = (),
    ) -> None:
        self.domain = int(os.environ["ROS_DOMAIN_ID"]) if domain is None else domain
        self.process = subprocess.Popen(
            [sys.executable, *program, *arguments] if program else sim_command(*arguments, without=without),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "ROS_DOMAIN_ID": str(self.domain)},
            preexec_fn=preexec,
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

    def errors(self) -> list[str]:
        """What it complained of, but for being late, which is the machine's."""
        return without_lateness(self.complained)

    def end(self, *numbers: signal.Signals) -> int:
        """Send signals one soon after the other, and return the exit status."""
        for number in numbers:
            self.process.send_signal(number)
            time.sleep(0.002)
        return self.wait()

    def wait(self) -> int:
        status = self.process.wait(DEADLINE)
        for reader in self._readers:
            reader.join(DEADLINE)
        return status


class RawClient:
    """A process that keeps the bytes of every message; leaving the context kills it if it still runs."""

    def __init__(self, out: Path, namespace: str, *topics: str) -> None:
        self._out = out
        command = [sys.executable, str(RAW_CLIENT), str(out), namespace, *topics]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self._heard = Event()
        self._reader = Thread(target=self._wait_until_heard, daemon=True)

    def _wait_until_heard(self) -> None:
        assert self._process.stdout is not None
        self._process.stdout.readline()  # or it ended
        self._heard.set()

    def __enter__(self) -> RawClient:
        self._reader.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait(DEADLINE)
        self._reader.join(DEADLINE)

    def meet(self, send: Callable[[], object]) -> None:
        """Have the node send until each topic has been heard: only what is sent from then on is sure to come."""

        def sent_and_heard() -> bool:
            send()
            return self._heard.is_set()

        eventually(sent_and_heard, "a client that hears all topics")
        self._reader.join(DEADLINE)
        assert self._process.poll() is None, self._process.stderr

    def finish(self, last_ns: Mapping[str, int]) -> dict[str, list[bytes]]:
        """The messages of each topic, when the last have come."""
        try:
            _, complaint = self._process.communicate(json.dumps(last_ns), timeout=DEADLINE)
        finally:
            self._process.kill()
        assert self._process.returncode == 0, complaint
        seen: dict[str, list[bytes]] = pickle.loads(self._out.read_bytes())
        return seen


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
