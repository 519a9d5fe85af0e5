"""Other Python interpreters, which may hang or die: bags are judged, runs carried out and estimators called there."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from itertools import islice
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from threading import Thread, Timer
from typing import Any, BinaryIO, Final, TypeVar

from lie_rigid_body.foundation.errors import FilterError, LieRigidBodyError, describe
from lie_rigid_body.system.console import DEBUG
from lie_rigid_body.system.interruption import Interruption

R = TypeVar("R")
T = TypeVar("T")

STARTING_S: Final = 20.0
"""Shortest time that a process has to start and to import what it is asked to call, s."""


class Interpreter:
    """Python interpreter in another process, which calls a function when asked, and replies with its pickled result.

    It starts when it is asked, and anew where it has ended. It is new, no copy of this one: nothing of the user's main
    module is run again, on any platform. It ends with this one, and where nothing refers to it any more; what it put
    into its folder of temporary files goes with it.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: TemporaryDirectory[str] | None = None
        self._is_closed = False

    @property
    def is_running(self) -> bool:
        """Whether it was started, and is not known to have ended."""
        return self._process is not None

    def ask(self, question: Callable[[], object], limit_s: float) -> Any:
        """Ask, and return the reply; an error of this package that is raised there is raised here.

        Raises
        ------
        TimeoutError, EOFError
            If it has not replied in so many seconds, or has ended, with its status. Then it is ended.
        FilterError
            If another exception is raised there.
        """
        asked = pickle.dumps(question)
        folder = self._folder = self._folder or TemporaryDirectory(ignore_cleanup_errors=True)
        if self._process is None:
            self._process = subprocess.Popen(
                [
                    sys.executable,
                    "-c",
                    f"import sys; sys.path[:] = {sys.path!r}; sys.argv = {sys.argv[:1]!r}; "  # for `console.program`
                    f"from {__name__} import serve; serve()",
                ],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=None if os.environ.get(DEBUG) else subprocess.DEVNULL,
                env={**os.environ, "TMPDIR": folder.name},
                start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends what it began
            )
        process = self._process
        if self._is_closed:  # meanwhile
            self.kill()
        end_s = time.monotonic() + limit_s
        timer = Timer(limit_s, self.kill)
        timer.start()
        try:
            _send(process.stdin, pickle.dumps(asked))
            reply = pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except Exception:  # what else came through the pipe fails in many ways
            is_late = time.monotonic() >= end_s
            self.end()
            if is_late:
                raise TimeoutError(f"did not return within {limit_s:g} s") from None
            raise EOFError(f"ended its process, status {process.returncode}") from None
        finally:
            timer.cancel()
        if isinstance(reply, LieRigidBodyError):
            raise reply
        return reply

    def kill(self) -> None:
        """Kill it, and what it started."""
        if self._process is not None:
            kill_all(self._process)

    def close(self) -> None:
        """Kill it, and at once any that would be started in its place."""
        self._is_closed = True
        self.kill()

    def end(self) -> None:
        """Kill it and close its streams."""
        self.kill()
        if self._process is not None:
            with suppress(OSError):
                self._process.communicate()
            self._process = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def __del__(self) -> None:
        self.end()


class Interpreters:
    """Interpreters that work side by side; one that hangs or dies is ended, and another takes its place.

    Parameters
    ----------
    count : int
    """

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count)
        self._all = [Interpreter() for _ in range(count)]
        self._idle = SimpleQueue[Interpreter]()
        for each in self._all:
            self._idle.put(each)

    def map(self, do: Callable[[Interpreter, T], R], items: Iterable[T]) -> Iterator[R]:
        """Results of a function, in the order of the items: each call gets an idle interpreter and an item."""
        futures = [self._submitted(do, item) for item in items]
        return (future.result() for future in futures)

    def completed(self, do: Callable[[Interpreter, T], R], items: Iterable[T]) -> Iterator[R]:
        """Results of a function as they come; few items are taken ahead of the interpreters that are idle."""
        waiting = iter(items)
        pending: set[Future[R]] = set()
        while True:
            ahead = islice(waiting, 2 * len(self._all) - len(pending))
            pending |= {self._submitted(do, item) for item in ahead}
            if not pending:
                return
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            yield from (future.result() for future in done)

    def _submitted(self, do: Callable[[Interpreter, T], R], item: T) -> Future[R]:
        # an exception as a thread starts would hide that thread from `close`
        with Interruption.current().noted() as interruption:
            future = self._threads.submit(self._with_idle, do, item)
        interruption.heed()
        return future

    def _with_idle(self, do: Callable[[Interpreter, T], R], item: T) -> R:
        interpreter = self._idle.get()
        try:
            return do(interpreter, item)
        finally:
            self._idle.put(interpreter)

    def close(self) -> None:
        """End all of them, at once."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for each in self._all:
            each.close()
        self._threads.shutdown()
        for each in self._all:
            each.end()


@contextmanager
def guarded(process: subprocess.Popen[Any]) -> Iterator[None]:
    """Context at whose end a process that leads a session is killed, with what it started.

    Should this process itself be killed meanwhile, a shell that waits for that ends them.
    """
    guard = None
    try:
        if hasattr(os, "killpg"):
            with suppress(OSError):
                guard = subprocess.Popen(
                    # kills a group of processes as soon as nobody can write to it
                    ["/bin/sh", "-c", 'read -r _; kill -9 "-$1"', "sh", str(process.pid)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )
        yield
    finally:
        kill_all(process)
        if guard is not None:  # before the number of the process is free for others
            guard.kill()
            guard.communicate()
        process.wait()


def kill_all(process: subprocess.Popen[Any]) -> None:
    """Kill a process that leads a session of its own, and what it started, which may hold its pipes open."""
    with suppress(OSError):
        _kill_session(process.pid)
        process.kill()


def _kill_session(leader: int) -> None:
    """Kill all processes of a leader's session, where a system has such; 0 is the own."""
    if hasattr(os, "killpg"):
        os.killpg(leader, signal.SIGKILL)


def serve() -> None:
    """Call what this process is asked, and reply what it returns or raises; what it prints goes nowhere."""
    asked = os.fdopen(os.dup(0), "rb")
    replies = os.fdopen(os.dup(1), "wb")
    waiting = SimpleQueue[bytes]()
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    Thread(target=_hear, args=(asked, waiting), daemon=True).start()
    own = os.getpid()
    while True:
        try:
            reply = pickle.dumps(pickle.loads(waiting.get())())
        except BaseException as error:  # of what was called: no Ctrl-C of a terminal comes here
            reply = pickle.dumps(error if isinstance(error, LieRigidBodyError) else FilterError(describe(error)))
        if os.getpid() != own:  # a copy that a function has made, whose reply would be that to the next question
            os._exit(1)
        _send(replies, reply)


def _hear(asked: BinaryIO, waiting: SimpleQueue[bytes]) -> None:
    """Take what is asked until the one that asks has ended; then end this process, hung or not, and what it started.

    It is unpickled in the main thread: a module that is imported for it may hang.
    """
    try:
        while True:
            waiting.put(pickle.load(asked))
    finally:
        _kill_session(0)
        os._exit(1)


def _send(stream: Any, pickled: bytes) -> None:
    """Write into a stream at once."""
    stream.write(pickled)
    stream.flush()
