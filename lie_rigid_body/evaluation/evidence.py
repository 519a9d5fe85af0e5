"""Evidence about an estimate, by which its explanations are judged, and the choice of one of them by the one rule."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation.attitudes import angles, error_vectors, period_ns
from lie_rigid_body.evaluation.causes import BY_CODE, fit, inflations, or_else
from lie_rigid_body.evaluation.explanations import (
    BY_RATES,
    FORMS,
    LATE,
    MAX_LEFT_BY_THREE,
    PAIRS,
    PRICES,
    SHARE,
    TURNED,
    Explanation,
    Form,
    Turned,
    base_of,
    best,
    best_of_pair,
    largest,
    start_of_pair,
    value,
)
from lie_rigid_body.evaluation.matched import (
    NEGLIGIBLE,
    SAMPLES,
    WINDOW,
    Matched,
    constant_attitude_misfit,
    floored,
    is_single_axis,
    lags_of_rates,
    products,
    valleys,
)
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

LAG_SHARE: Final = 0.5
"""Largest ratio of the RMS error with a named lag to that without. Slow errors hardly follow the body rate, unless the
body turns about one axis."""
MIN_LATE: Final = 0.5
"""Least lag, in samples, that is named as a cause where other errors are as large."""
TIE: Final = 1.25
"""Ratio of two RMS errors up to which their explanations count as equally good."""
UNEVEN_QUARTERS: Final = 3.0
"""Largest ratio of the RMS errors that a far lag leaves in two quarters: a near repetition fits another lag in each."""
FOLLOWING: Final = 0.125
"""Largest share of the error that causes, not sure enough to be named, may leave if the estimate follows the body."""
UNLIKE: Final = 0.5
"""Largest error that an explanation with constants may leave, as a share of what a constant attitude leaves.

With a mounting it is half of that."""
MIN_TILT: Final = math.radians(10.0)
"""Least tilt of a turned world, rad, and least angle to a world upside down: tilts by sensor errors are smaller. A turn
about the vertical is a heading offset, and a world upside down is NED with a heading offset."""
LEAD: Final = 1.5
"""Largest lead of a right filter, samples: one sample, and half of one for sensor errors."""
DISCRETISATION_ERROR: Final = 0.1
"""Largest constant error of a right filter with perfect sensors, as a share of the largest turn between samples."""
OF_SENSORS: Final = math.radians(1.0)
"""Attitude error, rad, below which sensor errors may be the cause; they look more like a constant turn than a lag."""
LAG_TIE: Final = 3.0
"""Ratio of two RMS errors up to which a lag is an alternative to a cause of an error below `OF_SENSORS`."""
FULL: Final = 0.999
"""Share of the longest lag from which on a lag counts as at the limit of the search."""
MAX_INFLATION: Final = 10.0
"""Largest variance inflation factor with which the motion tells constants apart."""
MAX_OF_LEAD: Final = 8000
"""Largest number of samples by which the error of a lead is computed."""
BLOCKS: Final = 9
"""Number of parts of a run in which constants are fitted, to see whether they shrink."""
EVENLY: Final = 0.15
"""Largest distance from half of the decrease of a constant up to the middle third. Of an exponential decay it is that
where the time constant is 0.4 of the run."""
SHRUNK: Final = 0.05
"""Share of a constant by which it shrinks at least in an estimate that converges."""


class Choice(NamedTuple):
    """Choice of an explanation.

    Attributes
    ----------
    named : Explanation
        Without a cause where none is sure.
    of_sensors : bool
        Whether a constant turn was found that is no larger than what the sensors' own errors leave.
    at_limit : bool
        Whether a lag at the limit of the search leaves least: the true one may be longer.
    converging : bool
        Whether a constant of the explanation shrinks, as the estimate still converges: nothing is named then.
    """

    named: Explanation
    of_sensors: bool
    at_limit: bool = False
    converging: bool = False


class Evidence:
    """Sums over an estimate and the truth, from which every explanation is judged.

    Parameters
    ----------
    track : Matched
        Samples whose true time, moved by the longest lag either way, is within the truth's times.
    longest_lag_s : float
    left_by_sensors : float
        Largest constant turn that the sensors' own errors leave to a right filter, rad.
    """

    def __init__(self, track: Matched, longest_lag_s: float, left_by_sensors: float) -> None:
        self.whole = track
        self.track = track.thinned(SAMPLES)
        self.period_s = period_ns(track.stamps_ns) / 1e9
        self.longest_lag_s = longest_lag_s
        self.left_by_sensors = left_by_sensors
        rate = norm(self.track.rates)
        self.fastest = float(rate.max())
        self.misfit_of_constant = constant_attitude_misfit(self.track.truth_xyzw)
        self.is_single_axis = is_single_axis(self.track.rates)
        self.root_mean_square_rate = rms(rate)
        # at the leads of a right filter: none, half a sample and one
        self._ahead = self.sums(np.array([0.0, -0.5, -1.0]) * min(self.period_s, longest_lag_s))
        # between neighbours the body turns by a quarter of a radian at most, unless they would be too many
        half = min(max(math.ceil(4.0 * longest_lag_s * self.fastest), 1), 90)
        self._lags = np.linspace(-longest_lag_s, longest_lag_s, 2 * half + 1)
        # what a lag between two of these may leave less
        self._slack = np.sin(0.25 * min((self._lags[1] - self._lags[0]) * self.fastest, 2.0)) ** 2
        self._known: dict[tuple[Form, Turned, bool], Explanation] = {}

    def sums(self, lags_s: Array, most: int = SAMPLES) -> Array:
        """The matrices T of the quarters but the first, at each lag: shape (L, 3, 16, 16)."""
        few = self.track.thinned(most)
        P = products(few, few.stamps_ns - np.round(lags_s * 1e9).astype(np.int64)[:, np.newaxis])
        return np.stack([np.swapaxes(q, 1, 2) @ q / q.shape[1] for q in np.array_split(P, 4, axis=1)[1:]], axis=1)

    def judged(self, form: Form, turned: Turned, T: Array) -> tuple[Array, Array]:
        """Mean sin² of half of the error left in each quarter, (..., 3), and numbers, by sums T, (..., 3, 16, 16)."""
        base = base_of(form, turned)
        G = base @ T @ base.T
        whole = G.sum(axis=-3)
        others = whole[..., np.newaxis, :, :] - G
        if turned in PAIRS:
            start = start_of_pair(whole.reshape(-1, *whole.shape[-2:])[0])
            numbers, crossed = (best_of_pair(sums, start) for sums in (whole, others))
        else:
            numbers = best(whole)
            crossed = best(others)
        return 1.0 - value(crossed, G), numbers

    def get(self, form: Form = (), turned: Turned = (), *, late: bool = False) -> Explanation:
        """The explanation of a form with turns, with a lag or without."""
        key = form, turned, late
        if key not in self._known:
            self._known[key] = self._with_lag(form, turned) if late else self._without_lag(form, turned)
        return self._known[key]

    def _without_lag(self, form: Form, turned: Turned) -> Explanation:
        left, numbers = self.judged(form, turned, self._ahead)
        return Explanation(form, turned, left[np.argmin(left.mean(axis=1))], numbers[0])

    @cached_property
    def _scanned(self) -> dict[tuple[Form, Turned], Array]:
        """Mean sin² of half of the error that each form leaves, with each turn of `LATE`, at each lag tried."""
        T = self.sums(self._lags, most=100).mean(axis=1)
        return {
            (form, turned): 1.0 - np.linalg.eigvalsh(base_of(form, turned) @ T @ base_of(form, turned).T)[..., -1]
            for turned in LATE
            for form in FORMS
        }

    def _with_lag(self, form: Form, turned: Turned) -> Explanation:
        """The explanation with the smallest of the lags that leave about the least error."""
        if turned in BY_RATES:
            near = [
                self._at_lag(form, turned, lag_s, 0.5 * WINDOW / self.fastest) for lag_s in self.lags_of_rates or [0.0]
            ]
            return min(near, key=lambda e: floored(e.left).mean())
        lags = self._lags
        cost = self._scanned[form, turned]
        lowest = [k for k in valleys(cost) if cost[k] <= cost.min() + self._slack]
        by_size = sorted(lowest, key=lambda k: abs(lags[k]))
        step = float(lags[1] - lags[0])
        found = [self._at_lag(form, turned, float(lags[k]), step) for k in np.union1d(lowest[:4], by_size[:4])]
        least = min(floored(e.left).mean() for e in found)
        as_good = [e for e in found if floored(e.left).mean() <= TIE**2 * least]
        return min(as_good, key=lambda e: abs(e.lag_s or 0.0))

    def _at_lag(self, form: Form, turned: Turned, lag_s: float, step: float) -> Explanation:
        """The explanation with a refined lag: vertices of parabolas through three lags, ever nearer ones."""
        base = base_of(form, turned)
        for _ in range(4):
            three = np.clip(lag_s + step * np.array([-1.0, 0.0, 1.0]), -self.longest_lag_s, self.longest_lag_s)
            G = base @ self.sums(three) @ base.T
            whole = G.sum(axis=1)
            shift = _vertex(3.0 - largest(turned, whole))
            lag_s = float(np.clip(three[1] + shift * step, three[0], three[2]))
            step = step / 5.0
        others = 2.0 - largest(turned, whole[:, np.newaxis] - G)
        crossed = three[1] + 5.0 * step * np.array([_vertex(one) for one in others.T])
        T = self.sums(np.clip([lag_s, *crossed], -self.longest_lag_s, self.longest_lag_s))
        left, numbers = self.judged(form, turned, T)
        return Explanation(
            form, turned, left[[1, 2, 3], [0, 1, 2]], numbers[0], lag_s, far=abs(lag_s) * self.fastest > np.pi
        )

    @cached_property
    def lags_of_rates(self) -> list[float]:
        """The two likeliest lags by how fast the estimate turns, s; see `lags_of_rates`."""
        return lags_of_rates(self.whole, self.longest_lag_s)[:2]

    @cached_property
    def tried(self) -> list[Explanation]:
        """Explanations that may be the best, the cheapest first."""
        found = sorted((self.get(form, turned) for turned in TURNED for form in FORMS), key=lambda e: e.cost)
        turnable = dict.fromkeys(e.form for e in found if e.turned in LATE[1:])
        found += [self.get(form, pair) for form in list(turnable)[:6] for pair in PAIRS]
        if min(e.error for e in found) > OF_SENSORS and self.lags_of_rates:
            found += [self.get(form, turned, late=True) for form in list(turnable)[:2] for turned in BY_RATES]
        lowest = min(e.cost for e in found)
        trials = [
            Explanation(form, turned, np.array([costs.min() - self._slack]), np.zeros(0), 0.0)
            for (form, turned), costs in self._scanned.items()
        ]
        promising = sorted((e for e in trials if e.cost < lowest), key=lambda e: e.cost)
        found += [self.get(e.form, e.turned, late=True) for e in promising[:8]]
        return sorted(found, key=lambda e: e.cost)

    def choice(self) -> Choice:
        """Choose the causes of the errors by the one rule."""
        plain = self.get()
        of_sensors = False
        allowed = {*BY_CODE, "lag"}
        for e in self.tried[: self.tried.index(plain)]:
            if not allowed.issuperset(e.causes):
                continue
            if e.lag_s is not None and abs(e.lag_s) > FULL * self.longest_lag_s:
                return Choice(plain, of_sensors, at_limit=True)
            if self.is_needed(e):
                is_lead = not e.form and self.lead[0] > 0.0 and self.lead[1] <= TIE * max(e.error, NEGLIGIBLE)
                if not is_lead and not self.is_small(e):
                    return Choice(e, of_sensors, converging=not self.is_constant(e))
                allowed = {*e.causes}  # what is left without the small turn is of its other causes
                of_sensors |= self.left_by_sensors > 0.0 and not is_lead
        return Choice(plain, of_sensors)

    @cached_property
    def lead(self) -> tuple[float, float]:
        """Error that a filter has which compares readings with the attitude before its gyro step, and what it leaves.

        Such a filter is drawn toward an attitude one sample ahead. Its error is the body rate in the world times the
        period, low-passed with the time constant of its corrections. That is fitted, with a matrix, as gains about the
        axes of the world differ. Both are RMS, rad. The first is 0 where the lead is less than half a sample in the
        mean, more than `LEAD`, or leaves more than `SHARE` of the error.
        """
        few = self.whole.thinned(MAX_OF_LEAD)
        count = len(few.stamps_ns)
        span_s = np.ptp(few.since_s)
        turns = np.fft.rfft(quaternion.rotate(few.truth_xyzw, few.rates) * self.period_s, axis=0)
        frequency = np.fft.rfftfreq(count, span_s / max(count - 1, 1))[:, np.newaxis]
        settled = slice(count // 4, None)
        error = error_vectors(few.attitude_xyzw, few.truth_xyzw)[settled]
        before = rms(norm(error))
        best = (0.0, before)
        for tau_s in [0.0, *np.geomspace(self.period_s, max(span_s, self.period_s), 12)]:
            moved = np.fft.irfft(turns / (1.0 + 2j * np.pi * frequency * tau_s), count, axis=0)[settled]
            share = np.linalg.lstsq(moved, error, rcond=1e-6)[0]
            led = moved @ share
            left = rms(norm(error - led))
            is_lead = np.trace(share) > 3.0 * MIN_LATE and np.linalg.norm(share, 2) < LEAD
            if is_lead and left < min(best[1], SHARE * before):
                best = (rms(norm(led)), left)
        return best

    def is_constant(self, explanation: Explanation) -> bool:
        """Whether no constant shrinks from the first third to the last, as in an estimate that still converges.

        The first quarter does not count. Constants are fitted to `BLOCKS` parts of the rest, of which three are a
        third. One shrinks if the means of these thirds differ by more than 3 standard errors, by the scatter in each.
        The difference must exceed `SHRUNK` of it, the error that is left, and what the sensors' own errors leave. About
        half of it must come by the middle third: what decays faster is no constant of three quarters.
        """
        begins = np.linspace(0.25, 1.0, BLOCKS, endpoint=False).tolist()
        fits = [fit([self.track.fraction(begin, begin + 0.75 / BLOCKS)], explanation.parts) for begin in begins]
        for k, (cause, constants) in enumerate(explanation.parts):
            if cause.price:
                turn = self.root_mean_square_rate if cause.unit == "s" else 1.0
                sizes = np.array([found[k][1] @ constants for found in fits]) * turn / np.linalg.norm(constants)
                thirds = sizes.reshape(3, -1)
                first, middle, last = thirds.mean(axis=1)
                error = np.sqrt(3.0 * thirds[::2].var(axis=1, ddof=1).sum())  # 3 standard errors of the difference
                halfway = abs(0.5 * (first + last) - middle) < EVENLY * (first - last)
                if halfway and first - last > max(error, SHRUNK * first, explanation.error, self.left_by_sensors):
                    return False
        return True

    def without(self, explanation: Explanation, cause: str) -> Explanation:
        """The explanation without one of its causes."""
        return self.get(
            tuple(part for part in explanation.form if part[0] != cause),
            tuple(code for code in explanation.turned if code != cause),
            late=explanation.lag_s is not None and cause != "lag",
        )

    def is_needed(self, explanation: Explanation) -> bool:
        """Whether an explanation leaves little beside the body's turn, and needs each cause in each quarter."""
        left = floored(explanation.left)
        lag_s = explanation.lag_s
        unlike = UNLIKE * (0.5 if "body_mounting" in explanation.turned else 1.0)
        # a constant fits a body that hardly turns, and a chain without one by chance: one of all in 0.2 % of turns
        least = NEGLIGIBLE if explanation.fitted else MAX_LEFT_BY_THREE
        if left.mean() > max(unlike**2 * self.misfit_of_constant, np.sin(0.5 * least) ** 2) or not explanation.explains:
            return False
        is_lead = lag_s is not None and -LEAD * self.period_s <= lag_s <= 0.0
        is_level = any(
            cause.code == "world_turned" and self._is_level(explanation, quaternion.exp(c))
            for cause, c in explanation.parts
        )
        if explanation.fits_anything and max(inflations(self.track, explanation.parts)) > MAX_INFLATION:
            return False
        if is_lead or is_level or (explanation.far and left.max() > UNEVEN_QUARTERS**2 * left.min()):
            return False
        shares = dict.fromkeys(explanation.causes, SHARE)
        if lag_s is not None and abs(lag_s) >= MIN_LATE * self.period_s and not self.is_single_axis:
            shares["lag"] = LAG_SHARE
        return all(
            np.all(left <= share**2 * floored(self.without(explanation, cause).left)) for cause, share in shares.items()
        )

    def _is_level(self, explanation: Explanation, turn: Array) -> bool:
        """Whether a turn of the world is nearly a heading, which explains as well, or one of a world upside down."""
        tilt = angles(turn).inclination
        turned = tuple("heading_offset" if code == "world_turned" else code for code in explanation.turned)
        level = self.get(explanation.form, turned, late=explanation.lag_s is not None)
        return bool(tilt >= np.pi - MIN_TILT or (tilt <= MIN_TILT and level.explains))

    def is_small(self, explanation: Explanation) -> bool:
        """Whether a turn, or the turn in a lag that leaves some error, is no larger than what sensor errors leave."""
        turns_rad = [np.linalg.norm(constants) for cause, constants in explanation.parts if cause.code in PRICES]
        is_late = explanation.lag_s is not None and (
            explanation.error > FOLLOWING * self.without(explanation, "lag").error
            and abs(explanation.lag_s) * self.fastest <= self.left_by_sensors
        )
        least = max(self.left_by_sensors, DISCRETISATION_ERROR * self.fastest * self.period_s)
        return is_late or min(turns_rad, default=np.inf) <= least

    def follows(self) -> bool:
        """Whether up to three causes, sure or not, leave little error: the estimate then follows the body."""
        most = FOLLOWING * self.get().error
        return any(e.error <= most and e.explains for e in self.tried if 0 < len(e.causes) <= 3 and not e.fits_anything)

    def with_lag(self, named: Explanation, lag_s: float) -> Explanation:
        """The named explanation with a lag added, if its own fit of a lag gives about the same."""
        if named.lag_s is not None or named.turned not in LATE or self.is_single_axis:
            return named
        found = self.get(named.form, named.turned, late=True)
        same = found.lag_s is not None and abs(found.lag_s - lag_s) <= 0.25 * abs(lag_s)
        return replace(found, lag_s=lag_s) if same and not self.is_small(found) else named

    def instead_of(self, named: Explanation, cause: str) -> tuple[str, ...]:
        """Causes that leave about as much error in the place of a named one."""
        without = self.without(named, cause)
        left = max(named.error, NEGLIGIBLE)
        others = [*self.tried, *([self.get(without.form, without.turned, late=True)] if without.turned in LATE else [])]
        found: dict[str, None] = {}
        for other in others:
            new = or_else(cause, named.causes, other.causes)
            small = new == "lag" and without.error < OF_SENSORS
            most = min((LAG_TIE if small else TIE) * left, 0.5 * (without.error + left))
            if new and max(other.error, NEGLIGIBLE) <= most and (small or self.is_needed(other)):
                found[new] = None
        return tuple(found)


def _vertex(three: Array) -> float:
    """Place of the minimum of a parabola through three equally spaced values, in steps from the middle, at most one."""
    a, b, c = three.tolist()
    bend = a - 2.0 * b + c
    return float(np.clip(0.5 * (a - c) / bend, -1.0, 1.0)) if bend > 0.0 else float(np.argmin(three)) - 1.0
