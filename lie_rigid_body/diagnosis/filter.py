"""The filter under diagnosis: where it is found, and what it answers to readings."""

from __future__ import annotations

import sys
import traceback
import warnings
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.diagnosis.course import Course
from lie_rigid_body.diagnosis.repairs import Repair
from lie_rigid_body.errors import InputError, said
from lie_rigid_body.evaluation.attitude_error import SMALLEST_NORM
from lie_rigid_body.evaluation.estimate import read_stamps
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.estimators import Estimator, estimator, returned
from lie_rigid_body.wording import short_repr, shown

_LIBRARIES: Final = ("site-packages", "dist-packages", str(Path(traceback.__file__).parent))
"""Parts of the paths of files that are not the user's."""


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


class Job(NamedTuple):
    """One run of the filter: a course whose readings are repaired."""

    course: Course
    repairs: tuple[Repair, ...] = ()


@dataclass(frozen=True, eq=False)
class Answer:
    """What a filter made of a course.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    attitude_xyzw : ndarray, shape (N, 4)
        Its attitudes, divided by their norms; the identity where one is not finite or zero.
    broken : ndarray of int64
        Numbers of the samples that are not finite or zero.
    norm_error : float
        Largest | |q|² − 1 |.
    covariance : object
        As it was returned, or None.
    covariance_axes : str
    """

    stamps_ns: Integers
    attitude_xyzw: Array
    broken: Integers
    norm_error: float
    covariance: Any
    covariance_axes: str

    __repr__ = short_repr


def answer(estimate: Estimator, job: Job) -> Answer:
    """Run a filter.

    Raises
    ------
    FilterError
        With the line in the user's file, or with the shape.
    """
    readings = job.course.readings()
    for repair in job.repairs:
        readings = repair.change(readings)
    run = readings.run()
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            result = estimate(run)
    except (Exception, SystemExit) as error:
        raise FilterError(_told(error)) from None
    assert run.imu is not None
    try:
        found = returned(result)
        stamps = run.imu.t_ns if found.t_ns is None else read_stamps("estimate", found.t_ns)
        attitude = np.array(found.attitude_xyzw, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise FilterError(said(error)) from None
    if len(stamps) != len(attitude):
        raise FilterError(
            f"the filter returned attitudes of shape {attitude.shape} for {len(stamps)} stamps: "
            "return a row for each reading of the IMU, or stamps and attitudes"
        )
    norms = quaternion.norm(attitude)
    broken = np.flatnonzero(~(np.isfinite(norms) & (norms > SMALLEST_NORM)))
    attitude[broken], norms[broken] = (0.0, 0.0, 0.0, 1.0), 1.0
    norm_error = float(np.abs(norms**2 - 1.0).max(initial=0.0))
    unit = attitude / norms[:, np.newaxis]
    return Answer(stamps, unit, broken, norm_error, found.covariance, found.covariance_axes)


def _told(error: BaseException) -> str:
    """An exception with the last line of the user's own that it came through."""
    package = str(Path(__file__).resolve().parent.parent)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(package)]
    own = [frame for frame in frames if not any(part in frame.filename for part in _LIBRARIES)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in (own or frames)[-1:])
    return f"the filter failed, {line}{type(error).__name__}: {error}: mend that first"
