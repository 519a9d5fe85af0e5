"""Statistics of an error over a run, when the error had settled, and limits to it.

Limits are written on a command line as ``1deg``, or ``10s:2deg`` from a time on.
"""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import numbers, quantity
from lie_rigid_body.lie import vectors
from lie_rigid_body.wording import short_repr, shown

SMALLEST_LIMIT: Final = 1e-3
"""Least default limit of convergence, degrees."""
Largest = tuple[float, float] | None
"""Time, s, and size, degrees, of the largest of some errors; None of no samples."""
ANGLES: Final = {"deg": 1.0, "°": 1.0, "rad": 180.0 / np.pi, "mrad": 0.18 / np.pi}
TIMES: Final = {"ms": 1e-3, "s": 1.0, "min": 60.0}
"""Units of a limit, in degrees and in seconds."""
LEAST_SHARE: Final = 0.5
"""Least share of the given estimates, and of the time in which they are due, that must be compared to keep a limit."""
_NUMBER: Final = re.compile(r"\s*(\+?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D*?)\s*")


@dataclass(frozen=True)
class Statistics:
    """Statistics of a non-negative error, in the unit of the error.

    Attributes
    ----------
    rms, median, p95, max, final : float
        Root mean square, median, 95th percentile (linear between samples), largest and last value.
    """

    rms: float
    median: float
    p95: float
    max: float
    final: float

    __repr__ = short_repr

    @classmethod
    def of(cls, errors: Array) -> Statistics:
        """Compute the statistics of errors in order of time, shape (N,) with N ≥ 1, all finite."""
        median, p95 = np.percentile(errors, [50.0, 95.0])
        return cls(rms(errors), float(median), float(p95), float(errors.max()), float(errors[-1]))

    def to_json(self) -> dict[str, float]:
        """JSON-serialisable data: the five numbers."""
        return asdict(self)


def rms(errors: Array) -> float:
    """Root mean square; scaled by the largest value, so that tiny errors do not underflow."""
    largest = float(np.abs(errors).max(initial=0.0))
    return largest * float(np.sqrt(np.mean((errors / largest) ** 2))) if largest else 0.0


def bias_error(estimate: ArrayLike, truth: ArrayLike) -> Statistics:
    """Statistics of the norm of a bias estimate's error.

    Parameters
    ----------
    estimate, truth : array_like, shape (N, 3)
        Bias estimates and true biases of the same instants, in the same unit: rad/s of a gyro, m/s² of an
        accelerometer.

    Returns
    -------
    Statistics
        In that unit.

    Raises
    ------
    InputError
        If a shape is wrong or a number is not finite.
    """
    given, true = numbers("estimate", estimate, 3), numbers("truth", truth, 3)
    if given.shape != true.shape:
        raise InputError(f"truth: shape {true.shape} is not {given.shape}: give the true bias of each estimate")
    return Statistics.of(vectors.norm(given - true).reshape(-1))


def settling_limit(t_s: Array, errors: Array) -> float:
    """Default limit of `time_to_converge`: one and a half times the largest error of the second half of the run.

    Steady noise hardly ever exceeds it, so the time tells when the error came down to what it is later.

    Parameters
    ----------
    t_s, errors : ndarray, shape (N,)
        Times in s and errors in degrees.

    Returns
    -------
    float
        Degrees, at least `SMALLEST_LIMIT`.
    """
    return max(1.5 * float(errors[t_s >= 0.5 * (t_s[0] + t_s[-1])].max()), SMALLEST_LIMIT)


def time_to_converge(t_s: Array, errors: Array, limit: float) -> float | None:
    """Time from the first sample to the first one from which on the error never exceeds a limit.

    Parameters
    ----------
    t_s, errors : ndarray, shape (N,)
        Times in s, increasing, and errors.
    limit : float
        In the unit of the errors.

    Returns
    -------
    float or None
        Seconds; None if the last error is above the limit.
    """
    above = np.flatnonzero(errors > limit)
    first = int(above[-1]) + 1 if above.size else 0
    return float(t_s[first] - t_s[0]) if first < len(errors) else None


@dataclass(frozen=True)
class Limits:
    """Limits to the total error.

    Attributes
    ----------
    max_rms_deg : float or None
        Largest RMS over the whole run, degrees, above 0.
    max_after : tuple of (float, float)
        Pairs of a time in s since the first sample, and the largest error from then on, degrees, above 0.

    Raises
    ------
    InputError
        If a limit is not finite or not above 0, or a time is not finite or below 0: no error would break it, or every
        one.
    """

    max_rms_deg: float | None = None
    max_after: tuple[tuple[float, float], ...] = ()

    __repr__ = short_repr

    def __post_init__(self) -> None:
        if self.max_rms_deg is not None:
            quantity("max_rms_deg", self.max_rms_deg, "degrees", "max_rms_deg=1.0")
        try:
            pairs = tuple((start, limit) for start, limit in self.max_after)
        except (TypeError, ValueError):
            given = shown(self.max_after)
            raise InputError(
                f"max_after: {given} is not pairs of s and degrees: give for example ((10.0, 2.0),)"
            ) from None
        for start, limit in pairs:
            quantity("max_after: time", start, "seconds", "((10.0, 2.0),)", or_zero=True)
            quantity("max_after: limit", limit, "degrees", "((10.0, 2.0),)")

    @classmethod
    def parse(cls, max_rms: str | None = None, max_after: str | tuple[str, ...] = ()) -> Limits:
        """Read limits from texts: ``max_rms="1deg"``, ``max_after="10s:2deg"`` or several of them.

        Raises
        ------
        InputError
            If a text is not an angle, or not a time, a colon and an angle.
        """
        pairs = max_after if isinstance(max_after, list | tuple) else (max_after,)
        return cls(None if max_rms is None else angle_deg(max_rms), tuple(_after(pair) for pair in pairs))


def largest(start_s: float, t_s: Array, total_deg: Array, before: Largest = None) -> Largest:
    """The time, s, and size of the first of the largest errors from a time on, `before` the samples or among them."""
    late = np.flatnonzero(t_s >= start_s)
    k = late[np.argmax(total_deg[late])] if late.size else 0
    if not late.size or (before is not None and before[1] >= total_deg[k]):
        return before
    return float(t_s[k]), float(total_deg[k])


def angle_deg(text: str) -> float:
    """Read an angle, degrees, from a text like ``1deg``, ``0.02rad`` or ``5 mrad``."""
    return _read(text, ANGLES, "an angle such as 1deg")


def time_s(text: str) -> float:
    """Read a time, s, from a text like ``10s``, ``500ms`` or ``1min``."""
    return _read(text, TIMES, "a time such as 10s")


def _after(text: str) -> tuple[float, float]:
    time, colon, angle = text.partition(":") if isinstance(text, str) else (text, "", "")
    if not colon:
        raise InputError(f"{shown(text)} is not a time and an angle: give for example 10s:2deg")
    return time_s(time), angle_deg(angle)


def _read(text: str, units: dict[str, float], wanted: str) -> float:
    match = _NUMBER.fullmatch(text) if isinstance(text, str) else None
    if not match or match[2] not in units or np.isinf(float(match[1])):
        raise InputError(f"{shown(text)} is not {wanted}: give a number and one of {', '.join(units)}")
    return float(match[1]) * units[match[2]]
