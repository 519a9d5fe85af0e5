"""Estimators called in processes of their own, which may be run on every core, hang, and die; or in this one."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from threading import Event, Timer, get_ident
from typing import Any, Final, Protocol, TypeVar

import numpy as np

from lie_rigid_body.errors import InputError, LieRigidBodyError, said
from lie_rigid_body.runs.command import CommandEstimator, kill_all
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.runs.estimator_call import leaving_the_process_alone
from lie_rigid_body.runs.estimators import Estimator, estimator
from lie_rigid_body.runs.run import Run
from lie_rigid_body.wording import short_repr, shown

T = TypeVar("T")
Job = Callable[[Estimator], T]
"""What a process is to do with the estimator; it is pickled, and so is its result."""

STARTING_S: Final = 20.0
"""Least time that a process has to start and to import the estimator, s."""
_GRACE_S: Final = 2.0
_LIBRARIES: Final = ("site-packages", "dist-packages", str(Path(traceback.__file__).parent))
"""Parts of the paths of files that are not the user's."""
_SERVE: Final = "import sys; sys.path[:] = {}; from lie_rigid_body.runs.workers import serve; serve()"


class FilterError(InputError):
    """The filter raised an exception, did not return, or returned what is no estimate."""


class Source(Protocol):
    """Place at which any process of this machine finds a filter."""

    def load(self) -> Estimator:
        """The filter as a function of a run."""
        ...


@dataclass(frozen=True)
class NamedFunction:
    """A function that is found by the names of its module and its own.

    Attributes
    ----------
    name : str
        ``module:function``.
    """

    name: str

    __repr__ = short_repr

    def load(self) -> Estimator:
        """The function.

        Raises
        ------
        InputError
            If there is none.
        """
        module, _, function = self.name.partition(":")
        if not (module and function):
            raise InputError(f"estimator {shown(self.name)}: give MODULE:FUNCTION, such as my_filter:estimate")
        return estimator(self.name)

    @classmethod
    def of(cls, estimate: Estimator) -> NamedFunction | None:
        """The name of a function, or None where other processes would not find it by one."""
        module, name = getattr(estimate, "__module__", None), getattr(estimate, "__qualname__", "")
        if module in (None, "__main__") or not name.isidentifier() or sys.modules.get(module) is None:
            return None
        with suppress(Exception):
            if getattr(import_module(module), name) is estimate and sys.modules[module].__spec__ is not None:
                return cls(f"{module}:{name}")
        return None


def source_of(estimate: Estimator | str) -> Source | None:
    """Find out how other processes get at an estimator: by ``module:function``, a function's own name, or a program.

    None where they would not find it.
    """
    if isinstance(estimate, str):
        return NamedFunction(estimate)
    return estimate if isinstance(estimate, CommandEstimator) else NamedFunction.of(estimate)


def called(estimate: Estimator, run: Run) -> Estimate:
    """What an estimator returns for a run, with stamps and numbers; its warnings are nobody's.

    Raises
    ------
    FilterError
        With the line in the user's file, or with the shape.
    """
    assert run.imu is not None
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), leaving_the_process_alone():
            warnings.simplefilter("ignore")
            result = estimate(run)
    except (Exception, SystemExit) as error:
        raise FilterError(told(error)) from None
    try:
        found = Estimate.of(result)
        return found if found.t_ns is not None else replace(found, t_ns=run.imu.t_ns)
    except (TypeError, ValueError) as error:
        raise FilterError(said(error)) from None


def told(error: BaseException) -> str:
    """Say an exception of a filter with the last line of the user's own that it came through."""
    package = str(Path(__file__).resolve().parent.parent)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(package)]
    own = [frame for frame in frames if not any(part in frame.filename for part in _LIBRARIES)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in (own or frames)[-1:])
    remedy = "" if isinstance(error, LieRigidBodyError) else ": mend that first"
    return f"the filter failed, {line}{said(error)}{remedy}"


class Crew(Protocol):
    """Those who do jobs: `Alone` or `Workers`."""

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        ...

    def close(self) -> None:
        """End what was begun."""
        ...


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

    They are new interpreters, no copies of this one: nothing of the user's main module is run again, on any platform.

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
        self._of_thread: dict[int, subprocess.Popen[bytes]] = {}

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """The results of jobs in their order, of one that fails the error."""
        futures: list[Future[T | FilterError]] = [self._threads.submit(self._done, job) for job in jobs]
        try:
            for future in futures:
                yield future.result()
        finally:
            for future in futures:
                future.cancel()

    def close(self) -> None:
        """End all processes, at once."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for process in tuple(self._of_thread.values()):
            kill_all(process)
        self._threads.shutdown()
        for process in self._of_thread.values():
            _end(process)

    def _done(self, job: Job[Any]) -> Any:
        if get_ident() not in self._of_thread:
            self._of_thread[get_ident()] = _started()
            refused = self._asked(self._source, max(STARTING_S, self._timeout_s))
            if refused is not None:
                return refused
        return self._asked(job, self._timeout_s)

    def _asked(self, item: Source | Job[Any], limit_s: float) -> Any:
        """What the process of this thread replies; an error that is not the filter's is raised."""
        process, late = self._of_thread[get_ident()], Event()

        def end() -> None:
            late.set()
            kill_all(process)

        timer = Timer(limit_s, end)
        timer.start()
        try:
            _send(process.stdin, item)
            reply = pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except (EOFError, OSError, pickle.UnpicklingError):
            _end(self._of_thread.pop(get_ident()))
            if late.is_set():
                remedy = "look for an endless loop, or give more --timeout"
                return FilterError(f"the filter did not return within {limit_s:g} s: {remedy}")
            return FilterError(f"the filter ended its process, status {process.returncode}: run it alone to see why")
        finally:
            timer.cancel()
        if isinstance(reply, Exception) and not isinstance(reply, FilterError):
            raise reply
        return reply


def _started() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-c", _SERVE.format(repr(sys.path))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends what it began
    )


def _send(stream: Any, item: object) -> None:
    pickle.dump(item, stream)
    stream.flush()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and close its streams."""
    kill_all(process)
    with suppress(OSError):
        process.communicate()


def serve() -> None:
    """Load an estimator and do the jobs that come on standard input until it ends; what is printed goes nowhere."""
    jobs, results = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    estimate: Estimator | None = None
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
            _send(results, reply)
