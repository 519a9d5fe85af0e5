"""Constants of an explanation with their standard errors: the gyro's factor, delays, rate bias, hard and soft iron.

Standard errors come from the scatter between successive chunks of the log. With the curvature H of the squared misfit
and the slope g of each chunk, σ = √Σ(g − ḡ)² / H.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    BIAS_COST,
    CHUNKS,
    DELAY_STEPS_S,
    EXCLUDED,
    FREE_OFFSET_COST,
    INDEPENDENT_STEPS,
    LOG_FACTOR_STEPS,
    MAX_NEWTON_STEPS,
    MIN_DELAY_S,
    MIN_GAIN,
    MIN_HARD_IRON,
    MIN_MISFIT,
    MIN_UNSEEN_S,
    SAME_DELAY_S,
    SHAPE_COST,
    SIGMAS,
    TURNS,
    UNSEEN_SHARE,
    Gyro,
)
from lie_rigid_body.inspection.search import Misfits, Worlds
from lie_rigid_body.inspection.world import OF_CONSTANTS, OF_TURNS, Blocks, World, costs_of, fit_turns, least_misfit


class Newton(NamedTuple):
    """Minimum of a squared misfit from its values at −1, 0 and 1 steps.

    Attributes
    ----------
    step : float
        Where it is, at most 1 away.
    sigma : float
        Its standard error, in steps.
    curvature : float
        Half of the second difference.
    level : float
        Misfit at 0.
    """

    step: float
    sigma: float
    curvature: float
    level: float


@dataclass(frozen=True)
class Delay:
    """Delay of a vector against the gyro.

    Attributes
    ----------
    delay_s, sigma_s : float
    slope : float
        Root of the curvature of the squared misfit, 1/s.
    level : float
        Misfit at the delay.
    """

    delay_s: float
    sigma_s: float
    slope: float
    level: float

    @property
    def gain(self) -> float:
        """Ratio of the misfit without the delay to that with it."""
        return float(np.hypot(1.0, self.slope * self.delay_s / max(self.level, MIN_MISFIT)))

    @property
    def unseen_s(self) -> float:
        """Delay up to which this log does not see one, s."""
        dim = UNSEEN_SHARE * max(self.level, MIN_MISFIT) / max(self.slope, 1e-9)
        return max(MIN_DELAY_S, SIGMAS * self.sigma_s, dim)

    def is_like(self, other: Delay) -> bool:
        """Whether two delays are one of the gyro, as far as the log sees."""
        return abs(self.delay_s - other.delay_s) < max(MIN_UNSEEN_S, self.unseen_s, other.unseen_s)

    @property
    def is_late(self) -> bool:
        """Whether the delay is a mistake."""
        return abs(self.delay_s) > max(MIN_DELAY_S, SIGMAS * self.sigma_s) and self.gain > MIN_GAIN


class Placed(NamedTuple):
    """A vector with its turn and its delay, s."""

    misfits: Misfits
    turn: int
    delay_s: float

    def blocks(self, world: World) -> Blocks:
        """Blocks at the delay."""
        return self.misfits.vector.blocks(world, self.delay_s)

    def squares(self, world: World, length_s: float) -> Array:
        """Squared misfits of the chunks, at the constants that fit all of them, shape (chunks,)."""
        grams = self.blocks(world).windows(length_s).gram(CHUNKS)
        column = fit_turns(grams.sum(axis=0), self.misfits.vector.offset_cost).column[self.turn]
        return np.asarray(grams @ column @ column)


def newton(before: Array, here: Array, after: Array) -> Newton:
    """Minimum from the squared misfits of the chunks at three places."""
    slopes = (after - before) / 2.0
    second = float(np.sum(after + before - 2.0 * here))
    level = float(np.sqrt(max(here.sum(), 0.0)))
    if second <= 0.0:
        return Newton(0.0, np.inf, 0.0, level)
    sigma = float(np.sqrt(np.sum((slopes - slopes.mean()) ** 2))) / second
    return Newton(float(np.clip(-slopes.sum() / second, -1.0, 1.0)), sigma, second / 2.0, level)


def _delay_newton(placed: Placed, world: World, step_s: float, length_s: float) -> Newton:
    places = [placed._replace(delay_s=placed.delay_s + i * step_s) for i in (-1, 0, 1)]
    return newton(*(place.squares(world, length_s) for place in places))


def fit_delay(placed: Placed, world: World, step_s: float) -> Delay:
    """Fit a delay in the windows in which the squared misfit bends most against its least value."""
    tried = {length: _delay_newton(placed, world, step_s, length) for length in placed.misfits.lengths_s}
    length_s = max(tried, key=lambda length: tried[length].curvature / max(tried[length].level, MIN_MISFIT) ** 2)
    for _ in range(MAX_NEWTON_STEPS):
        found = _delay_newton(placed, world, step_s, length_s)
        placed = placed._replace(delay_s=placed.delay_s + found.step * step_s)
        if abs(found.step) < 1.0:
            break
    return Delay(placed.delay_s, found.sigma * step_s, np.sqrt(found.curvature) / step_s, found.level)


def other_delays(placed: Placed, gyro: Gyro, world: World, own: Delay) -> tuple[float, ...]:
    """Delays away from the fitted one that fit as well, s: of motions that recur."""
    delays, misfits = placed.misfits.by_delay(gyro)
    values = misfits[:, placed.turn]
    inner = np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] < values[2:])) + 1
    found = [fit_delay(placed._replace(delay_s=float(delays[i])), world, DELAY_STEPS_S[0]) for i in inner]
    return tuple(
        each.delay_s
        for each in found
        if each.level <= EXCLUDED * max(own.level, MIN_MISFIT) and abs(each.delay_s - own.delay_s) > SAME_DELAY_S
    )


@dataclass(frozen=True)
class Refined:
    """Factor of the gyro and delays at the least misfit.

    Attributes
    ----------
    gyro : Gyro
    log_factor_sigma : float
        Standard error of the logarithm of its factor.
    delays : tuple of Delay
        Of each vector.
    """

    gyro: Gyro
    log_factor_sigma: float
    delays: tuple[Delay, ...]


def _gyro(sign: int, log_factor: float) -> Gyro:
    return Gyro(sign, round(float(np.exp(log_factor)), 9))


def _factor_newton(placed: Sequence[Placed], worlds: Worlds, gyro: Gyro, step: float) -> tuple[float, float]:
    """Weighted step of the logarithm of the factor from one place, and its standard error."""
    around = [_gyro(gyro.sign, np.log(gyro.factor) + i * step) for i in (-1, 0, 1)]
    squares = [[each.squares(worlds.of(one), each.misfits.length_s) for each in placed] for one in around]
    found = [newton(*three) for three in zip(*squares, strict=True)]
    weights = np.array([max(each.sigma, 1e-6) ** -2 for each in found])
    if not weights.sum():
        return 0.0, np.inf
    return float(weights @ [each.step for each in found] / weights.sum()), step / float(np.sqrt(weights.sum()))


def _fit_factor(placed: Sequence[Placed], worlds: Worlds, gyro: Gyro, step: float) -> tuple[Gyro, float]:
    """Factor of the gyro at which all vectors fit best, and the standard error of its logarithm."""
    for _ in range(MAX_NEWTON_STEPS):
        moved, sigma = _factor_newton(placed, worlds, gyro, step)
        gyro = _gyro(gyro.sign, np.log(gyro.factor) + moved * step)
        if abs(moved) < 1.0:
            break
    return gyro, sigma


def refine(placed: Sequence[Placed], worlds: Worlds, gyro: Gyro) -> Refined:
    """Fit delays and the gyro's factor in turn, from those of an explanation on."""
    sigma = np.inf
    for i, step_s in enumerate(DELAY_STEPS_S):
        delays = [fit_delay(each, worlds.of(gyro), step_s) for each in placed]
        placed = [each._replace(delay_s=delay.delay_s) for each, delay in zip(placed, delays, strict=True)]
        if i < len(LOG_FACTOR_STEPS):
            gyro, sigma = _fit_factor(placed, worlds, gyro, LOG_FACTOR_STEPS[i])
    return Refined(gyro, sigma, tuple(delays))


class Shape(NamedTuple):
    """Fit of a vector whose turn may stretch and shear as well, as soft iron does.

    Attributes
    ----------
    misfit : float
    offset : float
        Size of the offset, as a share of the readings' RMS.
    matrix, matrix_sigma : ndarray, shape (3, 3)
        Stretch and shear on the sensor's axes with standard errors: near the identity for none.
    """

    misfit: float
    offset: float
    matrix: Array
    matrix_sigma: Array


@dataclass(frozen=True, eq=False)
class Constants:
    """A vector under the chosen explanation.

    Attributes
    ----------
    misfit : float
        Share of the vector.
    size : float
        RMS of what is constant in the world, in the unit of the readings.
    rate_bias, rate_bias_sigma : ndarray, shape (3,)
        Of the gyro, rad/s, in its frame.
    offset, offset_sigma : ndarray, shape (3,)
        Of the readings, on the sensor's axes, in their unit.
    offset_share : float
        Size of the offset over that of the vector.
    offset_share_sigma : float
    offset_gain : float
        Ratio of the misfit without an offset to that with it.
    seen : float
        Ratio of the misfit with `MIN_HARD_IRON` along the direction in which it is seen least to the misfit.
    blind : ndarray, shape (3,)
        This direction, on the sensor's axes.
    shape : Shape
        Fit in which the turn may stretch and shear.
    """

    misfit: float
    size: float
    rate_bias: Array
    rate_bias_sigma: Array
    offset: Array
    offset_sigma: Array
    offset_share: float
    offset_share_sigma: float
    offset_gain: float
    seen: float
    blind: Array
    shape: Shape


def constants_of(placed: Placed, world: World) -> Constants:
    """Fit what is constant of a vector in the windows that tell most about it."""
    vector = placed.misfits.vector
    turn = placed.turn
    windows = placed.blocks(world).windows(placed.misfits.length_s)
    grams = windows.gram(CHUNKS)
    gram = grams.sum(axis=0)
    fit = fit_turns(gram, vector.offset_cost)
    misfit = float(fit.told[turn])
    offset = fit.constants[turn, 3:]
    size = rms(np.linalg.norm(windows.vectors(turn, offset), axis=1))
    back = TURNS[turn].T
    errors = _standard_errors(grams, fit.column[turn], OF_CONSTANTS[turn], costs_of(vector.offset_cost))
    offset_errors = np.abs(back) @ errors[3:]
    least, blind = _dimmest(gram, turn)
    held = fit_turns(gram, FREE_OFFSET_COST).told[turn]
    return Constants(
        misfit,
        size * vector.size,
        fit.constants[turn, :3],
        errors[:3],
        back @ offset * vector.size,
        offset_errors * vector.size,
        float(np.linalg.norm(offset)) / size,
        rms(offset_errors) / size,
        float(held) / misfit,
        float(np.sqrt(1.0 + least * (MIN_HARD_IRON * size / misfit) ** 2)),
        back @ blind,
        _shape(grams, turn, vector.offset_cost),
    )


def _standard_errors(grams: Array, column: Array, changes: Array, costs: Array) -> Array:
    """Standard errors of fitted constants, shape (C,).

    To the scatter of the slopes of the chunks comes the misfit itself, which scale and mounting of the gyro make alike
    in all chunks. It counts as that of `INDEPENDENT_STEPS` steps.
    """
    gram = grams.sum(axis=0)
    slopes = grams @ column @ changes
    inverse = np.linalg.inv(changes.T @ gram @ changes + np.diag(costs))
    moved = inverse @ (slopes - slopes.mean(axis=0)).T
    squared = max(float(column @ gram @ column), MIN_MISFIT**2)
    return np.asarray(np.sqrt(np.sum(moved**2, axis=1) + np.diag(inverse) * squared / INDEPENDENT_STEPS))


def _dimmest(gram: Array, turn: int) -> tuple[float, Array]:
    """Least growth of the squared misfit with an offset, whatever the rate bias, and its direction."""
    changes = OF_CONSTANTS[turn]
    normal = changes.T @ gram @ changes
    of_bias = normal[:3, :3] + BIAS_COST * np.eye(3)
    of_offset = normal[3:, 3:] - normal[3:, :3] @ np.linalg.solve(of_bias, normal[:3, 3:])
    growth, directions = np.linalg.eigh(of_offset)
    return max(float(growth[0]), 0.0), directions[:, 0]


def _shape(grams: Array, turn: int, offset_cost: float) -> Shape:
    elements = TURNS[turn].ravel()
    others = np.linalg.svd(elements[np.newaxis])[2][1:].T  # 8 directions square to the turn
    stretch = np.zeros((grams.shape[1], 8))
    stretch[:9] = others
    changes = np.hstack([stretch, OF_CONSTANTS[turn]])
    costs = np.concatenate([np.full(8, SHAPE_COST), costs_of(offset_cost)])
    fit = least_misfit(grams.sum(axis=0), OF_TURNS[turn : turn + 1], changes[np.newaxis], costs)
    errors = _standard_errors(grams, fit.column[0], changes, costs)
    back = TURNS[turn].T
    return Shape(
        float(fit.told[0]),
        float(np.linalg.norm(fit.constants[0, 11:])),
        back @ (elements + others @ fit.constants[0, :8]).reshape(3, 3),
        np.abs(back) @ np.sqrt((others * errors[:8]) ** 2 @ np.ones(8)).reshape(3, 3),
    )
