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
from threading import Thread
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing_extensions import Self

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


class Process:
    """A Python process whose lines are kept; leaving the context kills it if it still runs."""

    def __init__(self, *command: str, domain: int | None = None, preexec: Callable[[], None] | None = None) -> None:
        self.domain = int(os.environ["ROS_DOMAIN_ID"]) if domain is None else domain
        self.process = subprocess.Popen(
            [sys.executable, *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "ROS_DOMAIN_ID": str(self.domain)},
            preexec_fn=preexec,
        )
        self.said: list[str] = []
        self.complained: list[str] = []
        streams = (self.process.stdout, self.said), (self.process.stderr, self.complained)
        self._readers = [Thread(target=self._read, args=pair, daemon=True) for pair in streams]
        for reader in self._readers:
            reader.start()

    @staticmethod
    def _read(stream: Any, lines: list[str]) -> None:
        for line in stream:
            lines.append(line.rstrip("\n"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.kill()
        self.wait()

    def wait(self) -> int:
        status = self.process.wait(DEADLINE)
        for reader in self._readers:
            reader.join(DEADLINE)
        return status

    def heard(self, word: str) -> bool:
        assert self.process.poll() is None, self.complained
        return any(word in line for line in self.complained)


class SimulatorProcess(Process):
    """A running ``sim``, or a program that does the same."""

    def __init__(self, *arguments: str, without: Sequence[str] = (), program: Sequence[str] = (), **given: Any) -> None:
        command = [*program, *arguments] if program else sim_command(*arguments, without=without)[1:]
        super().__init__(*command, **given)

    def __enter__(self) -> Self:
        eventually(lambda: LAST_LINE in self.said or self.process.poll() is not None, "a simulator")
        assert self.process.poll() is None, self.complained
        return self

    def errors(self) -> list[str]:
        """What it complained of, but for being late, which is the machine's."""
        return without_lateness(self.complained)

    def end(self, *numbers: signal.Signals) -> int:
        """Send signals one soon after the other, and return the exit status."""
        for number in numbers:
            self.process.send_signal(number)
            time.sleep(0.002)
        return self.wait()


class RawClient(Process):
    """A process that keeps the bytes of every message."""

    def __init__(self, out: Path, *topics: str) -> None:
        self._out = out
        super().__init__(str(RAW_CLIENT), str(out), *topics)

    def meet(self, send: Callable[[], object]) -> None:
        """Have the node send until each topic has been heard: only what is sent from then on is sure to come."""

        def sent_and_heard() -> bool:
            send()
            return bool(self.said)

        eventually(sent_and_heard, "a client that hears all topics")

    def finish(self, last_ns: Mapping[str, int]) -> dict[str, list[bytes]]:
        """The messages of each topic, when the last have come."""
        assert self.process.stdin is not None
        print(json.dumps(last_ns), file=self.process.stdin, flush=True)
        assert self.wait() == 0, self.complained
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
