"""Jobs done with an estimator, in processes of their own, which run on every core, hang, and die; or in this one."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Timer, get_ident
from typing import Any, BinaryIO, Final, TypeVar

from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import CommandEstimator, Estimator, FilterError, Source, kill_all

T = TypeVar("T")
Job = Callable[[Estimator], T]
"""What a process is to do with the estimator; it is pickled, and so is its result."""

STARTING_S: Final = 20.0
"""Least time that a process has to start and to import the estimator, s."""
_GRACE_S: Final = 2.0
_SERVE: Final = "import sys; sys.path[:] = {}; from lie_rigid_body.runs.workers import serve; serve()"


class Alone:
    """Jobs done in this process, one after the other.

    Parameters
    ----------
    estimate : callable
    """

    def __init__(self, estimate: Estimator) -> None:
        self._estimate = estimate

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        for job in jobs:
            try:
                yield job(self._estimate)
            except FilterError as error:
                yield error

    def close(self) -> None:
        """End nothing: there are no processes."""


class Workers:
    """Jobs done by processes; one that hangs or dies is ended, and another takes its place.

    Parameters
    ----------
    source : Source
        Where they find the estimator.
    count : int
        Number of processes.
    timeout_s : float
        Longest time of one job, s.
    """

    def __init__(self, source: Source, count: int, timeout_s: float) -> None:
        # a program is ended by its estimator, which says more
        self._source, self._timeout_s = source, timeout_s + _GRACE_S * isinstance(source, CommandEstimator)
        self._threads = ThreadPoolExecutor(count)
        self._of_thread: dict[int, Interpreter] = {}

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        return self._threads.map(self._done, jobs)

    def close(self) -> None:
        """End all processes, at once."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for process in tuple(self._of_thread.values()):
            process.kill()
        self._threads.shutdown()
        for process in self._of_thread.values():
            process.end()

    def _done(self, job: Job[Any]) -> Any:
        """What the process of this thread makes of a job, or why it makes nothing of it."""
        thread = get_ident()
        try:
            if thread not in self._of_thread:
                self._of_thread[thread] = Interpreter("-c", _SERVE.format(repr(sys.path)))
                self._of_thread[thread].ask(self._source, max(STARTING_S, self._timeout_s))
            return self._of_thread[thread].ask(job, self._timeout_s)
        except FilterError as error:
            return error
        except TimeoutError as error:
            fault = f"did not return within {error}: look for an endless loop, or give more --timeout"
        except EOFError as error:
            fault = f"ended its process, {error}: run it alone to see why"
        del self._of_thread[thread]
        return FilterError(f"the filter {fault}")


class Interpreter:
    """Another Python, which is asked something, and replies, by what can be pickled.

    It is new, no copy of this one: nothing of the user's main module is run again, on any platform.

    Parameters
    ----------
    *arguments : str
        Its command line, of a program that takes its `questions`.
    """

    def __init__(self, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends what it began
        )

    def ask(self, question: object, limit_s: float) -> Any:
        """Ask, and return the reply; an exception that it replies is raised.

        Raises
        ------
        TimeoutError, EOFError
            If it has not replied in so many seconds, or has ended, with its status. Then it is ended.
        """
        end, timer = time.monotonic() + limit_s, Timer(limit_s, self.kill)
        timer.start()
        try:
            send(self._process.stdin, question)
            reply = pickle.load(self._process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except (EOFError, OSError, pickle.UnpicklingError):
            is_late = time.monotonic() >= end
            self.end()
            if is_late:
                raise TimeoutError(f"{limit_s:g} s") from None
            raise EOFError(f"status {self._process.returncode}") from None
        finally:
            timer.cancel()
        if isinstance(reply, Exception):
            raise reply
        return reply

    def kill(self) -> None:
        """Kill it, and what it started."""
        kill_all(self._process)

    def end(self) -> None:
        """Kill it and close its streams."""
        self.kill()
        with suppress(OSError):
            self._process.communicate()


def questions() -> tuple[BinaryIO, BinaryIO]:
    """The streams of what this process is asked, and of its replies; what it prints goes nowhere from now on."""
    asked, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    return asked, replies


def send(stream: Any, item: object) -> None:
    """Pickle something into a stream at once."""
    pickle.dump(item, stream)
    stream.flush()


def serve() -> None:
    """Load an estimator and do the jobs that this process is asked for, until its standard input ends."""
    (jobs, replies), estimate = questions(), None
    with suppress(EOFError):
        while True:
            asked: Any = pickle.load(jobs)
            reply: Any = None
            try:
                if estimate is None:
                    estimate = asked.load()
                else:
                    reply = asked(estimate)
            except Exception as error:
                reply = error if isinstance(error, InputError) else RuntimeError(repr(error))
            send(replies, reply)
