"""How constant a vector is in the world that the gyro integrates: windows, one Gram matrix, and its least misfits.

A vector v that is constant in the world obeys dv/dt = −ω × v in the body. With the rotation R(t) from the body to the
gyro's own world, R P u is constant, where u are the readings and P permutes axes. The accelerometer reads accelerations
as well. Its mean with a Hann weight, stepped from one window to the next but one, leaves only a displacement over T².
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import interp1d
from scipy.linalg import block_diag

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    BIAS_COST,
    BLOCK_S,
    LENGTHS_S,
    MAX_DELAY_S,
    MAX_STEPS,
    MIN_LENGTHS,
    MIN_MISFIT,
    TURNS,
)
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.lie.vectors import norm

_FLAT_TURNS: Final = TURNS.reshape(-1, 9)
OF_TURNS: Final[Array] = np.pad(_FLAT_TURNS, ((0, 0), (0, 30)))
"""Column of each turn without constants, shape (24, 39).

It has 9 elements of the turn, 3 of an offset of the turned readings, and 27 of the turn's products with a rate bias."""
OF_CONSTANTS: Final[Array] = np.array(
    [-block_diag(np.zeros((9, 0)), np.eye(3), np.kron(turn[:, np.newaxis], np.eye(3))) for turn in _FLAT_TURNS]
)
"""Change of the column of each turn with an offset and a rate bias, rad/s, shape (24, 39, 6)."""


def integrated(t_s: Array, rate: Array) -> interp1d:
    """World of a gyro, by the mean rate of neighbours.

    Parameters
    ----------
    t_s : ndarray, shape (N,)
        Times of the readings, s, rising.
    rate : ndarray, shape (N, 3)
        Body rate, rad/s.

    Returns
    -------
    interp1d
        Between the readings, at ``x``, s, of arrays of shape (3, 6). They are the rotation from the body to the world,
        and its integral over time, s: how a rate bias turns the world.
    """
    steps = np.diff(cumulative_trapezoid(rate, t_s, axis=0, initial=0), axis=0, prepend=0.0)
    rotation = quaternion.to_matrix(quaternion.running_product(quaternion.exp(steps)))
    integral = cumulative_trapezoid(rotation, t_s, axis=0, initial=0)
    return interp1d(t_s, np.concatenate([rotation, integral], axis=2), axis=0, copy=False, assume_sorted=True)


def gram(windows: Array, chunks: int = 1) -> Array:
    """Gram matrices of the steps of successive chunks, shape (chunks, 39, 39), whose sum is their mean square.

    Parameters
    ----------
    windows : ndarray, shape (W, 3, 15)
    chunks : int
    """
    every = max((len(windows) - 2) // MAX_STEPS, 1)
    before = windows[:-2:every]
    after = windows[2::every]
    steps = after - before
    turned = so3.hat(((after + before) / 2.0)[..., :9].swapaxes(1, 2))
    by_bias = turned @ steps[:, np.newaxis, :, 12:]
    columns = np.concatenate([steps[..., :12], by_bias.swapaxes(1, 2).reshape(-1, 3, 27)], axis=2)
    parts = [part.reshape(-1, 39) for part in np.array_split(columns, chunks)]
    # a copy: the product of an array with its own transpose waits for the threads of the library
    return np.array([part.T @ part.copy() for part in parts]) / len(steps)


@dataclass(eq=False)
class Vector:
    """Readings of a sensor whose vector is constant in the world.

    Attributes
    ----------
    sensor : str
    t_s : ndarray, shape (N,)
        Times, s, within those of the gyro.
    readings : ndarray, shape (N, 3)
    offset_cost : float
        Squared misfit that an offset of 1 costs.
    world : callable
        World of a gyro, by its multiplier.
    size : float
        RMS of the readings.
    unit : ndarray, shape (N, 3)
        Readings over it.
    lengths_s : tuple of float
        Lengths of windows, s, of which there are enough, with readings in each.
    """

    sensor: str
    t_s: Array
    readings: Array
    offset_cost: float
    world: Callable[[float], interp1d]

    def __post_init__(self) -> None:
        self.size = rms(norm(self.readings))
        self.unit = self.readings / self.size
        span_s = np.diff(self.t_s).sum()
        longest = (span_s - 2.0 * MAX_DELAY_S) / MIN_LENGTHS
        self.lengths_s = tuple(each for each in LENGTHS_S if each <= longest and 2.0 * span_s <= each * len(self.t_s))

    def windows(self, gyro: float, delay_s: float, *lengths_s: float) -> Iterator[Array]:
        """Hann means over windows that start half a length apart, of the readings, true some time before their stamps.

        They are averaged over short blocks first.

        Yields
        ------
        ndarray, shape (W, 3, 15)
            For each length nine products R_ia u_b, by i and by (a, b), the rotation R, and its integral. The products
            times the elements of a turn P, row by row, are R P u.
        """
        world = self.world(gyro)
        t_s = self.t_s - delay_s
        inside = np.flatnonzero((t_s >= world.x[0]) & (t_s <= world.x[-1]))
        period = np.diff(t_s).mean()
        size = max(int(BLOCK_S / period), 1)
        rows = inside[: len(inside) // size * size].reshape(-1, size)
        placed = world(t_s[rows])
        rotation = placed[..., :3].reshape(-1, size, 9)
        products = rotation.swapaxes(1, 2) @ self.unit[rows] / size
        blocks = np.concatenate([products.reshape(-1, 3, 9), placed.mean(axis=1)], axis=2)
        for length_s in lengths_s:
            half = round(length_s / (size * period) / 2.0)
            views = sliding_window_view(blocks, 2 * half, axis=0)[::half]
            yield views @ (np.hanning(2 * half + 1)[:-1] / half)

    def fit(self, grams: Array) -> Fit:
        """Fit every turn to the Gram matrices of chunks, each with its own offset and rate bias."""
        return least_misfit(grams.sum(axis=0), OF_TURNS, OF_CONSTANTS, self.costs)

    @property
    def costs(self) -> Array:
        """Squared misfits that offsets of 1 and rate biases of 1 rad/s cost, shape (6,)."""
        return np.repeat([self.offset_cost, BIAS_COST], 3)


class Fit(NamedTuple):
    """Least misfit of models, and the constants at which it is.

    Attributes
    ----------
    misfit : ndarray, shape (...)
        Not below `MIN_MISFIT`: smaller ones are not told apart.
    constants : ndarray, shape (..., C)
    column : ndarray, shape (..., 39)
        Combination of the columns of the Gram matrix that is the misfit.
    inverse : ndarray, shape (..., C, C)
        Inverse of the matrix of the equations of the constants.
    """

    misfit: Array
    constants: Array
    column: Array
    inverse: Array


def least_misfit(total: Array, start: Array, changes: Array, costs: Array) -> Fit:
    """Least squares of columns, start + changes · constants, in which each constant has a cost.

    Parameters
    ----------
    total : ndarray, shape (39, 39)
        Gram matrix.
    start : ndarray, shape (..., 39)
    changes : ndarray, shape (..., 39, C)
    costs : ndarray, shape (C,)
        Squared misfit that a constant of 1 costs.
    """
    normal = changes.swapaxes(-1, -2) @ total
    inverse = np.linalg.inv(normal @ changes + np.diag(costs))
    constants = -np.einsum("...ij,...j->...i", inverse @ normal, start)
    column = start + np.einsum("...ij,...j->...i", changes, constants)
    squared = np.sum(column @ total * column, axis=-1) + constants**2 @ costs
    return Fit(np.sqrt(np.maximum(squared, MIN_MISFIT**2)), constants, column, inverse)
