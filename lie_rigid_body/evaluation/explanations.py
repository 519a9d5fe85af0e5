"""Explanations of the error of an estimate: causes with their constants, what they leave, and what they cost.

An explanation is a chain of causes without a constant, then at most two with constants: turns of the world and of the
body, and a lag. Every one is judged by one number a quarter of the run, from the second on (in the first a filter may
converge). It is the mean of sin² of half of the error that is left, with the constants fitted to the other quarters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.causes import BY_CODE, Part, heading, late, vector

PRICES: Final = {"heading_offset": 1.25, "world_turned": 2.3, "body_mounting": 2.3, "lag": 1.25, "far": 1.0}
"""Prices of causes with constants, in halved errors; a cause without a constant costs 1.

A far lag, in which the body turns by more than half a turn, has a further price, as there are many.
"""
NEGLIGIBLE: Final = float(np.radians(1e-3))
"""Error that needs no explanation, rad; a smaller one counts as this."""
LARGEST_LEFT: Final = float(np.radians(20.0))
"""Largest error that named causes may leave, rad; if one of them has a constant, divided by their number."""
LEFT_BY_THREE: Final = float(np.radians(7.7))
"""Largest error that a cause with three constants may leave, rad, divided by the number of causes with constants."""

Turned = tuple[str, ...]
"""Turns of the world and of the body, in the order of undoing."""
Form = tuple[tuple[str, int], ...]
"""A chain of causes without constants in the order of undoing, each with the number of its map."""
_SHIFTED, _INVERTED = ("scalar_first", 0), ("inverted", 0)
FORMS: Final[tuple[Form, ...]] = tuple(
    (*written, *world)
    for written in ((), (_SHIFTED,), (_INVERTED,), (_SHIFTED, _INVERTED), (_INVERTED, _SHIFTED))
    for world in ((), (("ned_world", 0),), (("ned_world", 1),))
)
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
    def error(self) -> float:
        """Root mean square of the error that is left, rad."""
        return float(2.0 * np.arcsin(np.sqrt(np.clip(np.mean(self.left), 0.0, 1.0))))

    @property
    def explains(self) -> bool:
        """Whether so little is left that the causes are what is wrong: many constants fit anything to some degrees."""
        constants = len(self.causes) - len(self.form)
        if {"world_turned", "body_mounting"} & {*self.turned}:
            return self.error <= LEFT_BY_THREE / constants
        return self.error <= LARGEST_LEFT / (len(self.causes) if constants else 1)

    @property
    def cost(self) -> float:
        """Cost in halved errors, which the choice minimises: log₂ of the error left, plus prices."""
        simple = sum(PRICES.get(cause, 1.0) for cause in self.causes) + PRICES["far"] * self.far
        # of two that do the same by nature: without other axes of the body, and with the smaller mounting
        simple += 0.02 * (("ned_world", 1) in self.form)
        if "body_mounting" in self.turned and self.numbers.size:
            simple += 0.04 * float(np.linalg.norm(vector(self.numbers[-4:]))) / np.pi
        return float(np.mean(0.5 * np.log2(counted(self.left)))) + simple

    @property
    def parts(self) -> list[Part]:
        """The causes of the table with their constants, as fitted so far."""
        forms = [(BY_CODE[code], np.array([float(number)])) for code, number in self.form]
        turns = [
            (BY_CODE[code], heading(self.numbers[:2]) if code == "heading_offset" else vector(self.numbers[-4:]))
            for code in self.turned
        ]
        return [*forms, *turns, *([] if self.lag_s is None else [late(self.lag_s)])]


def counted(left: Array) -> Array:
    """Mean sin² of half of the error left in each quarter, raised to that of `NEGLIGIBLE` where it is less."""
    return np.asarray(np.maximum(left, np.sin(0.5 * NEGLIGIBLE) ** 2))


@cache
def matrix(form: Form) -> Array:
    """Matrix that undoes a chain of causes, shape (4, 4)."""
    undoing = np.eye(4)
    for code, number in form:
        undoing = BY_CODE[code].maps[number][0] @ undoing
    return undoing
