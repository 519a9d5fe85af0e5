"""The time lag of an estimate, its standard error, and whether it is one or what slow errors feign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.attitudes import sizes, turns
from lie_rigid_body.evaluation.causes import BY_CODE, Part, Track, fit, undone, weights
from lie_rigid_body.evaluation.naming import BOTH, LEAD, NEGLIGIBLE, Explanation, spread
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

SAMPLES: Final = 4000
"""Largest number of samples that the lag is fitted to."""
SIGNIFICANT: Final = 3.0
"""Largest lag, in standard errors, that counts as none."""
SURE: Final = 8.0
"""Least lag, in standard errors, that is told and named also where other errors are larger."""
UNSTEADY: Final = 0.25
"""Largest relative difference between the lag of each half of a run and that of the whole; a drift makes a half."""
LEAST_LATE: Final = 0.5
"""Least lag, in samples, that is named where other errors are larger."""
LARGEST_INFLATION: Final = 10.0
"""Largest variance inflation factor at which a lag counts as told apart from turns."""
SLOWEST_RATE: Final = 1e-6
"""Least body rate that tells something about time, rad/s."""
LOST: Final = float(np.radians(20.0))
"""Median error above which an estimate follows the truth too little to tell a lag, rad."""
FINEST_S: Final = 1e-9
"""Least standard error of a lag, s: stamps are whole nanoseconds."""
FULL: Final = 0.999
"""Share of the longest lag from which on a lag is at the limit of the search."""


@dataclass(frozen=True)
class Lag:
    """A lag that is told.

    Attributes
    ----------
    lag_s, standard_error_s : float or None
        None where the motion and the errors do not tell it.
    sure : bool
        Whether it is a cause beside errors as large.
    """

    lag_s: float | None = None
    standard_error_s: float | None = None
    sure: bool = False

    __repr__ = short_repr


def lag_of(track: Track, named: Explanation, longest_lag_s: float, period_s: float) -> Lag:
    """Tell the lag beside a turn of the world and one of the body where the motion tells them apart.

    Where it does not, the lag is fitted beside the turns that are named. It is told where it is named, where it is
    sure, and where it is none, to an error that is small beside a lag that would turn the body by what is left.
    """
    given = track.part(spread(len(track.stamps_ns), SAMPLES))
    parts = [part for part in named.parts if part[0].code in BOTH]
    track = undone(given, [part for part in named.parts if part[0].maps and part[0].code not in BOTH])
    lag = (BY_CODE["lagging"], np.array([named.lag_s or 0.0]))
    both = [(BY_CODE[code], np.zeros(BY_CODE[code].price)) for code in BOTH if code not in named.turned]
    for turned in ([*parts, *both], parts):
        if _separable(track, [*turned, lag]) or (named.lag_s is not None and turned is parts):
            return _told(track, turned, lag, named.lag_s is not None, longest_lag_s, period_s)
    return Lag()


def standard_error(track: Track, parts: Sequence[Part]) -> float:
    """Standard error of the lag, the last of fitted constants, s.

    The fit takes the lag as a weighted sum of the errors, G · ψ. The same sum with the errors moved along the run, in a
    circle, is what errors of that spectrum make of a lag where there is none: its root mean square over all shifts
    counts white errors as independent, and drifts as the few that they are. Errors keep to the axes of the world, as
    those of a heading, or to those of the body, as biases do. Of a body that turns evenly the shifts are all alike and
    tell nothing: errors that are independent are counted as well. The largest value counts.
    """
    truth, J, error, weight = _linear(track, parts)
    weighted = J * weight[:, np.newaxis, np.newaxis]
    G = J @ np.linalg.pinv(np.einsum("nia,nib->ab", weighted, J), rcond=1e-10)[:, -1]
    psi = weight[:, np.newaxis] * error
    on_world = [quaternion.rotate(truth, vectors) for vectors in (G, psi)]
    independent = float(np.sqrt(np.sum(G**2) * np.mean(psi**2)))
    return max(_rms_over_shifts(G, psi), _rms_over_shifts(*on_world), independent)


def _rms_over_shifts(G: Array, errors: Array) -> float:
    """Root mean square of Σ G · errors over all circular shifts of the errors, both of shape (N, 3)."""
    spectra = np.conj(np.fft.rfft(G, axis=0)) * np.fft.rfft(errors, axis=0)
    return rms(np.fft.irfft(spectra.sum(axis=1), n=len(G)))


def _linear(track: Track, parts: Sequence[Part]) -> tuple[Array, Array, Array, Array]:
    """True attitudes, derivative by the constants, errors on the body's axes, and their weights."""
    now = undone(track, parts)
    truth, rate = now.truth.states(now.stamps_ns)
    error = turns(truth, now.attitude_xyzw)
    J = np.concatenate([cause.slopes(track, truth, rate) for cause, _ in parts], axis=-1)
    return truth, J, error, weights(sizes(error))


def _separable(track: Track, parts: Sequence[Part]) -> bool:
    """Whether the motion tells the lag, the last of some constants, from the others, and turns at all.

    The variance of a lag that is fitted alone grows by a factor when others are fitted with it.
    """
    _, J, _, _ = _linear(track, parts)
    normal = np.einsum("nia,nib->ab", J, J)
    alone = float(normal[-1, -1])
    if not alone > SLOWEST_RATE**2 * len(J):
        return False
    shared = normal[-1, :-1] @ np.linalg.lstsq(normal[:-1, :-1], normal[:-1, -1], rcond=1e-10)[0]
    return bool(alone <= LARGEST_INFLATION * (alone - shared))


def _median(track: Track, parts: Sequence[Part]) -> float:
    return float(np.median(undone(track, parts).errors()))


def _told(
    track: Track, turned: Sequence[Part], lag: Part, is_named: bool, longest_lag_s: float, period_s: float
) -> Lag:
    fitted = fit([track], [*turned, lag])
    lag_s = float(fitted[-1][1][0])
    if abs(lag_s) > FULL * longest_lag_s:
        return Lag()
    left = _median(track, fitted)
    error = standard_error(track, fitted)
    if is_named:
        return Lag(lag_s, error)
    if left > LOST:
        return Lag()
    without = [*fit([track], turned), (lag[0], np.zeros(1))] if turned else [(lag[0], np.zeros(1))]
    before, rate = _median(track, without), rms(sizes(track.truth.states(track.stamps_ns)[1]))
    clear = abs(lag_s) >= SURE * error or (abs(lag_s) >= SIGNIFICANT * error and before >= 2.0 * left)
    if clear and abs(lag_s) * rate <= 2.0 * _median(track, ()) and _is_steady(track, fitted):
        lead = -LEAD * period_s <= lag_s <= 0.0
        sure = abs(lag_s) >= SURE * error and abs(lag_s) >= LEAST_LATE * period_s and not lead
        return Lag(lag_s, error, sure)
    error = max(standard_error(track, without), FINEST_S)
    told = abs(lag_s) <= SIGNIFICANT * error and 4.0 * error * rate <= max(before, NEGLIGIBLE)
    return Lag(lag_s, error) if told else Lag()


def _is_steady(track: Track, fitted: Sequence[Part]) -> bool:
    """Whether each half of a run alone tells about the same lag; what drifts feign hardly does."""
    lag_s = fitted[-1][1][0]
    halves = np.array_split(np.arange(len(track.stamps_ns)), 2)
    alone = [fit([track.part(half)], fitted)[-1][1][0] for half in halves]
    return bool(np.all(np.abs(np.array(alone) - lag_s) <= UNSTEADY * abs(lag_s)))
