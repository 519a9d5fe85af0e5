"""How constant a vector is in the world that the gyro integrates: windows, one Gram matrix, and its least misfits.

A vector v that is constant in the world obeys dv/dt = −ω × v in the body. With the rotation R(t) from the body to the
gyro's own world, R P u is constant, where u are the readings and P permutes axes. The accelerometer reads accelerations
as well. Its mean with a Hann weight, stepped from one window to the next but one, leaves only a displacement over T².
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import BIAS_COST, BLOCK_S, MAX_STEPS, MIN_MISFIT, MIN_WINDOWS, TURNS
from lie_rigid_body.lie import quaternion, so3

COLUMNS: Final = 39
"""Columns of the Gram matrix: 9 of the turn, 27 of its change with a rate bias, 3 of an offset."""


@dataclass(frozen=True)
class World:
    """Rotation of the body by its gyro, from the first reading on.

    Attributes
    ----------
    t_s : ndarray, shape (N,)
        Times of the readings, s, rising.
    rate : ndarray, shape (N, 3)
        Body rate, rad/s.
    rotation : ndarray, shape (N, 3, 3)
        From the body to the world.
    integral : ndarray, shape (N, 3, 3)
        Integral of the rotation over time, s: how a rate bias turns the world.
    """

    t_s: Array
    rate: Array
    rotation: Array
    integral: Array

    @classmethod
    def of_rate(cls, t_s: Array, rate: Array) -> World:
        """Integrate body rates by the mean of neighbours, in a scan that doubles its reach."""
        steps = np.diff(t_s)[:, np.newaxis]
        attitude = np.vstack([[0.0, 0.0, 0.0, 1.0], quaternion.exp((rate[1:] + rate[:-1]) / 2.0 * steps)])
        reach = 1
        while reach < len(attitude):
            attitude[reach:] = quaternion.multiply(attitude[:-reach], attitude[reach:])
            reach *= 2
        rotation = quaternion.to_matrix(attitude)
        means = (rotation[1:] + rotation[:-1]) / 2.0
        integral = np.concatenate([np.zeros((1, 3, 3)), np.cumsum(means * steps[..., np.newaxis], axis=0)])
        return cls(t_s, rate, rotation, integral)

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """Rotation and its integral at times within, shape (M, 3, 3) each: to first order from the nearest reading."""
        after = np.clip(np.searchsorted(self.t_s, t_s), 1, len(self.t_s) - 1)
        nearest = after - (t_s - self.t_s[after - 1] < self.t_s[after] - t_s)
        since = (t_s - self.t_s[nearest])[:, np.newaxis]
        rotation = self.rotation[nearest]
        moved = rotation + rotation @ so3.hat(self.rate[nearest] * since)
        return moved, self.integral[nearest] + rotation * since[..., np.newaxis]


class Windows(NamedTuple):
    """Hann means over W windows that start half a length apart.

    Attributes
    ----------
    products : ndarray, shape (W, 3, 9)
        Of R_ia u_b, by i and by (a, b): times the elements of a turn P, row by row, they are R P u.
    rotations, integrals : ndarray, shape (W, 3, 3)
        Of the rotation, and of its integral, s.
    """

    products: Array
    rotations: Array
    integrals: Array

    def vectors(self, turn: int, offset: Array) -> Array:
        """Mean vectors in the world, shape (W, 3), of a turn by its index and an offset, shape (3,)."""
        return np.asarray(self.products @ TURNS[turn].ravel() - self.rotations @ offset)

    def gram(self, chunks: int = 1) -> Array:
        """Gram matrices of the steps of successive chunks, shape (chunks, 39, 39), whose sum is their mean square."""
        first = np.arange(0, len(self.products) - 2, max((len(self.products) - 2) // MAX_STEPS, 1))
        second = first + 2
        means = (self.products[first] + self.products[second]) / 2.0
        integrals = (self.integrals[second] - self.integrals[first])[:, np.newaxis]
        by_bias = so3.hat(means.swapaxes(1, 2)) @ integrals
        steps = np.concatenate(
            [
                self.products[second] - self.products[first],
                by_bias.transpose(0, 2, 1, 3).reshape(len(first), 3, 27),
                self.rotations[second] - self.rotations[first],
            ],
            axis=2,
        )
        parts = [part.reshape(-1, COLUMNS) for part in np.array_split(steps, chunks)]
        # a copy: the product of an array with its own transpose waits for the threads of the library
        return np.array([part.T @ part.copy() for part in parts]) / len(first)


@dataclass(frozen=True)
class Blocks:
    """Means over short blocks of the products of readings and rotations.

    Attributes
    ----------
    period_s : float
        Length of a block, s.
    values : ndarray, shape (M, 45)
        27 products R_ia u_b, 9 elements of R, 9 of its integral.
    """

    period_s: float
    values: Array

    def has(self, length_s: float) -> bool:
        """Whether there are enough windows of a length, s, and blocks in each."""
        duration = len(self.values) * self.period_s
        return length_s >= 2.0 * self.period_s and 2.0 * duration / length_s - 3.0 >= MIN_WINDOWS

    def windows(self, length_s: float) -> Windows:
        """Hann means over windows of a length, s: each is the sum of a rising and a falling half."""
        half = round(length_s / self.period_s / 2.0)
        weights = np.hanning(2 * half + 1)[:-1] / half
        count = len(self.values) // half
        halves = self.values[: count * half].reshape(count, half, -1)
        rising = np.einsum("k,wkc->wc", weights[:half], halves)
        falling = np.einsum("k,wkc->wc", weights[half:], halves)
        means = rising[:-1] + falling[1:]
        return Windows(
            means[:, :27].reshape(-1, 3, 9), means[:, 27:36].reshape(-1, 3, 3), means[:, 36:].reshape(-1, 3, 3)
        )


@dataclass(frozen=True, eq=False)
class Vector:
    """Readings of a sensor whose vector is constant in the world.

    Attributes
    ----------
    sensor : str
    t_s : ndarray, shape (N,)
    unit : ndarray, shape (N, 3)
        Readings over their RMS.
    size : float
        This RMS.
    offset_cost : float
        Squared misfit that an offset of 1 costs.
    """

    sensor: str
    t_s: Array
    unit: Array
    size: float
    offset_cost: float

    @classmethod
    def of_readings(cls, sensor: str, t_s: Array, readings: Array, offset_cost: float) -> Vector:
        """Divide readings by their RMS."""
        size = float(np.sqrt(np.mean(np.sum(readings**2, axis=1))))
        return cls(sensor, t_s, readings / size, size, offset_cost)

    def blocks(self, world: World, delay_s: float) -> Blocks:
        """Blocks of the readings, which were true some time before their stamps, s."""
        t_s = self.t_s - delay_s
        inside = (t_s >= world.t_s[0]) & (t_s <= world.t_s[-1])
        t_s = t_s[inside]
        period = float(np.ptp(t_s)) / (len(t_s) - 1)
        size = max(int(BLOCK_S / period), 1)
        count = len(t_s) // size
        used = count * size
        rotation, integral = (each.reshape(count, size, 9) for each in world.at(t_s[:used]))
        products = rotation.swapaxes(1, 2) @ self.unit[inside][:used].reshape(count, size, 3) / size
        values = np.concatenate([products.reshape(count, 27), rotation.mean(axis=1), integral.mean(axis=1)], axis=1)
        return Blocks(size * period, values)


def _of_turns() -> Array:
    """Column of each turn without constants, shape (24, 39)."""
    columns = np.zeros((len(TURNS), COLUMNS))
    columns[:, :9] = TURNS.reshape(-1, 9)
    return columns


def _of_constants() -> Array:
    """Change of the column of each turn with a rate bias and an offset, shape (24, 39, 6)."""
    changes = np.zeros((len(TURNS), COLUMNS, 6))
    changes[:, 9:36, :3] = -np.einsum("pa,ij->paij", TURNS.reshape(-1, 9), np.eye(3)).reshape(-1, 27, 3)
    changes[:, 36:, 3:] = -np.eye(3)
    return changes


OF_TURNS: Final = _of_turns()
OF_CONSTANTS: Final = _of_constants()


class Fit(NamedTuple):
    """Least misfit of each of K models, and the constants at which it is.

    Attributes
    ----------
    misfit : ndarray, shape (K,)
    constants : ndarray, shape (K, C)
    column : ndarray, shape (K, 39)
        Combination of the columns of the Gram matrix that is the misfit.
    """

    misfit: Array
    constants: Array
    column: Array

    @property
    def told(self) -> Array:
        """Misfits that are told apart: not below `MIN_MISFIT`."""
        return np.maximum(self.misfit, MIN_MISFIT)


def least_misfit(gram: Array, start: Array, changes: Array, costs: Array) -> Fit:
    """Least squares of columns, start + changes · constants, in which each constant has a cost.

    Parameters
    ----------
    gram : ndarray, shape (39, 39)
    start : ndarray, shape (K, 39)
    changes : ndarray, shape (K, 39, C)
    costs : ndarray, shape (C,)
        Squared misfit that a constant of 1 costs.
    """
    normal = changes.swapaxes(1, 2) @ gram @ changes + np.diag(costs)
    right = np.einsum("kci,cd,kd->ki", changes, gram, start)
    constants = -np.linalg.solve(normal, right[..., np.newaxis])[..., 0]
    column = start + np.einsum("kci,ki->kc", changes, constants)
    squared = np.einsum("kc,cd,kd->k", column, gram, column) + constants**2 @ costs
    return Fit(np.sqrt(np.maximum(squared, 0.0)), constants, column)


def costs_of(offset_cost: float) -> Array:
    """Costs of a rate bias and an offset, shape (6,)."""
    return np.repeat([BIAS_COST, offset_cost], 3)


def fit_turns(gram: Array, offset_cost: float) -> Fit:
    """Fit every turn, each with its own rate bias, rad/s, and offset of the turned readings, shape (24, 6)."""
    return least_misfit(gram, OF_TURNS, OF_CONSTANTS, costs_of(offset_cost))
