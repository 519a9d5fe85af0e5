"""Statistics of errors: their size, when an estimate has converged, and whether they keep limits.

Limits are written on a command line as ``1deg``, or ``10s:2deg`` from a time on.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import numbers, quantity
from lie_rigid_body.evaluation.attitudes import AttitudeError
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.lie import vectors

MIN_LIMIT: Final = 1e-3
"""Least default limit of convergence, degrees."""
MAX_SETTLED_DEG: Final = 20.0
"""Largest total error of an estimate that has converged, degrees, unless a larger limit is given."""
UNITS: Final = {
    "an angle such as 1deg": {"deg": 1.0, "°": 1.0, "rad": 180.0 / np.pi, "mrad": 0.18 / np.pi},
    "a time such as 10s": {"ms": 1e-3, "s": 1.0, "min": 60.0},
}
"""Units in which limits and times may be written, each in degrees or in seconds."""
MIN_SHARE: Final = 0.5
"""Least share that must be compared for a limit to be kept: of the given estimates, and of the time in which they are
due."""


@short_dataclass
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

    @classmethod
    def of(cls, errors: Array) -> Statistics:
        """Compute the statistics of errors in order of time, shape (N,) with N ≥ 1, all finite."""
        median, p95 = np.percentile(errors, [50.0, 95.0])
        return cls(rms(errors), float(median), float(p95), float(errors.max()), float(errors[-1]))


def rms(errors: Array) -> float:
    """Root mean square; scaled by the largest value, so that tiny errors do not underflow."""
    largest = float(np.abs(errors).max(initial=0.0))
    return largest * math.sqrt(np.mean((errors / largest) ** 2)) if largest else 0.0


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
        If there are not three numbers in each row, or one is not finite.
    """
    off = numbers("estimate", estimate, 3) - numbers("truth", truth, 3)
    return Statistics.of(vectors.norm(off).reshape(-1))


def largest_of_second_half(t_s: Array, errors: Array) -> float:
    """Largest error of the second half of a run: what an estimate settles to."""
    return float(errors[t_s >= 0.5 * (t_s[0] + t_s[-1])].max())


def settling_limit(settled_deg: float) -> float:
    """Limit of `time_to_converge` where none is given: one and a half times the largest error of the second half.

    Steady noise hardly ever exceeds it, so the time tells when the error came down to what it is later, whatever that
    is. It is at least `MIN_LIMIT` and at most `MAX_SETTLED_DEG`, degrees.
    """
    return min(max(1.5 * settled_deg, MIN_LIMIT), MAX_SETTLED_DEG)


def time_to_converge(t_s: Array, errors: Array, limit: float) -> float | None:
    """Time, s, from the first sample to the first one from which on the error never exceeds a limit.

    Parameters
    ----------
    t_s, errors : ndarray, shape (N,)
        Times in s, increasing, and errors. One that is NaN counts as above the limit.
    limit : float
        In the unit of the errors.

    Returns
    -------
    float or None
        None if the last error is above the limit, or there is none.
    """
    above = np.flatnonzero(~(errors <= limit))
    first = int(above[-1]) + 1 if above.size else 0
    return float(t_s[first] - t_s[0]) if first < len(errors) else None


@short_dataclass
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
        If a limit is not finite or not above 0, or a time is not finite or below 0. No error, or every error, would
        break such a limit.
    """

    max_rms_deg: float | None = None
    max_after: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if self.max_rms_deg is not None:
            quantity("max_rms_deg", self.max_rms_deg, "degrees", "max_rms_deg=1.0")
        try:
            pairs = tuple((start, limit) for start, limit in self.max_after)
        except (TypeError, ValueError):
            raise InputError(
                f"max_after: {shown(self.max_after)} is not pairs of s and degrees: give for example ((10.0, 2.0),)"
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
        return cls(
            None if max_rms is None else in_unit(max_rms, "an angle such as 1deg"),
            tuple(_after(pair) for pair in (max_after if isinstance(max_after, list | tuple) else [max_after])),
        )


def _after(text: str) -> tuple[float, float]:
    time, colon, angle = text.partition(":") if isinstance(text, str) else (text, "", "")
    if not colon:
        raise InputError(f"{shown(text)} is not a time and an angle: give for example 10s:2deg")
    return in_unit(time, "a time such as 10s"), in_unit(angle, "an angle such as 1deg")


def in_unit(text: str, wanted: str) -> float:
    """Read a number with one of the units of what is wanted, a key of `UNITS`.

    Raises
    ------
    InputError
        If it is none, or is infinite.
    """
    number = r"\s*(\+?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D*?)\s*"
    match = re.fullmatch(number, text, re.ASCII) if isinstance(text, str) else None
    units = UNITS[wanted]
    if not match or match[2] not in units or np.isinf(float(match[1])):
        raise InputError(f"{shown(text)} is not {wanted}: give a number and one of {', '.join(units)}")
    return float(match[1]) * units[match[2]]


class Tally:
    """Number, RMS and largest error of all samples so far, and the limits that they break.

    Parameters
    ----------
    limits : Limits

    Attributes
    ----------
    count : int
    largest_deg : ndarray, shape (3,)
        Largest total, heading and inclination error, degrees.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.count = 0
        self._squares = np.zeros(3)
        self.largest_deg = np.zeros(3)
        self._first_ns = self._last_ns = 0
        self._worst = [(0.0, -np.inf) for _ in limits.max_after]

    def add(self, stamps_ns: Integers, error: AttitudeError) -> None:
        """Take samples that come next: at least one, with their errors, rad."""
        angles_deg = np.degrees(np.stack(error))
        self._first_ns = self._first_ns if self.count else int(stamps_ns[0])
        self._last_ns = int(stamps_ns[-1])
        self.count += len(stamps_ns)
        self._squares += np.sum(angles_deg**2, axis=1)
        self.largest_deg = np.maximum(self.largest_deg, angles_deg.max(axis=1))
        t_s = (stamps_ns - self._first_ns) / 1e9
        for number, (start, _) in enumerate(self.limits.max_after):
            late_deg = np.where(t_s >= start, angles_deg[0], -np.inf)
            largest = np.argmax(late_deg)
            if late_deg[largest] > self._worst[number][1]:  # of as large ones the first counts
                self._worst[number] = float(t_s[largest]), float(late_deg[largest])

    @property
    def span_s(self) -> float:
        """Time from the first sample to the last, s."""
        return (self._last_ns - self._first_ns) / 1e9

    @property
    def rms_deg(self) -> Array:
        """RMS of the total, heading and inclination error, degrees, shape (3,)."""
        return np.sqrt(self._squares / max(self.count, 1))

    def broken(self, given: int = 0, due_ns: int | None = None) -> Iterator[str]:
        """Sentences about the limits that the samples so far break, one for each, and about too few to keep any.

        Parameters
        ----------
        given : int, optional
            Number of estimates that were given, at least half of which are to have been compared; 0: any share will do.
        due_ns : int, optional
            The stamp until which they are due.
        """
        rms_deg = self.rms_deg[0]
        most_deg = self.limits.max_rms_deg
        span_s = self.span_s
        if most_deg is not None and rms_deg > most_deg:
            yield f"the error is {rms_deg:.4g}° rms, above the limit of {most_deg:g}°"
        for (start, limit), (at_s, worst_deg) in zip(self.limits.max_after, self._worst, strict=True):
            if worst_deg == -np.inf:
                yield f"the estimate ends at {span_s:g} s, before the limit after {start:g} s begins"
            elif worst_deg > limit:
                yield f"the error is {worst_deg:.4g}° at {at_s:g} s, above the limit of {limit:g}° after {start:g} s"
        due_s = 0.0 if due_ns is None else (due_ns - self._first_ns) / 1e9
        enough = "were compared: limits hold for at least half of them"
        is_limited = self.limits != Limits()
        if is_limited and self.count < MIN_SHARE * given:
            yield f"only {self.count} of {given} estimates {enough}"
        if is_limited and span_s < MIN_SHARE * due_s:
            yield f"only {span_s:.4g} of {due_s:.4g} s since the first estimate {enough}"
