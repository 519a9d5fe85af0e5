"""Estimated attitudes beside the truth at their stamps, with the errors that they have."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import (
    AttitudeError,
    Truth,
    angles,
    angles_between,
    period_ns,
    relative_rotations,
)
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

SPIN: Final = 0.9
"""Squared length of the mean axis of rotation above which a body turns about one axis."""
MIN_SAMPLES: Final = 20
"""Least number of samples whose quarters tell anything."""
WINDOW: Final = 0.2
"""Turn of the body, rad, in a window over which angles are compared: it outweighs noise, and is short beside a flip."""
MAX_LAGS: Final = 200
"""Largest number of lags that are tried in either direction."""
MIN_KNOWN: Final = 0.5
"""Smallest share of the windows that a lag puts within the truth's times."""
SAMPLES: Final = 400
"""Largest number of samples by which errors are explained."""
NEGLIGIBLE: Final = math.radians(1e-3)
"""Error that needs no explanation, rad; a smaller one counts as this."""


@short_dataclass(eq=False)
class Matched:
    """Attitudes that were estimated, beside the truth.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Stamps, ns.
    attitude_xyzw : ndarray, shape (N, 4)
        World-from-body, scalar last, of unit norm.
    truth : Truth
        The true attitude at any stamp.
    origin_ns : int, optional
        Stamp at which a clock of another rate was right, ns; by default the first of the whole track.
    is_level : bool
        Whether the total error is that of the vertical, as of an estimate without a heading.
    """

    stamps_ns: Integers
    attitude_xyzw: Array
    truth: Truth
    origin_ns: int | None = None
    is_level: bool = False

    @property
    def origin(self) -> int:
        """Stamp at which a clock of another rate was right, ns."""
        return int(self.stamps_ns[0]) if self.origin_ns is None else self.origin_ns

    @property
    def since_s(self) -> Array:
        """Times since the origin, s, shape (N,)."""
        return (self.stamps_ns - self.origin) / 1e9

    def __getitem__(self, chosen: slice | Integers | Booleans) -> Matched:
        """Some of the samples."""
        stamps = self.stamps_ns[chosen]
        attitude = self.attitude_xyzw[chosen]
        return replace(self, stamps_ns=stamps, attitude_xyzw=attitude, origin_ns=self.origin)

    def fraction(self, begin: float = 1.0 / 3.0, end: float = 1.0) -> Matched:
        """The samples from one share of their number to another; by default those after which a filter has settled."""
        count = len(self.stamps_ns)
        return self[slice(int(count * begin), int(count * end))]

    def thinned(self, most: int = 40) -> Matched:
        """At most so many of the samples, evenly spread over all."""
        return self[spread(len(self.stamps_ns), most)]

    def known(self) -> Matched:
        """The samples at whose stamps the truth is known."""
        return self[self.truth.covers(self.stamps_ns)]

    @cached_property
    def rates(self) -> Array:
        """True body rates at the stamps, rad/s, shape (N, 3)."""
        return self.truth.states(self.stamps_ns)[1]

    @cached_property
    def truth_xyzw(self) -> Array:
        """True attitudes at the stamps, shape (N, 4)."""
        return self.truth.at(self.stamps_ns)

    def error(self) -> AttitudeError:
        """Error angles of each sample, shape (N,) each, rad."""
        error = angles(quaternion.multiply(self.attitude_xyzw, quaternion.conjugate(self.truth_xyzw)))
        return error._replace(total=error.inclination) if self.is_level else error

    def differences(self, other: Matched) -> Array:
        """Angles to other attitudes, sample by sample while both go on, rad."""
        both = min(len(self.stamps_ns), len(other.stamps_ns))
        return angles_between(self.attitude_xyzw[:both], other.attitude_xyzw[:both])

    def max_difference(self, other: Matched) -> float:
        """Largest of these differences, rad."""
        return float(np.max(self.differences(other)))

    def turn_ratio(self) -> float:
        """Turn of the estimate from sample to sample about the axis of the true one, as a multiple of that."""
        estimated, true = (relative_rotations(q[:-1], q[1:]) for q in (self.attitude_xyzw, self.truth_xyzw))
        return float(np.sum(estimated * true) / np.sum(true * true))

    def partial_errors(self) -> tuple[float, float]:
        """RMS of the error of the vertical, and of that of the turns over a tenth of the samples, rad."""
        step = max(1, len(self.stamps_ns) // 10)
        wrong, right = (
            quaternion.exp(relative_rotations(q[:-step], q[step:])) for q in (self.attitude_xyzw, self.truth_xyzw)
        )
        return rms(self.error().inclination), rms(angles_between(wrong, right))


MatchedRuns = Sequence[Matched]


def spread(count: int, most: int) -> Integers:
    """Indices of at most so many samples, evenly spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def error_of(tracks: MatchedRuns) -> float:
    """RMS of the total error over all samples of tracks, rad."""
    return rms(np.concatenate([track.error().total for track in tracks]))


def products(track: Matched, stamps_ns: Integers) -> Array:
    """Products q_i p_j of all components of the true quaternion q, at some stamps, and the estimate p, (..., N, 16)."""
    q = track.truth.at(stamps_ns)
    p = track.attitude_xyzw
    return (q[..., :, np.newaxis] * p[:, np.newaxis, :]).reshape(*q.shape[:-1], 16)


def valleys(values: Array) -> Integers:
    """Indices of the local minima of some values, the lowest first."""
    around = np.concatenate([[np.inf], values, [np.inf]])
    lowest = np.flatnonzero((values <= around[:-2]) & (values <= around[2:]))
    return lowest[np.argsort(values[lowest], kind="stable")]


def lags_of_rates(track: Matched, longest_s: float, most: int = 150) -> list[float]:
    """Lags of an estimate up to the longest, s, at which it turns as fast as the body does, the likeliest first.

    A constant turn of the world or of the body changes no angle between two attitudes of the estimate. Most other
    conventions do not either, so the lag is found before they are known. Angles over windows in which the body turns by
    `WINDOW` are compared. A lag must leave less than a quarter of the variance of these angles.
    """
    truth = track.truth
    rate = max(rms(norm(track.thinned(most).rates)), 1e-9)
    width = max(1, round(WINDOW / rate * 1e9 / max(period_ns(track.stamps_ns), 1)))
    if len(track.stamps_ns) < MIN_SAMPLES + width:
        return []
    first = spread(len(track.stamps_ns) - width, most)
    ends = np.stack([first, first + width])
    own = angles_between(*track.attitude_xyzw[ends])
    step_s = max(0.25 * WINDOW / rate, longest_s / MAX_LAGS)
    lags_s = np.arange(-longest_s, longest_s + step_s, step_s)
    stamps = track.stamps_ns[ends] - np.round(lags_s * 1e9).astype(np.int64)[:, np.newaxis, np.newaxis]
    known = truth.covers(stamps).all(axis=1)
    true = np.moveaxis(truth.at(np.clip(stamps, truth.first_ns, truth.last_ns)), 1, 0)
    missed = np.sum((angles_between(*true) - own) ** 2, axis=1, where=known) / np.maximum(known.sum(axis=1), 1)
    misfit = np.where(known.mean(axis=1) >= MIN_KNOWN, missed, np.inf)
    return [float(lags_s[k]) for k in valleys(misfit) if misfit[k] < 0.25 * np.var(own)]


def quarters(track: Matched) -> Array:
    """Mean of sin² of half of the error in each quarter but the first, shape (3,)."""
    return np.array([np.mean(np.sin(0.5 * errors) ** 2) for errors in np.array_split(track.error().total, 4)[1:]])


def floored(left: Array) -> Array:
    """Mean sin² of half of the error left in each quarter, raised to that of `NEGLIGIBLE` where it is less."""
    return np.asarray(np.maximum(left, np.sin(0.5 * NEGLIGIBLE) ** 2))


def constant_attitude_misfit(truth_xyzw: Array) -> float:
    """Mean of sin² of half of the error of a constant attitude."""
    return 1.0 - float(np.linalg.eigvalsh(truth_xyzw.T @ truth_xyzw)[-1]) / len(truth_xyzw)


def is_single_axis(rate: Array, least: float = SPIN) -> bool:
    """Whether a body with some rates, (N, 3), turns about one axis: so do errors of a gyro."""
    axes = rate / np.maximum(norm(rate), 1e-300)[:, np.newaxis]
    return bool(np.sum(np.mean(axes, axis=0) ** 2) > least)
