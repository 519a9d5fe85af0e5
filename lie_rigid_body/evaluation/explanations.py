"""Explanations of the error of an estimate, the evidence by which they are judged, and the choice of one of them.

An explanation is a chain of causes without a constant, then at most two with constants: turns of the world and of the
body, and a lag. Every one is judged by one number a quarter of the run, from the second on (in the first a filter may
converge). It is the mean of sin² of half of the error that is left, with the constants fitted to the other quarters.

The rule: the best explanation has the least cost, in units of halved errors: log₂ of the error that it leaves, plus its
price. It is named if each of its causes is needed: without that cause the error is at least `1 / SHARE` times as large
in each quarter but the first. So drifts, random walks and noise are no causes, as a constant fitted to some quarters
does not fit the others. A right filter may be ahead by up to a sample, as it compares readings with the attitude before
its gyro step. Every explanation without a lag may have such a lead at no price, and it is no cause.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, reduce
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.causes import (
    BY_CODE,
    Parts,
    heading,
    late,
    vector,
)
from lie_rigid_body.evaluation.matched import (
    floored,
)
from lie_rigid_body.foundation.arrays import Array

PRICES: Final = {
    "heading_offset": 1.25,
    "world_turned": 2.3,
    "body_mounting": 2.3,
    "lag": 1.25,
    "far": 1.0,
    "pair": 0.3,
}
"""Prices of causes with constants, in halved errors; a cause without a constant costs 1.

A far lag, in which the body turns by more than half a turn, has a further price, as there are many. So has any turn of
the world with any of the body, which other axes of a gyro make as well.
"""
MAX_LEFT: Final = math.radians(20.0)
"""Largest error that named causes may leave, rad; if one of them has a constant, divided by their number."""
MAX_LEFT_BY_THREE: Final = math.radians(7.7)
"""Largest error that a cause with three constants may leave, rad, divided by the number of causes with constants."""
SHARE: Final = 1.0 / 3.0
"""Largest ratio of the RMS error with a named cause to that without the cause, in each quarter of a run."""

Turned = tuple[str, ...]
"""Turns of the world and of the body, in the order of undoing."""
Form = tuple[tuple[str, int], ...]
"""A chain of causes without constants in the order of undoing, each with the number of its map."""
_SHIFTED = ("scalar_first", 0)
_INVERTED = ("inverted", 0)
FORMS: Final = tuple(
    (*written, *world)
    for written in ((), (_SHIFTED,), (_INVERTED,), (_SHIFTED, _INVERTED), (_INVERTED, _SHIFTED))
    for world in ((), (("ned_world", 0),), (("ned_world", 1),))
)
"""Every chain; the first has no cause."""
TURNED: Final = ((), ("heading_offset",), ("world_turned",), ("body_mounting",))
BOTH: Final = ("heading_offset", "body_mounting")
"""Turns that are fitted together, as the heading of a compass and the axes of markers."""
PAIRS: Final = (BOTH, ("world_turned", "body_mounting"))
"""Turns of the world and of the body together; `TURNED` are those that are tried alone."""
LATE: Final = (TURNED[0], TURNED[1], TURNED[3])
"""Turns that are tried together with every lag."""
BY_RATES: Final = (TURNED[2], *PAIRS)
"""Turns that are tried together with lags at which the estimate turns as fast as the body."""
_NUMBERS: Final = {
    "heading_offset": (heading, slice(2)),
    "world_turned": (vector, slice(4)),
    "body_mounting": (vector, slice(-4, None)),
}
"""Constants of turns by fitted numbers, and where these are among those of an explanation."""


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
        Fitted quaternion numbers of the turns.
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

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes in the order in which they are undone."""
        return (*(code for code, _ in self.form), *self.turned, *(() if self.lag_s is None else ("lag",)))

    @property
    def fitted(self) -> int:
        """Number of causes with constants."""
        return len(self.causes) - len(self.form)

    @property
    def fits_anything(self) -> bool:
        """Whether a rotation of the world is beside a lag or a mounting: together they fit nearly anything."""
        return "world_turned" in self.turned and self.fitted > 1

    @property
    def error(self) -> float:
        """Root mean square of the error that remains, rad."""
        return float(2.0 * np.arcsin(np.sqrt(np.clip(np.mean(self.left), 0.0, 1.0))))

    @property
    def explains(self) -> bool:
        """Whether so little remains that the causes are what is wrong: many constants fit anything to some degrees."""
        if {"world_turned", "body_mounting"} & {*self.turned}:
            return self.error <= MAX_LEFT_BY_THREE / self.fitted
        return self.error <= MAX_LEFT / (len(self.causes) if self.fitted else 1)

    @property
    def cost(self) -> float:
        """Cost in halved errors, which the choice minimises: log₂ of the error left, plus prices."""
        simple = sum(PRICES.get(cause, 1.0) for cause in self.causes) + PRICES["far"] * self.far
        simple += PRICES["pair"] * (self.turned == PAIRS[1])
        # of two that do the same by nature: without other axes of the body, and with the smaller mounting
        simple += 0.02 * (("ned_world", 1) in self.form)
        if "body_mounting" in self.turned and self.numbers.size:
            simple += 0.04 * np.linalg.norm(vector(self.numbers[-4:])) / np.pi
        return float(np.mean(0.5 * np.log2(floored(self.left)))) + simple

    @property
    def parts(self) -> Parts:
        """The causes of the table with their constants, as fitted so far."""
        forms = [(BY_CODE[code], np.array([float(number)])) for code, number in self.form]
        turns = [(BY_CODE[code], _NUMBERS[code][0](self.numbers[_NUMBERS[code][1]])) for code in self.turned]
        return [*forms, *turns, *([] if self.lag_s is None else [late(self.lag_s)])]


@cache
def matrix(form: Form) -> Array:
    """Matrix that undoes a chain of causes, shape (4, 4)."""
    return reduce(lambda undoing, part: BY_CODE[part[0]].maps[part[1]][0] @ undoing, form, np.eye(4))


@cache
def base_of(form: Form, turned: Turned) -> Array:
    """Basis of the repairs of a form followed by turns, shape (d, 16)."""
    maps = np.eye(4)[np.newaxis]
    for code in turned:
        maps = (maps[:, np.newaxis] @ BY_CODE[code].maps[0]).reshape(-1, 4, 4)
    return (maps @ matrix(form)).reshape(-1, 16)


def best(forms: Array) -> Array:
    """Unit vectors c of the largest cᵀ G c for each matrix G, shape (..., d)."""
    return np.linalg.eigh(forms)[1][..., -1]


def best_of_pair(forms: Array, first: Array) -> Array:
    """Quaternion numbers of a turn of the world (2 or 4) and of the body (4), fitted alternately, (..., 6 or 8)."""
    G = forms.reshape(*forms.shape[:-2], -1, 4, forms.shape[-1] // 4, 4)
    world = first
    for _ in range(8):
        body = best(np.einsum("...i,...k,...ijkl->...jl", world, world, G))
        world = best(np.einsum("...j,...l,...ijkl->...ik", body, body, G))
    return np.concatenate([world, body], axis=-1)


def start_of_pair(forms: Array) -> Array:
    """Numbers of the turn of the world from which the fit of a pair leaves least, by sums of shape (d, d).

    Starts are the left singular vectors of the best product of any numbers, which is near that of two quaternions.
    """
    starts = np.linalg.svd(best(forms).reshape(-1, 4), full_matrices=False)[0].T
    return np.asarray(starts[np.argmax(value(best_of_pair(forms, starts), forms))])


def largest(turned: Turned, forms: Array) -> Array:
    """Largest value of fitted numbers for each matrix of sums, shape (..., d, d)."""
    if turned not in PAIRS:
        return np.linalg.eigvalsh(forms)[..., -1]
    return value(best_of_pair(forms, start_of_pair(forms.reshape(-1, *forms.shape[-2:]).mean(axis=0))), forms)


def value(numbers: Array, forms: Array) -> Array:
    """Value cᵀ G c of fitted numbers c; for two turns c is the product of their numbers."""
    if numbers.shape[-1] != forms.shape[-1]:
        product = numbers[..., :-4, np.newaxis] * numbers[..., np.newaxis, -4:]
        numbers = product.reshape(*numbers.shape[:-1], -1)
    return np.asarray(np.einsum("...i,...ij,...j->...", numbers, forms, numbers))
