"""Explanations of the error of an estimate: which causes, alone or together, may be named, and what they leave.

An explanation is a chain of causes without a constant, then at most two with constants: turns of the world and of the
body, and a lag. Every one is judged by one number a quarter of the run, from the second on (in the first a filter may
converge). It is the mean of sin² of half of the error that is left, with the constants fitted to the other quarters.

One rule. The best explanation costs least, in units of halved errors: log₂ of what it leaves, plus its price. It is
named if each of its causes is needed: without it at least `1 / SHARE` times as much is left, in each of these quarters.
So drifts, random walks and noise are no causes, as no constant of some quarters fits the others. A right filter may be
ahead by up to a sample, as it compares readings with the attitude before its gyro step. Every explanation without a lag
may have such a lead at no price, and it is no cause.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import permutations
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.attitude_error import angles
from lie_rigid_body.evaluation.attitudes import sizes
from lie_rigid_body.evaluation.causes import BY_CODE, Part, Track, heading, products, vector
from lie_rigid_body.evaluation.estimate import period_ns
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

SHARE: Final = 1.0 / 3.0
"""Largest share of what is left without it that a named cause may leave, root mean square in a quarter."""
LAG_SHARE: Final = 0.5
"""Largest such share of a lag: slow errors hardly go with the rate of a body, unless it turns about one axis."""
SPIN: Final = 0.9
"""Squared length of the mean axis of rotation above which a body turns about one axis."""
LEAST_LATE: Final = 0.5
"""Least lag, in samples, that is named where other errors are as large."""
PRICES: Final = {"heading_offset": 1.25, "world_turned": 2.3, "body_mounting": 2.3, "lag": 1.25}
"""Prices of causes with constants, in halved errors; of one without a constant it is 1."""
FAR: Final = 1.0
"""Further price of a lag by which the body turns by more than half a turn: there are many."""
TIE: Final = 1.25
"""Ratio of two errors up to which their explanations are as good."""
NEGLIGIBLE: Final = float(np.radians(1e-3))
"""Error that needs no explanation, rad; smaller ones count as this."""
UNEVEN: Final = 3.0
"""Largest ratio of what a far lag leaves in two quarters: of a motion that nearly repeats each has its own."""
FOLLOWING: Final = 0.125
"""Largest share of the error that causes leave which are no names, but tell that the body is followed."""
UNLIKE: Final = 0.5
"""Largest share of what a constant attitude would leave that an explanation may leave; with a mounting half of it."""
LARGEST_LEFT: Final = float(np.radians(20.0))
"""Largest error that named causes leave, rad; where one has a constant, over their number."""
LEFT_BY_THREE: Final = float(np.radians(7.7))
"""Largest error that a cause with three constants leaves, rad, over the number of those with any."""
LEAST_TILT: Final = float(np.radians(10.0))
"""Least tilt of a turned world, rad, and least angle to one upside down: sensors err by less. A turn about the vertical
is a heading offset, and a world upside down is NED with a heading offset."""
LEAD: Final = 1.5
"""Largest lead of a right filter, samples: one, and what its sensors err by."""
FLOOR: Final = 0.1
"""Largest constant turn of a right filter with perfect sensors, as a share of the turn between two samples."""
LAG_TURN: Final = 0.25
"""Turn of the body from one lag that is tried to the next, rad."""
MOST_LAGS: Final = 181
FEWEST: Final = 20
"""Least number of samples whose quarters tell anything."""
SAMPLES: Final = 400
"""Largest number of samples by which explanations are judged."""
SCANNED: Final = 100
"""Largest number of samples by which lags are compared at first."""
MOST_BOTH: Final = 6
"""Number of forms with which a heading and a mounting are fitted together, the best with one of them."""
REFINED: Final = 8
"""Number of lags, the best of all explanations, that are refined."""
HEADINGS: Final = np.stack([np.cos(h := np.arange(6) * np.pi / 6.0), np.sin(h)], axis=-1)
"""Turns about the vertical, numbers w and z, from which a heading and a mounting are fitted together."""

Turned = tuple[str, ...]
TURNED: Final[tuple[Turned, ...]] = ((), ("heading_offset",), ("world_turned",), ("body_mounting",))
BOTH: Final = ("heading_offset", "body_mounting")
"""Turns that are tried, and those that are fitted together."""
LATE: Final = (TURNED[0], TURNED[1], TURNED[3])
"""Turns that are tried beside a lag."""


@dataclass(frozen=True, eq=False)
class Form:
    """A chain of causes without constants: their codes in the order of undoing, and the matrix that undoes them."""

    codes: tuple[str, ...]
    matrix: Array
    frd_body: bool = False

    @property
    def parts(self) -> list[Part]:
        """The causes with what they take for constants."""
        return [(BY_CODE[code], np.array([float(self.frd_body and code == "ned_world")])) for code in self.codes]


def _forms() -> Iterator[Form]:
    written = [order for count in range(3) for order in permutations(("scalar_first", "inverted"), count)]
    for order in written:
        matrix = np.eye(4)
        for code in order:
            matrix = BY_CODE[code].maps[0][0] @ matrix
        yield Form(order, matrix)
        for frd_body, maps in enumerate(BY_CODE["ned_world"].maps):
            yield Form((*order, "ned_world"), maps[0] @ matrix, bool(frd_body))


FORMS: Final = tuple(_forms())
"""Every chain; the first has no cause."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """Causes with their constants, and what they leave.

    Attributes
    ----------
    form : Form
    turned : tuple of str
        Turns of the world and of the body.
    left : ndarray, shape (3,)
        Mean of sin² of half of the error in each quarter but the first, the constants fitted to the others.
    numbers : ndarray
        Those of the turns.
    lag_s : float or None
        The lag, if it is a cause.
    far : bool
        Whether the body turns by more than half a turn in it.
    """

    form: Form
    turned: Turned
    left: Array
    numbers: Array
    lag_s: float | None = None
    far: bool = False

    __repr__ = short_repr

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes in the order in which they are undone."""
        return (*self.form.codes, *self.turned, *(() if self.lag_s is None else ("lag",)))

    @property
    def error(self) -> float:
        """Root mean square of the error that is left, rad."""
        return float(2.0 * np.arcsin(np.sqrt(np.clip(np.mean(self.left), 0.0, 1.0))))

    @property
    def explains(self) -> bool:
        """Whether so little is left that the causes are what is wrong: many constants fit anything to some degrees."""
        constants = len(self.causes) - len(self.form.codes)
        if {"world_turned", "body_mounting"} & {*self.turned}:
            return self.error <= LEFT_BY_THREE / constants
        return self.error <= LARGEST_LEFT / (len(self.causes) if constants else 1)

    @property
    def cost(self) -> float:
        """What the choice makes least."""
        simple = sum(PRICES.get(cause, 1.0) for cause in self.causes) + FAR * self.far
        # of two that do the same by nature: without other axes of the body, and with the smaller mounting
        simple += 0.02 * self.form.frd_body
        if "body_mounting" in self.turned and self.numbers.size:
            simple += 0.04 * float(np.linalg.norm(vector(self.numbers[-4:]))) / np.pi
        return float(np.mean(0.5 * np.log2(_counted(self.left)))) + simple

    @property
    def parts(self) -> list[Part]:
        """The causes of the table with their constants, as fitted so far."""
        turns = {"heading_offset": self.numbers[:2], "body_mounting": self.numbers[-4:], "world_turned": self.numbers}
        found = self.form.parts
        for code in self.turned:
            found.append((BY_CODE[code], (heading if code == "heading_offset" else vector)(turns[code])))
        if self.lag_s is not None:
            found.append((BY_CODE["lagging" if self.lag_s > 0.0 else "leading"], np.array([self.lag_s])))
        return found


def _counted(left: Array) -> Array:
    return np.asarray(np.maximum(left, np.sin(0.5 * NEGLIGIBLE) ** 2))


def spread(count: int, most: int) -> Integers:
    """Indices of at most so many samples, evenly spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def quarters(track: Track) -> Array:
    """Mean of sin² of half of the error in each quarter but the first, shape (3,)."""
    return np.array([np.mean(np.sin(0.5 * errors) ** 2) for errors in np.array_split(track.errors(), 4)[1:]])


def still(truth_xyzw: Array) -> float:
    """Mean of sin² of half of the error of a constant attitude."""
    return 1.0 - float(np.linalg.eigvalsh(truth_xyzw.T @ truth_xyzw)[-1]) / len(truth_xyzw)


def spins(rate: Array, least: float = SPIN) -> bool:
    """Whether a body with some rates, (N, 3), turns about one axis: so do errors of a gyro."""
    axes = rate / np.maximum(sizes(rate), 1e-300)[:, np.newaxis]
    return bool(np.sum(np.mean(axes, axis=0) ** 2) > least)


@cache
def _base(turned: Turned) -> Array:
    """Base of the repairs of each form followed by turns, shape (forms, d, 16)."""
    maps = np.eye(4)[np.newaxis]
    for code in turned:
        maps = (maps[:, np.newaxis] @ BY_CODE[code].maps[0]).reshape(-1, 4, 4)
    return np.stack([(maps @ form.matrix).reshape(-1, 16) for form in FORMS])


def _best(forms: Array) -> Array:
    """Unit vectors c of the largest cᵀ G c for each matrix G, shape (..., d)."""
    return np.asarray(np.linalg.eigh(forms)[1][..., -1])


def _best_of_both(forms: Array, first: Array) -> Array:
    """Numbers of a turn about the vertical (2) and one of the body (4), fitted in turns, shape (..., 6)."""
    G, up = forms.reshape(*forms.shape[:-2], 2, 4, 2, 4), first
    for _ in range(8):
        body = _best(np.einsum("...i,...k,...ijkl->...jl", up, up, G))
        up = _best(np.einsum("...j,...l,...ijkl->...ik", body, body, G))
    return np.concatenate([up, body], axis=-1)


def _value(numbers: Array, forms: Array) -> Array:
    """The largest cᵀ G c; numbers of two turns are those of their product."""
    if numbers.shape[-1] == 6:
        numbers = (numbers[..., :2, np.newaxis] * numbers[..., np.newaxis, 2:]).reshape(*numbers.shape[:-1], 8)
    return np.asarray(np.einsum("...i,...ij,...j->...", numbers, forms, numbers))


class Evidence:
    """An estimate beside the truth, as sums of which every explanation is judged.

    Parameters
    ----------
    track : Track
        Samples that have a truth whatever the lag is.
    longest_lag_s : float
    """

    def __init__(self, track: Track, longest_lag_s: float) -> None:
        self.track = track.part(spread(len(track.stamps_ns), SAMPLES))
        self.period_s = period_ns(track.stamps_ns) / 1e9
        self.longest_lag_s = longest_lag_s
        self._known: dict[tuple[int, Turned, bool], Explanation] = {}
        truth, rate = self.track.truth.states(self.track.stamps_ns)
        self.fastest = float(sizes(rate).max())
        self.still, self.spins = still(truth), spins(rate)
        self.floor = FLOOR * self.fastest * self.period_s

    def sums(self, lags_s: Array, most: int = SAMPLES) -> Array:
        """The matrices T of the quarters but the first, at each lag: shape (L, 3, 16, 16)."""
        few = self.track.part(spread(len(self.track.stamps_ns), most))
        P = products(few, few.stamps_ns - np.round(lags_s * 1e9).astype(np.int64)[:, np.newaxis])
        quarters = np.array_split(np.arange(len(few.stamps_ns)), 4)[1:]
        return np.stack([np.swapaxes(P[:, q], 1, 2) @ P[:, q] / len(q) for q in quarters], axis=1)

    @cached_property
    def _ahead(self) -> Array:
        """The sums at the leads of a right filter: none, half a sample and one."""
        leads = np.array([0.0, -0.5, -1.0]) * min(self.period_s, self.longest_lag_s)
        return self.sums(leads)

    def judged(self, turned: Turned, T: Array, number: int) -> tuple[Array, Array]:
        """What a form with turns leaves in each quarter, (..., 3), and its numbers, from T of (..., 3, 16, 16)."""
        base = _base(turned)[number]
        G = base @ T @ base.T
        whole = G.sum(axis=-3)
        others = whole[..., np.newaxis, :, :] - G
        if turned == BOTH:
            starts = _best_of_both(np.broadcast_to(whole.reshape(-1, 8, 8)[0], (6, 8, 8)), HEADINGS)
            first = starts[np.argmax(_value(starts, whole.reshape(-1, 8, 8)[0])), :2]
            numbers = _best_of_both(whole, np.broadcast_to(first, (*whole.shape[:-2], 2)))
            crossed = _best_of_both(others, np.broadcast_to(first, (*others.shape[:-2], 2)))
        else:
            numbers, crossed = _best(whole), _best(others)
        return 1.0 - _value(crossed, G), numbers

    def get(self, number: int, turned: Turned, *, late: bool = False) -> Explanation:
        """The explanation of a form with turns, with a lag or without."""
        key = number, turned, late
        if key not in self._known and late:
            self._known[key] = self._refined(number, turned)
        elif key not in self._known:
            left, numbers = self.judged(turned, self._ahead, number)
            lead = int(np.argmin(left.mean(axis=1)))
            self._known[key] = Explanation(FORMS[number], turned, left[lead], numbers[0])
        return self._known[key]

    @cached_property
    def _lags(self) -> Array:
        """Lags that are tried at first, s."""
        half = min(max(int(np.ceil(self.longest_lag_s * self.fastest / LAG_TURN)), 1), MOST_LAGS // 2)
        return np.linspace(-self.longest_lag_s, self.longest_lag_s, 2 * half + 1)

    @cached_property
    def _slack(self) -> float:
        """What a lag between two of these may leave less."""
        return float(np.sin(0.25 * min((self._lags[1] - self._lags[0]) * self.fastest, 2.0)) ** 2)

    @cached_property
    def _scanned(self) -> dict[Turned, Array]:
        """What each form leaves at these lags, (forms, L), with each of the turns that are tried beside a lag."""
        T, found = self.sums(self._lags, SCANNED).mean(axis=1), {}
        for turned in LATE:
            base = _base(turned)[:, np.newaxis]
            found[turned] = 1.0 - np.linalg.eigvalsh(base @ T @ np.swapaxes(base, -1, -2))[..., -1]
        return found

    def _refined(self, number: int, turned: Turned) -> Explanation:
        """The explanation with the nearest of the lags that leave about the least."""
        lags, cost = self._lags, self._scanned[turned][number]
        around = np.concatenate([[np.inf], cost, [np.inf]])
        lowest = np.flatnonzero((cost <= around[:-2]) & (cost <= around[2:]) & (cost <= cost.min() + self._slack))
        by_cost, by_size = (lowest[np.argsort(key, kind="stable")][:4] for key in (cost[lowest], np.abs(lags[lowest])))
        lowest = np.union1d(by_cost, by_size)
        found = [self._at_lag(number, turned, float(lags[k]), float(lags[1] - lags[0])) for k in lowest]
        least = min(_counted(e.left).mean() for e in found)
        as_good = [e for e in found if _counted(e.left).mean() <= TIE**2 * least]
        return min(as_good, key=lambda e: abs(e.lag_s or 0.0))

    def _at_lag(self, number: int, turned: Turned, lag_s: float, step: float) -> Explanation:
        """The explanation with the best lag near one: vertices of parabolas through three, ever nearer ones."""
        base = _base(turned)[number]
        for _ in range(4):
            three = np.clip(lag_s + step * np.array([-1.0, 0.0, 1.0]), -self.longest_lag_s, self.longest_lag_s)
            G = base @ self.sums(three) @ base.T
            whole = G.sum(axis=1)
            shift = _vertex(3.0 - np.linalg.eigvalsh(whole)[:, -1])
            lag_s, step = float(np.clip(three[1] + shift * step, three[0], three[2])), step / 5.0
        others = 2.0 - np.linalg.eigvalsh(whole[:, np.newaxis] - G)[..., -1]
        crossed = three[1] + 5.0 * step * np.array([_vertex(one) for one in others.T])
        T = self.sums(np.clip([lag_s, *crossed], -self.longest_lag_s, self.longest_lag_s))
        left, numbers = self.judged(turned, T, number)
        far = abs(lag_s) * self.fastest > np.pi
        return Explanation(FORMS[number], turned, left[[1, 2, 3], [0, 1, 2]], numbers[0], lag_s, far)

    def explanations(self) -> list[Explanation]:
        """Those that may be the best, the cheapest first."""
        found = [self.get(number, turned) for turned in TURNED for number in range(len(FORMS))]
        found.sort(key=lambda e: e.cost)
        turnable = dict.fromkeys(FORMS.index(e.form) for e in found if e.turned in LATE[1:])
        found += [self.get(number, BOTH) for number in list(turnable)[:MOST_BOTH]]
        lowest, promising = min(e.cost for e in found), []
        for turned, costs in self._scanned.items():
            for number, least in enumerate(costs.min(axis=1) - self._slack):
                trial = Explanation(FORMS[number], turned, np.array([least]), np.zeros(0), 0.0)
                if trial.cost < lowest:
                    promising.append((trial.cost, number, turned))
        found += [self.get(number, turned, late=True) for _, number, turned in sorted(promising)[:REFINED]]
        return sorted(found, key=lambda e: e.cost)

    def without(self, explanation: Explanation, cause: str) -> Explanation:
        """The explanation without one of its causes."""
        form, late = explanation.form, explanation.lag_s is not None and cause != "lag"
        codes = tuple(code for code in form.codes if code != cause)
        frd_body = form.frd_body and "ned_world" in codes
        number = next(n for n, other in enumerate(FORMS) if (other.codes, other.frd_body) == (codes, frd_body))
        turned = tuple(code for code in explanation.turned if code != cause)
        return self.get(number, turned, late=late)


def _vertex(three: Array) -> float:
    """Place of the least of a parabola through three even points, in steps from the middle one, at most one."""
    a, b, c = three.tolist()
    bend = a - 2.0 * b + c
    return float(np.clip(0.5 * (a - c) / bend, -1.0, 1.0)) if bend > 0.0 else float(np.argmin(three)) - 1.0


def is_needed(evidence: Evidence, explanation: Explanation) -> bool:
    """Whether an explanation leaves little beside the turn of the body, and each cause is needed in each quarter."""
    left = _counted(explanation.left)
    unlike = UNLIKE * (0.5 if "body_mounting" in explanation.turned else 1.0)
    if left.mean() > max(unlike**2 * evidence.still, _counted(np.zeros(1))[0]) or not explanation.explains:
        return False
    if explanation.lag_s is not None and -LEAD * evidence.period_s <= explanation.lag_s <= 0.0:
        return False
    if "world_turned" in explanation.turned:
        tilt = angles(quaternion.exp(vector(explanation.numbers))).inclination
        if not LEAST_TILT < tilt < np.pi - LEAST_TILT:
            return False
    if explanation.far and left.max() > UNEVEN**2 * left.min():
        return False
    for cause in explanation.causes:
        is_lag = cause == "lag" and abs(explanation.lag_s or 0.0) >= LEAST_LATE * evidence.period_s
        share = LAG_SHARE if is_lag and not evidence.spins else SHARE
        if np.any(left > share**2 * _counted(evidence.without(explanation, cause).left)):
            return False
    return True


def is_small(evidence: Evidence, explanation: Explanation, left_by_sensors: float) -> bool:
    """Whether one of the turns is no larger than what the sensors leave, or that in a lag that leaves some error."""
    turns_rad = [float(np.linalg.norm(constants)) for cause, constants in explanation.parts if cause.code in PRICES]
    if min(turns_rad, default=np.inf) <= max(left_by_sensors, evidence.floor):
        return True
    if explanation.lag_s is None or explanation.error <= FOLLOWING * evidence.without(explanation, "lag").error:
        return False
    return abs(explanation.lag_s) * evidence.fastest <= left_by_sensors
