"""Limits that a score must keep, as written on a command line: ``1deg``, ``10s:2deg``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import quantity
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.wording import short_repr, shown

Largest = tuple[float, float] | None
"""Time, s, and size, degrees, of the largest of some errors; None of no samples."""
ANGLES: Final = {"deg": 1.0, "°": 1.0, "rad": 180.0 / np.pi, "mrad": 0.18 / np.pi}
TIMES: Final = {"ms": 1e-3, "s": 1.0, "min": 60.0}
"""Units of a limit, in degrees and in seconds."""
LEAST_SHARE: Final = 0.5
"""Least share of the given estimates, and of the time in which they are due, that must be compared to keep a limit."""
_NUMBER: Final = re.compile(r"\s*(\+?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D*?)\s*", re.ASCII)


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

    def broken(self, t_s: Array, total_deg: Array) -> tuple[str, ...]:
        """Sentences about the limits that a run breaks, one for each.

        Parameters
        ----------
        t_s : ndarray, shape (N,)
            Time since the first sample, s.
        total_deg : ndarray, shape (N,)
            Total error, degrees.
        """
        worst = [largest(start, t_s, total_deg) for start, _ in self.max_after]
        return self.broken_by(rms(total_deg), worst, float(t_s[-1]))

    def broken_by(self, rms_deg: float, worst: Sequence[Largest], end_s: float) -> tuple[str, ...]:
        """Sentences about the limits that the facts of a run break, one for each.

        Parameters
        ----------
        rms_deg : float
            Of the total error, degrees.
        worst : sequence of (float, float) or None
            For each of `max_after` the time, s, and size, degrees, of the largest error from then on; None if there is
            no sample.
        end_s : float
            Time of the last sample since the first, s.
        """
        sentences = []
        if self.max_rms_deg is not None and rms_deg > self.max_rms_deg:
            sentences.append(f"the error is {rms_deg:.4g}° rms, above the limit of {self.max_rms_deg:g}°")
        for (start, limit), found in zip(self.max_after, worst, strict=True):
            if found is None:
                sentences.append(f"the estimate ends at {end_s:g} s, before the limit after {start:g} s begins")
            elif found[1] > limit:
                when = f"at {found[0]:g} s, above the limit of {limit:g}° after {start:g} s"
                sentences.append(f"the error is {found[1]:.4g}° {when}")
        return tuple(sentences)

    def too_little(self, compared: int, given: int, span_s: float, due_s: float) -> tuple[str, ...]:
        """Sentences about what was too little to keep any limit: estimates, and time; none without a limit.

        Parameters
        ----------
        compared, given : int
            Estimates.
        span_s, due_s : float
            Times from the first of those compared to the last, and until which they are due, s.
        """
        if self == Limits():
            return ()
        sentences = []
        if compared < LEAST_SHARE * given:
            sentences.append(
                f"only {compared} of {given} estimates were compared: limits hold for at least half of them"
            )
        if span_s < LEAST_SHARE * due_s:
            sentences.append(
                f"only {span_s:.4g} of {due_s:.4g} s since the first estimate were compared: limits hold for at least "
                "half of them"
            )
        return tuple(sentences)


def largest(start_s: float, t_s: Array, total_deg: Array, before: Largest = None) -> Largest:
    """The time, s, and size of the first of the largest errors from a time on, `before` the samples or among them."""
    late = np.flatnonzero(t_s >= start_s)
    k = late[np.argmax(total_deg[late])] if late.size else 0
    if not late.size or (before is not None and before[1] >= total_deg[k]):
        return before
    return float(t_s[k]), float(total_deg[k])


def angle_deg(text: str) -> float:
    """Read an angle, degrees, from a text like ``1deg``, ``0.02rad`` or ``5 mrad``, above 0."""
    angle = _quantity(text, ANGLES, "an angle such as 1deg")
    if angle == 0.0:
        raise InputError(f"{text!r} is a limit that every error breaks: give an angle above 0, such as 1deg")
    return angle


def time_s(text: str) -> float:
    """Read a time, s, from a text like ``10s``, ``500ms`` or ``1min``."""
    return _quantity(text, TIMES, "a time such as 10s")


def _after(text: str) -> tuple[float, float]:
    time, colon, angle = text.partition(":") if isinstance(text, str) else (text, "", "")
    if not colon:
        raise InputError(f"{shown(text)} is not a time and an angle: give for example 10s:2deg")
    return time_s(time), angle_deg(angle)


def _quantity(text: str, units: dict[str, float], wanted: str) -> float:
    match = _NUMBER.fullmatch(text) if isinstance(text, str) else None
    if not match or match[2] not in units:
        raise InputError(f"{shown(text)} is not {wanted}: give a number and one of {', '.join(units)}")
    value = float(match[1]) * units[match[2]]
    if not np.isfinite(value):
        raise InputError(f"{text!r} is too large: give {wanted}")
    return value
