"""The filter under diagnosis: where it is found, and what it makes of readings."""

from __future__ import annotations

import sys
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.diagnosis.repairs import Repair
from lie_rigid_body.diagnosis.trial import Trial
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.causes import Track
from lie_rigid_body.evaluation.estimate import read_stamps
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.estimators import Estimator, estimator, returned
from lie_rigid_body.wording import short_repr, shown

_LIBRARIES: Final = ("site-packages", "dist-packages")
_SMALLEST_NORM: Final = 1e-12


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


@dataclass(frozen=True, eq=False)
class Answer:
    """What a filter made of a trial.

    Attributes
    ----------
    track : Track
        Its attitudes, divided by their norms; the identity where one is not finite or zero.
    broken : int
        Number of the first sample that is not finite or zero, or -1.
    largest_norm_error : float
        Largest | |q|² − 1 |.
    covariance : object
        As it was returned, or None.
    covariance_axes : str
    """

    track: Track
    broken: int
    largest_norm_error: float
    covariance: Any
    covariance_axes: str

    __repr__ = short_repr

    def between(self, begin: float, end: float) -> Track:
        """The track between two shares of its time."""
        stamps = self.track.stamps_ns
        share = (stamps - stamps[0]) / max(1, int(stamps[-1] - stamps[0]))
        return self.track.part(np.flatnonzero((share >= begin) & (share <= end)))

    def settled(self) -> Track:
        """The last two thirds."""
        return self.between(1.0 / 3.0, 1.0)


class Filter:
    """A filter that is run.

    Parameters
    ----------
    estimate : callable
    begun : callable
        Called before each run.
    """

    def __init__(self, estimate: Estimator, begun: Callable[[], object]) -> None:
        self.estimate, self._begun = estimate, begun
        self._kept = lru_cache(maxsize=32)(self._run)

    def answer(self, trial: Trial, repairs: tuple[Repair, ...] = (), *, again: bool = False) -> Answer:
        """The filter's answer to a trial whose readings are repaired; without `again` one that was given is kept.

        Raises
        ------
        FilterError
            With the line in the user's file, or with the shape.
        """
        return (self._run if again or repairs else self._kept)(trial, repairs)

    def _run(self, trial: Trial, repairs: tuple[Repair, ...]) -> Answer:
        readings = trial.readings()
        for repair in repairs:
            readings = repair.change(readings)
        run = readings.run()
        self._begun()
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                result = self.estimate(run)
        except (Exception, SystemExit) as error:
            raise FilterError(told(error)) from None
        assert run.imu is not None
        try:
            found = returned(result)
            stamps = run.imu.t_ns if found.t_ns is None else read_stamps("estimate", found.t_ns)
        except InputError as error:
            raise FilterError(str(error)) from None
        if len(stamps) != len(found.attitude_xyzw):
            raise FilterError(
                f"the filter returned attitudes of shape {found.attitude_xyzw.shape} for {len(stamps)} stamps: "
                "return a row for each reading of the IMU, or stamps and attitudes"
            )
        attitude, norms = _real(found.attitude_xyzw), quaternion.norm(_real(found.attitude_xyzw))
        bad = np.flatnonzero(~(np.isfinite(norms) & (norms > _SMALLEST_NORM)))
        attitude[bad], norms[bad] = (0.0, 0.0, 0.0, 1.0), 1.0
        return Answer(
            Track(stamps, attitude / norms[:, np.newaxis], readings.truth),
            int(bad[0]) if bad.size else -1,
            float(np.abs(norms**2 - 1.0).max(initial=0.0)),
            found.covariance,
            found.covariance_axes,
        )


def _real(attitude_xyzw: Any) -> Array:
    try:
        return np.array(attitude_xyzw, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise FilterError(f"the filter returned no numbers ({error}): return attitudes (N, 4)") from None


def told(error: BaseException) -> str:
    """Say an exception of a filter with the last line of the user's own that it came through."""
    package = str(Path(__file__).resolve().parent.parent)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(package)]
    own = [frame for frame in frames if not any(part in frame.filename for part in _LIBRARIES)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in (own or frames)[-1:])
    return f"the filter failed, {line}{type(error).__name__}: {error}: mend that first"
