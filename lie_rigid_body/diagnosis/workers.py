"""Processes that run a filter, so that it may be run on every core, hang, and die."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from threading import Event, Timer, get_ident
from typing import Any, Final

from lie_rigid_body.diagnosis.filter import Answer, FilterError, Job, Source, answer
from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import Estimator

STARTING_S: Final = 20.0
"""Least time that a process has to start and to import the filter, s."""
_SERVE: Final = "import sys; sys.path[:] = {}; from lie_rigid_body.diagnosis.workers import serve; serve()"


class Alone:
    """Runs in this process, one after the other.

    Parameters
    ----------
    estimate : callable
    """

    def __init__(self, estimate: Estimator) -> None:
        self._estimate = estimate

    def each(self, jobs: Sequence[Job]) -> Iterator[Answer | FilterError]:
        """The answers to jobs in their order, to one that fails the error."""
        for job in jobs:
            try:
                yield answer(self._estimate, job)
            except FilterError as error:
                yield error

    def close(self) -> None:
        """End nothing: there are no processes."""


class Workers:
    """Runs in processes; one that hangs or dies is ended, and another takes its place.

    They are new interpreters, no copies of this one: nothing of the user's main module is run again, on any platform.

    Parameters
    ----------
    source : Source
        Where they find the filter.
    count : int
        Number of processes.
    timeout_s : float
        Longest time of one run of the filter, s.
    """

    def __init__(self, source: Source, count: int, timeout_s: float) -> None:
        self._source, self._timeout_s = source, timeout_s
        self._threads = ThreadPoolExecutor(count)
        self._of_thread: dict[int, subprocess.Popen[bytes]] = {}
        self._closed = False

    def each(self, jobs: Sequence[Job]) -> Iterator[Answer | FilterError]:
        """The answers to jobs in their order, to one that fails the error."""
        futures: list[Future[Answer | FilterError]] = [self._threads.submit(self._answer, job) for job in jobs]
        try:
            for future in futures:
                yield future.result()
        finally:
            for future in futures:
                future.cancel()

    def close(self) -> None:
        """End all processes, at once."""
        self._closed = True
        for process in tuple(self._of_thread.values()):
            process.kill()
        self._threads.shutdown(cancel_futures=True)
        for process in self._of_thread.values():
            _end(process)

    def _answer(self, job: Job) -> Answer | FilterError:
        if get_ident() not in self._of_thread:
            self._start()
            refused = self._asked(self._source, max(STARTING_S, self._timeout_s))
            if refused is not None:
                return refused
        found = self._asked(job, self._timeout_s)
        assert found is not None
        return found

    def _asked(self, item: Source | Job, limit_s: float) -> Answer | FilterError | None:
        """What the process of this thread replies; an error that is not the filter's is raised."""
        process, late = self._of_thread[get_ident()], Event()

        def end() -> None:
            late.set()
            process.kill()

        timer = Timer(limit_s, end)
        timer.start()
        try:
            _send(process.stdin, item)
            reply: Answer | Exception | None = pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except (EOFError, OSError, pickle.UnpicklingError):
            _end(self._of_thread.pop(get_ident()))
            if late.is_set():
                remedy = "look for an endless loop, or give more --timeout"
                return FilterError(f"the filter did not return within {limit_s:g} s: {remedy}")
            return FilterError(f"the filter ended its process, status {process.returncode}: run it alone to see why")
        finally:
            timer.cancel()
        if isinstance(reply, Answer | FilterError) or reply is None:
            return reply
        raise reply

    def _start(self) -> None:
        if self._closed:
            raise CancelledError
        self._of_thread[get_ident()] = subprocess.Popen(
            [sys.executable, "-c", _SERVE.format(repr(sys.path))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends its processes
        )


def _send(stream: Any, item: object) -> None:
    pickle.dump(item, stream)
    stream.flush()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and close its streams."""
    process.kill()
    with suppress(OSError):
        process.communicate()


def serve() -> None:
    """Load the filter and run it as asked on standard input until that ends; what it prints goes nowhere."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    estimate: Estimator | None = None
    with suppress(EOFError):
        while True:
            asked: Any = pickle.load(requests)
            reply: Answer | Exception | None = None
            try:
                if estimate is None:
                    estimate = asked.load()
                else:
                    reply = answer(estimate, asked)
            except Exception as error:
                reply = error if isinstance(error, InputError) else RuntimeError(repr(error))
            _send(replies, reply)
