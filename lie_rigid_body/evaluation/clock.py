"""The clock of an estimate's stamps: its lag with a standard error, a far lag, or another rate.

A lag is told where it is real, and slow errors cannot look like it. Another clock, as by a mistaken period, a replay at
another speed or the time of day beside a replay, is looked for where nothing else explains a large error.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation.causes import (
    BY_CODE,
    MIN_COVERED,
    UP,
    Part,
    Parts,
    derivative,
    fit,
    fitted_in_time,
    inflations,
    late,
    undone,
    weights,
)
from lie_rigid_body.evaluation.evidence import FULL, LEAD, MAX_INFLATION, MIN_LATE, UNLIKE
from lie_rigid_body.evaluation.explanations import BOTH, MAX_LEFT, SHARE, Explanation
from lie_rigid_body.evaluation.matched import (
    MIN_SAMPLES,
    NEGLIGIBLE,
    SPIN,
    Matched,
    constant_attitude_misfit,
    floored,
    is_single_axis,
    quarters,
)
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

SIGNIFICANT: Final = 3.0
"""Largest lag, in standard errors, that counts as none."""
SURE: Final = 8.0
"""Least lag, in standard errors, that is named as a cause even if other errors are larger."""
BLOCKS: Final = 6
"""Number of blocks of a run whose errors count as independent.

Measured over 30 s: errors that are correlated over up to 1 s spread the lag 0.8 to 1.3 times as much as is said. Those
of 10 s spread it 0.6 to 2.7 times as much.
"""
UNSTEADY: Final = 0.25
"""Largest relative difference between the lag of either half of a run and that of the whole run; a drift makes ½."""
MIN_BODY_RATE: Final = 1e-6
"""Least body rate, rad/s, at which the motion determines a lag."""
MAX_LEFT_BY_CLOCK: Final = math.radians(5.0)
"""Largest RMS error, rad, that another clock may leave in a quarter of a run: any clock fits a little."""
MIN_COVERED_BY_RATE: Final = 0.9
"""Smallest share of the samples that the rate of another clock puts within the truth's times."""
MAX_LAG_STEP: Final = 0.2
"""Largest turn of the body, rad, from one far lag that is tried to the next."""
MAX_LAGS: Final = 5000
"""Largest number of far lags that are tried; where it takes more, none is."""
STARTS: Final = 5
"""Number of far lags that are fitted: of a motion that nearly repeats several leave little."""
EVEN_SPIN: Final = 0.98
"""Squared length of the mean axis of rotation above which lags a whole turn apart look alike."""
MIN_OFF: Final = 2e-3
"""Smallest difference of a clock's rate from 1 that is named: a lag explains a smaller one as well."""
CLOCK_RATIO: Final = 1.5
"""Ratio of two rates above which no error of a gyro looks like another rate."""
MIN_SPANNED: Final = 0.8
"""Smallest share of the truth's time span that the stamps fill by another rate, if the body turns about one axis."""
RATES: Final = np.geomspace(1.0 / 16.0, 16.0, 557)
"""Rates from which a fit begins, 1 % apart."""


class Lag(NamedTuple):
    """Lag of an estimate behind the truth, with its standard error.

    Attributes
    ----------
    lag_s, standard_error_s : float or None
        Lag and its standard error, s; None where the motion and the errors do not determine them.
    sure : bool
        Whether the lag is named as a cause even if other errors are as large.
    """

    lag_s: float | None = None
    standard_error_s: float | None = None
    sure: bool = False


def lag_of(track: Matched, named: Explanation, longest_lag_s: float, period_s: float) -> Lag:
    """Fit the lag together with a turn of the world and one of the body, where the motion tells them apart.

    Otherwise the lag is fitted beside a heading and a mounting, else beside the turns that are named. Then a tilt of
    the world, which sensors leave as well, may look like a lag. So the standard error of a named lag is at least the
    change of the lag by fitting a tilt beside it. A lag is returned where it is named, where it is sure, and where it
    is none. It counts as none if its standard error is small beside the lag that would make an error as large as what
    is left. The fit uses 4000 samples at most.
    """
    parts = [part for part in named.parts if part[0].code in BOTH]
    track = undone(track.thinned(4000), [part for part in named.parts if part[0].maps and part[0].code not in BOTH])
    lag = late(named.lag_s or 0.0)
    known = {cause.code: fitted for cause, fitted in parts}
    up = known.get("heading_offset", np.zeros(1))
    mounting = known.get("body_mounting", np.zeros(3))
    body = BY_CODE["body_mounting"], mounting
    tilted = [(BY_CODE["world_turned"], up * UP), body]
    level = [(BY_CODE["heading_offset"], up), body]
    for turned in (tilted, level, parts):
        if _separable(track, [*turned, lag]) or (named.lag_s is not None and turned is parts):
            fitted = fit([track], [*turned, lag])
            lag_s = float(fitted[-1][1][0])
            if abs(lag_s) > FULL * longest_lag_s:
                return Lag()
            if named.lag_s is not None:
                beside_tilt = float(fit([track], [*tilted, lag])[-1][1][0])
                return Lag(lag_s, max(standard_error(track, fitted), abs(lag_s - beside_tilt)))
            instead = fitted if turned is tilted else fit([track], tilted)
            found = _unnamed(track, fitted, [*fit([track], turned), lag], instead, period_s)
            return found if turned is not parts else found._replace(sure=False)
    return Lag()


def _unnamed(track: Matched, fitted: Parts, without: Parts, instead: Parts, period_s: float) -> Lag:
    """Lag that no explanation names: returned where it is sure, or surely small.

    A lag must leave no more error than ``instead``, a turn of the world and one of the body. The lead of a right filter
    may leave more.
    """
    lag_s = float(fitted[-1][1][0])
    error = standard_error(track, fitted)
    left, before, other, raw = (
        np.median(undone(track, parts).error().total) for parts in (fitted, without, instead, ())
    )
    turn = rms(norm(track.rates))
    if left > MAX_LEFT:  # what follows the truth so little tells no lag
        return Lag()
    clear = abs(lag_s) >= SURE * error or (abs(lag_s) >= SIGNIFICANT * error and before >= 2.0 * left)
    # each half of a run alone tells about the same lag; what drifts feign hardly does
    halves = (track.fraction(0.0, 0.5), track.fraction(0.5))
    alone = (float(fit([half], fitted)[-1][1][0]) for half in halves)
    lead = -LEAD * period_s <= lag_s <= 0.0
    clear &= abs(lag_s) * turn <= min(2.0 * raw, 0.5 * np.pi) and (lead or left <= other)
    if clear and all(abs(of_half - lag_s) <= UNSTEADY * abs(lag_s) for of_half in alone):
        return Lag(lag_s, error, abs(lag_s) >= max(SURE * error, MIN_LATE * period_s) and not lead)
    error = standard_error(track, without)
    told = abs(lag_s) <= SIGNIFICANT * error and 4.0 * error * turn <= max(before, NEGLIGIBLE)
    return Lag(lag_s, error) if told else Lag()


def _separable(track: Matched, parts: Parts) -> bool:
    """Whether the body turns at all, and the motion tells the lag, the last constant, apart from the others."""
    turns = rms(norm(derivative(track, parts)[0][..., -1])) > MIN_BODY_RATE
    return turns and inflations(track, parts)[-1] <= MAX_INFLATION


def standard_error(track: Matched, parts: Parts) -> float:
    """Standard error of the lag, which is the last of the fitted constants, s.

    The largest of three. The jackknife of `BLOCKS` blocks of the run tells how much the lag changes when one is left
    out, by a step of Newton's method for the weighted fit. Errors count as correlated within a block, whatever their
    spectrum. The other two: the fit gives the lag as a weighted sum of the errors, G · ψ. Errors that are shifted
    cyclically along the run have the same spectrum and no lag. So the root mean square of the sum over all shifts
    counts slow drifts as few. They are shifted on the axes of the body, where a bias is constant, and of the world.
    """
    J, error, truth = derivative(track, parts)
    size = norm(error)
    weight = weights(size)[:, np.newaxis, np.newaxis]
    transposed = np.swapaxes(J, 1, 2)
    along = transposed @ error[..., np.newaxis]
    # second derivative of the loss: the weight falls with the size of an error
    falls = weight**1.5 * (4.0 / max(9.0 * np.median(size) ** 2, 1e-300))
    normal = weight * (transposed @ J) - falls * (along @ np.swapaxes(along, 1, 2))
    gradient = (weight * along)[..., 0]
    whole = normal.sum(axis=0)
    changes = [
        (np.linalg.pinv(whole - normal[block].sum(axis=0), rcond=1e-10) @ gradient[block].sum(axis=0))[-1]
        for block in np.array_split(np.arange(len(J)), BLOCKS)
    ]
    jackknife = math.sqrt((BLOCKS - 1) / BLOCKS * np.sum(np.square(changes)))
    G = J @ np.linalg.pinv(whole, rcond=1e-10)[:, -1]
    psi = weight[..., 0] * error
    both = np.stack([(G, psi), (quaternion.rotate(truth, G), quaternion.rotate(truth, psi))])
    of_weights, of_errors = np.moveaxis(np.fft.rfft(both, axis=2), 1, 0)
    shifted = np.fft.irfft((np.conj(of_weights) * of_errors).sum(axis=2), n=len(G))
    return max(1e-9, jackknife, *map(rms, shifted))  # stamps are nanoseconds


def other_clock(track: Matched, beyond_s: float, *, rates: bool) -> tuple[Part, Matched] | None:
    """Find another clock by which an estimate follows the truth: of another rate, or late or ahead by a far lag.

    Parameters
    ----------
    track : Matched
        All samples, also those outside of the truth's times.
    beyond_s : float
        Lags up to this were judged before, s.
    rates : bool
        Whether other rates are looked for as well.

    Returns
    -------
    tuple of Part and Matched, or None
        The clock that leaves the least error, and the samples that it puts within the truth's times.
    """
    few = track.thinned(300)
    truth = track.truth
    if len(few.stamps_ns) < MIN_SAMPLES:
        return None
    some = np.linspace(truth.first_ns, truth.last_ns, 200).round().astype(np.int64)
    step_s = MAX_LAG_STEP / max(norm(truth.states(some)[1]).max(), 1e-9)
    begin_s = (few.stamps_ns[0] - truth.last_ns) / 1e9
    end_s = (few.stamps_ns[-1] - truth.first_ns) / 1e9
    parts = list[Part]()
    if rates:
        cause = BY_CODE["clock_rate"]
        parts += [(cause, rate) for rate in fitted_in_time(cause, RATES, [few], covered=MIN_COVERED_BY_RATE)]
    lags = np.arange(begin_s, end_s, step_s) if end_s - begin_s <= MAX_LAGS * step_s else np.zeros(0)
    lags = lags[np.abs(lags) > beyond_s]
    if len(lags):
        parts += [late(lag[0]) for lag in fitted_in_time(BY_CODE["lagging"], lags, [few], STARTS)]
    found = [(part, undone(track, [part]).known()) for part in parts if _explains(few, part, beyond_s)]
    return min(found, key=lambda clock: rms(clock[1].error().total), default=None)


def _explains(few: Matched, part: Part, beyond_s: float) -> bool:
    """Whether another clock leaves little error in each quarter of the run but the first.

    Little is: beside the error by the given stamps, and beside the turn of the body. A body that turns about one axis
    does not tell a rate from the scale of a gyro. An even spin does not tell a lag from one of whole turns more.
    """
    moved = undone(few, [part]).known()
    own = few.known()
    is_rate = part[0].code == "clock_rate"
    number = float(part[1][0])
    if len(moved.stamps_ns) < max(MIN_SAMPLES, (MIN_COVERED_BY_RATE if is_rate else MIN_COVERED) * len(few.stamps_ns)):
        return False
    if abs(number - 1.0) < MIN_OFF if is_rate else abs(number) <= beyond_s:
        return False
    before = quarters(own) if len(own.stamps_ns) >= MIN_SAMPLES else np.ones(3)
    most_left = min(
        (0.5 * UNLIKE) ** 2 * constant_attitude_misfit(moved.truth_xyzw), np.sin(0.5 * MAX_LEFT_BY_CLOCK) ** 2
    )
    if np.any(quarters(moved) > floored(np.minimum(SHARE**2 * before, most_left))):
        return False
    if not is_single_axis(moved.rates, SPIN if is_rate else EVEN_SPIN):
        return True
    if not is_rate:
        return abs(number) * float(norm(moved.rates).max()) < np.pi
    spanned = (moved.stamps_ns[-1] - moved.stamps_ns[0]) / (moved.truth.last_ns - moved.truth.first_ns)
    return max(number, 1.0 / number) >= CLOCK_RATIO and spanned >= MIN_SPANNED
