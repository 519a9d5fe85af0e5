"""Processes that run a filter, so that it may be run on every core, hang, and die."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from queue import SimpleQueue
from threading import Timer
from typing import Any, BinaryIO, Final, TypeVar

from lie_rigid_body.diagnosis.filter import Filter, FilterError, Source
from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import Estimator

T = TypeVar("T")
Job = Callable[[Filter], T]

_BEGUN: Final = "begun"
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
        self._idle: SimpleQueue[_Process | None] = SimpleQueue()
        self._all: set[_Process] = set()
        self._threads = ThreadPoolExecutor(count)
        self._closed = False
        for _ in range(count):
            self._idle.put(None)

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
        for process in tuple(self._all):
            process.end()
        self._threads.shutdown(cancel_futures=True)

    def _do(self, job: Job[T]) -> T | FilterError:
        process = self._idle.get()
        try:
            if self._closed:
                return FilterError("the diagnosis was ended")
            if process is None:
                process = _Process(self._source)
                self._all.add(process)
            found: T | FilterError = process.do(job, self._timeout_s, self._begun)
            return found
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            assert process is not None
            return FilterError(process.how_it_ended(self._timeout_s, error))
        finally:
            alive = process is not None and process.is_alive
            if process is not None and not alive:
                process.end()
                self._all.discard(process)
            self._idle.put(process if alive else None)


class _Process:
    """One process, which is asked through its standard streams."""

    def __init__(self, source: Source) -> None:
        self._hung = False
        self._process = subprocess.Popen(
            [sys.executable, "-c", _SERVE.format(repr(sys.path))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends its processes
        )
        self._send(source)

    @property
    def is_alive(self) -> bool:
        """Whether it takes another job."""
        return not self._hung and self._process.poll() is None

    def do(self, job: Job[Any], timeout_s: float, begun: Callable[[], object]) -> Any:
        """The result of a job, or its error; any other exception of it is raised here."""
        self._send(job)
        while True:
            timer = Timer(timeout_s, self._hang)
            timer.daemon = True
            timer.start()
            try:
                answer = pickle.load(self._stream(self._process.stdout))
            finally:
                timer.cancel()
            if answer != _BEGUN:
                break
            begun()
        if isinstance(answer, BaseException) and not isinstance(answer, FilterError):
            raise answer
        return answer

    def how_it_ended(self, timeout_s: float, error: BaseException) -> str:
        """Why there is no result."""
        if self._hung:
            return f"the filter did not return within {timeout_s:g} s: look for an endless loop, or give more --timeout"
        self.end()
        return f"the filter ended its process, status {self._process.returncode}: run it alone to see why"

    def end(self) -> None:
        """End the process and close its streams."""
        with suppress(OSError):
            self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                self._stream(stream).close()

    def _hang(self) -> None:
        self._hung = True
        self._process.kill()

    def _send(self, item: object) -> None:
        stream = self._stream(self._process.stdin)
        pickle.dump(item, stream)
        stream.flush()

    @staticmethod
    def _stream(stream: Any) -> BinaryIO:
        assert stream is not None
        found: BinaryIO = stream
        return found


def serve() -> None:
    """Do the jobs that come on standard input until it ends; what the filter prints goes nowhere."""
    jobs, results = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)

    def send(item: object) -> None:
        pickle.dump(item, results)
        results.flush()

    with suppress(EOFError):
        source: Source = pickle.load(jobs)
        loaded: Filter | None = None
        while True:
            job: Job[Any] = pickle.load(jobs)
            try:
                loaded = loaded or Filter(source.load(), lambda: send(_BEGUN))
                send(job(loaded))
            except Exception as error:
                send(error if isinstance(error, InputError) else RuntimeError(repr(error)))
