"""Processes that run a filter, so that it may be run on every core, hang, and die."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from threading import Event, Timer, get_ident
from typing import Any, Final, TypeVar

from lie_rigid_body.diagnosis.filter import Filter, FilterError, Source
from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import Estimator

T = TypeVar("T")
Job = Callable[[Filter], T]

_BEGUN: Final = "begun"
_HUNG: Final = "look for an endless loop, or give more --timeout"
_SERVE: Final = "import sys; sys.path[:] = {}; from lie_rigid_body.diagnosis.workers import serve; serve()"


class Alone:
    """Jobs done in this process, one after the other.

    Parameters
    ----------
    estimate : callable
    begun : callable
        Called before each run of the filter.
    """

    def __init__(self, estimate: Estimator, begun: Callable[[], object]) -> None:
        self._filter = Filter(estimate, begun)

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        for job in jobs:
            try:
                yield job(self._filter)
            except FilterError as error:
                yield error

    def close(self) -> None:
        """End nothing: there are no processes."""


class Workers:
    """Jobs done by processes; one that hangs or dies is ended, and another takes its place.

    They are new interpreters, no copies of this one: nothing of the user's main module is run again, on any platform.

    Parameters
    ----------
    source : Source
        Where they find the filter.
    count : int
        Number of processes.
    timeout_s : float
        Longest time of one run of the filter, s.
    begun : callable
        Called before each run of the filter, by threads.
    """

    def __init__(self, source: Source, count: int, timeout_s: float, begun: Callable[[], object]) -> None:
        self._source, self._timeout_s, self._begun = source, timeout_s, begun
        self._threads = ThreadPoolExecutor(count)
        self._of_thread: dict[int, subprocess.Popen[bytes]] = {}
        self._closed = False

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        futures: list[Future[T | FilterError]] = [self._threads.submit(self._do, job) for job in jobs]
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

    def _do(self, job: Job[Any]) -> Any:
        """The result of a job by the process of this thread; an error that is not the filter's is raised."""
        late = Event()
        process = self._of_thread.get(get_ident()) or self._started()
        try:
            _send(process.stdin, job)
            while (answer := self._answer(process, late)) == _BEGUN:
                self._begun()
        except (EOFError, OSError, pickle.UnpicklingError):
            self._of_thread.pop(get_ident(), None)
            _end(process)
            if late.is_set():
                return FilterError(f"the filter did not return within {self._timeout_s:g} s: {_HUNG}")
            return FilterError(f"the filter ended its process, status {process.returncode}: run it alone to see why")
        if isinstance(answer, BaseException) and not isinstance(answer, FilterError):
            raise answer
        return answer

    def _started(self) -> subprocess.Popen[bytes]:
        if self._closed:
            raise CancelledError
        process = subprocess.Popen(
            [sys.executable, "-c", _SERVE.format(repr(sys.path))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends its processes
        )
        self._of_thread[get_ident()] = process
        _send(process.stdin, self._source)
        return process

    def _answer(self, process: subprocess.Popen[bytes], late: Event) -> Any:
        """The next answer of a process, which is ended if none comes in time."""

        def end() -> None:
            late.set()
            process.kill()

        timer = Timer(self._timeout_s, end)
        timer.daemon = True
        timer.start()
        try:
            return pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        finally:
            timer.cancel()


def _send(stream: Any, item: object) -> None:
    pickle.dump(item, stream)
    stream.flush()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and close its streams."""
    process.kill()
    with suppress(OSError):
        process.communicate()


def serve() -> None:
    """Do the jobs that come on standard input until it ends; what the filter prints goes nowhere."""
    jobs, results = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)

    with suppress(EOFError):
        source: Source = pickle.load(jobs)
        loaded: Filter | None = None
        while True:
            job: Job[Any] = pickle.load(jobs)
            try:
                loaded = loaded or Filter(source.load(), lambda: _send(results, _BEGUN))
                _send(results, job(loaded))
            except Exception as error:
                _send(results, error if isinstance(error, InputError) else RuntimeError(repr(error)))
