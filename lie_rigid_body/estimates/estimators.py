"""Estimators: functions of a run that return an estimate, by name, and the processes that call them in many runs."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np

from lie_rigid_body.estimates.programs import ProgramEstimator, time_limit
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.foundation.errors import PACKAGE_FOLDER, FilterError, InputError, LieRigidBodyError, describe
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics import State
from lie_rigid_body.runs.run import Run
from lie_rigid_body.system.interpreters import STARTING_S, Interpreter, Interpreters

T = TypeVar("T")
Estimator: TypeAlias = Callable[[Run], Any]
Job = Callable[[Estimator], T]
"""Work to be done with an estimator; it is pickled for another process, and so is its result."""

CORRECT_IT: Final = "correct it"
"""Remedy at the end of an error line about an estimator that cannot be imported."""
_STANDARD: Final = f"{Path(traceback.__file__).parent}{os.sep}"
"""Folder of the standard library, in which installed packages have one of their own."""
_GRACE_S: Final = 2.0
"""Time that a program has beyond its own limit, s: its estimator ends it, and says more."""


def told(error: BaseException) -> str:
    """Words for an exception of a filter, with the last line of the user's own code on its way.

    Of an installed filter that is the first line outside of this package. What this package says of an answer, with no
    such line, stands alone.
    """
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith((PACKAGE_FOLDER, "<"))]
    installed = [frame for frame in frames if "-packages" in frame.filename]
    own = [frame for frame in frames if frame not in installed and not frame.filename.startswith(_STANDARD)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in own[-1:] or installed[:1])
    said = describe(error)
    if isinstance(error, LieRigidBodyError):
        return f"the filter failed, {line}{said}" if line else said
    remedy = "correct that first"
    if "read-only" in said:
        remedy = "a run's arrays are read only: take a copy"
    if isinstance(error, AttributeError) and error.obj is None and error.name in State.__slots__:
        remedy = "the truth is withheld: estimate from what run.imu and run.magnetometer read"
    return f"the filter failed, {line}{said}: {remedy}"


def called(estimate: Estimator, run: Run, settled_s: float) -> Estimate:
    """Call an estimator with a run; return its estimate with stamps, and ignore its warnings.

    Parameters
    ----------
    estimate : callable
    run : Run
    settled_s : float
        Time since the run's first stamp from which on errors count, s.

    Raises
    ------
    FilterError
        With the line in the user's file, or with the shape; or if no attitude is of the time that counts.
    """
    stamps_ns = run.sensors["imu"].t_ns if "imu" in run.sensors else run.t_ns
    begin_ns = run.t_ns[0]  # before an estimator may change it
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            found = Estimate.of(estimate(run))  # what is returned may run code of its own where it is read
        found = found if found.t_ns is not None else replace(found, t_ns=stamps_ns)
    except (Exception, SystemExit) as error:
        raise FilterError(told(error)) from None
    if found.t_ns[-1] < begin_ns + 1e9 * settled_s:
        raise FilterError(f"no attitude after {settled_s:.3g} s: return a row for each reading of the IMU")
    return found


@short_dataclass
class NamedFunction:
    """A function that any process of this machine finds by the names of its module and its own.

    Attributes
    ----------
    name : str
        ``module:function``.
    """

    name: str

    def load(self) -> Estimator:
        """The function, in a module of the working directory or one that is installed.

        Raises
        ------
        InputError
            If there is no such module or function.
        """
        module, _, function = self.name.partition(":")
        if not (module and function) or module.endswith(".py"):
            raise InputError(f"estimator {shown(self.name)}: give MODULE:FUNCTION, such as my_filter:estimate")
        if os.getcwd() not in sys.path:
            sys.path.append(os.getcwd())  # an executable has its own folder there, not where it was started
        what = f"estimator {shown(self.name)}"
        try:
            found: Estimator | None = getattr(import_module(module), function, None)
        except (Exception, SystemExit) as error:
            raise InputError(f"{what} cannot be imported: {describe(error)}: {CORRECT_IT}") from None
        if not callable(found):
            raise InputError(f"{what}: {shown(module)} has no function {shown(function)}: define it there")
        return found


Source: TypeAlias = NamedFunction | ProgramEstimator
"""Place at which any process of this machine finds an estimator: its method ``load`` gives it."""


def source_of(estimate: Estimator | str) -> Source | None:
    """Find out how other processes get at an estimator: by ``module:function``, a function's own name, or a program.

    None where they would not find it.
    """
    if isinstance(estimate, str):
        return NamedFunction(estimate)
    if isinstance(estimate, ProgramEstimator):
        return estimate
    module = getattr(estimate, "__module__", None)
    name = getattr(estimate, "__qualname__", "")
    if module in (None, "__main__") or not name.isidentifier() or sys.modules.get(module) is None:
        return None
    with suppress(Exception):
        if getattr(import_module(module), name) is estimate and sys.modules[module].__spec__ is not None:
            return NamedFunction(f"{module}:{name}")
    return None


def each_alone(estimate: Estimator, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
    """Results of jobs that are done in this process, in their order; for a job that fails its error."""
    for job in jobs:
        try:
            yield job(estimate)
        except FilterError as error:
            yield error


class Workers(Interpreters):
    """Jobs done by processes.

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
        self._source = source
        grace_s = _GRACE_S * isinstance(source, ProgramEstimator)
        self._timeout_s = time_limit(timeout_s) + grace_s
        super().__init__(count)

    def each(self, jobs: Sequence[Job[T]]) -> Iterator[T | FilterError]:
        """Results of jobs in their order; for a job that fails its error."""
        return self.map(self._done, jobs)

    def _done(self, process: Interpreter, job: Job[Any]) -> Any:
        """Result of a job in a process, or the error by which it fails."""
        try:
            if not process.is_running:
                process.ask(partial(_with_estimator, self._source), max(STARTING_S, self._timeout_s))
            return process.ask(partial(_with_estimator, self._source, job), self._timeout_s)
        except FilterError as error:
            return error
        except TimeoutError as error:
            return FilterError(f"the filter {error}: look for an endless loop, or give more --timeout")
        except EOFError as error:
            return FilterError(f"the filter {error}: run it alone to see why")


def _with_estimator(source: Source, job: Job[object] = lambda estimate: None) -> object:
    """Result of a job with the estimator, which is imported for the first job."""
    return job(source.load())
