"""Constants of an explanation with their standard errors: the gyro's factor, delays, rate bias, hard and soft iron.

Standard errors come from the scatter between successive chunks of the log.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.minimum import Minimum, minimum
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_UNITS,
    CHUNKS,
    DELAY_STEP_S,
    EXCLUDED,
    FINE_DELAY_STEP_S,
    INDEPENDENT_STEPS,
    LOG_FACTOR_STEPS,
    MAX_SWING,
    MIN_DELAY_S,
    SAME_DELAY_S,
    SAME_UNIT,
    SHAPE_COST,
    SWING_LENGTH_S,
    TURNS,
    UNSEEN_SHARE,
    nearest_unit,
)
from lie_rigid_body.inspection.search import Fitting
from lie_rigid_body.inspection.world import OF_CONSTANTS, OF_TURNS, Fit, gram, least_misfit
from lie_rigid_body.lie.vectors import norm


def fit_delay(placed: Fitting, step_s: float) -> tuple[Fitting, Minimum]:
    """Fit a delay in the windows in which the squared misfit bends most against its least value."""
    length_s = min(placed.misfits.lengths_s, key=lambda length: placed.fit_delay(length, step_s, 1).width)
    delay = placed.fit_delay(length_s, step_s)
    return placed._replace(delay_s=delay.place), delay


def other_delays(placed: Fitting, tried: float, own: Minimum) -> list[float]:
    """Delays away from the fitted one that fit as well, s: of motions that recur; of a fitted one that is none, none.

    Parameters
    ----------
    placed : Fitting
    tried : float
        Gyro with which delays were tried.
    own : Minimum
    """
    if abs(own.place) <= MIN_DELAY_S:
        return []
    delays, misfits = placed.misfits.by_delay(tried)
    lowest = 1 + np.flatnonzero(np.diff(np.sign(np.diff(misfits[:, placed.turn]))) > 1.0)
    found = [fit_delay(placed._replace(delay_s=delays[i]), DELAY_STEP_S)[1] for i in lowest]
    alike = [each.place for each in found if each.level <= EXCLUDED * own.level]
    return [place for place in alike if abs(place - own.place) > SAME_DELAY_S]


def refine(placed: Sequence[Fitting]) -> tuple[Minimum, list[tuple[Fitting, Minimum]]]:
    """Fit delays and the gyro's factor in turn, from those of an explanation on.

    Returns
    -------
    factor : Minimum
        Logarithm of the gyro's factor.
    fitted : list of (Fitting, Minimum)
        The vectors with this factor and their delays, and these.
    """
    gyro = placed[0].gyro

    def of_factor(log_factor: float) -> Array:
        """Squared misfits of the chunks of all vectors, each over that of the vector."""
        other = np.copysign(np.exp(log_factor), gyro)
        return np.concatenate(
            [each._replace(gyro=other).squares(each.misfits.length_s) / delay.level**2 for each, delay in fitted]
        )

    fitted = [fit_delay(each, DELAY_STEP_S) for each in placed]
    for step in LOG_FACTOR_STEPS:
        factor = minimum(of_factor, np.log(abs(gyro)), step)
        gyro = np.copysign(np.exp(factor.place), gyro)
        fitted = [fit_delay(each._replace(gyro=gyro), FINE_DELAY_STEP_S) for each, _ in fitted]
    return factor, fitted


class Constants(NamedTuple):
    """A vector under the chosen explanation, in a unit and on axes of the sensor.

    Attributes
    ----------
    misfit : float
        Share of the vector.
    means : ndarray, shape (W, 3)
        What is constant in the world, in windows of about `SWING_LENGTH_S` that start half a length apart.
    rate_bias, rate_bias_sigma : ndarray, shape (3,)
        Bias of the gyro, rad/s, in its frame.
    offset, offset_sigma : ndarray, shape (3,)
        Offset of the readings.
    growth : ndarray, shape (3, 3)
        Curvature of the squared misfit along the offset, whatever the rate bias.
    shape, shape_sigma : ndarray, shape (3, 3)
        Stretch and shear, as of soft iron, with standard errors: near the identity for none.
    shape_misfit : float
        Misfit with them.
    shape_offset, shape_offset_sigma : ndarray, shape (3,)
        Offset of the readings with them.
    """

    misfit: float
    means: Array
    rate_bias: Array
    rate_bias_sigma: Array
    offset: Array
    offset_sigma: Array
    growth: Array
    shape: Array
    shape_sigma: Array
    shape_misfit: float
    shape_offset: Array
    shape_offset_sigma: Array

    @property
    def size(self) -> float:
        """RMS of the means."""
        return rms(norm(self.means))

    @property
    def swing(self) -> float:
        """RMS of the change of the means from window to window, over their size."""
        return rms(norm(np.diff(self.means[::2], axis=0))) / self.size

    @property
    def offset_share(self) -> float:
        """Size of the offset over that of the vector."""
        return np.linalg.norm(self.offset) / self.size

    @property
    def has_unit(self) -> bool:
        """Whether the size is that of gravity in a known unit."""
        return nearest_unit(self.size, ACCELEROMETER_UNITS)[0] < SAME_UNIT

    @property
    def is_gravity(self) -> bool:
        """Whether the vector is gravity: it has its size, and stays."""
        return self.has_unit and self.swing < MAX_SWING

    def sees(self, share: Array) -> bool:
        """Whether the misfit grows by `MIN_GAIN` with another offset, by so much of the vector."""
        return bool(share @ self.growth @ share > (UNSEEN_SHARE * self.misfit / self.size) ** 2)

    @property
    def blind(self) -> Array:
        """Direction in which an offset is seen least, shape (3,)."""
        return np.linalg.eigh(self.growth)[1][:, 0]


def constants_of(placed: Fitting, repair: Array | float = 1.0) -> Constants:
    """Fit what is constant of a vector in the windows that tell most about it.

    Parameters
    ----------
    placed : Fitting
    repair : ndarray, shape (3, 3), or float, optional
        From the readings to the unit and the axes of the constants: a factor times axes that change places and signs.
    """
    vector = placed.misfits
    turn = TURNS[placed.turn]
    start = OF_TURNS[placed.turn]
    changes = OF_CONSTANTS[placed.turn]
    length_s = min(vector.lengths_s, key=lambda length: abs(length - SWING_LENGTH_S))
    windows, longer = vector.windows(placed.gyro, placed.delay_s, vector.length_s, length_s)
    grams = gram(windows, CHUNKS)
    fit, errors = _fitted(grams, start, changes, vector.costs)
    others = null_space(turn.reshape(1, 9))  # 8 directions square to the turn
    stretched = np.hstack([changes, np.pad(others, ((0, 30), (0, 0)))])
    shape, shape_errors = _fitted(grams, start, stretched, np.append(vector.costs, np.full(8, SHAPE_COST)))
    to_readings = np.dot(repair, turn.T) * vector.size
    scale = norm(to_readings[0])
    axes = to_readings / scale
    back = turn.T @ axes.T
    stretch = axes @ (turn + (others @ shape.constants[6:]).reshape(3, 3)) @ back
    growth = np.linalg.inv(fit.inverse[:3, :3]) - vector.offset_cost * np.eye(3)
    return Constants(
        float(fit.misfit),
        longer[..., :12] @ fit.column[:12] * scale,
        fit.constants[3:],
        errors[3:],
        to_readings @ fit.constants[:3],
        np.abs(to_readings) @ errors[:3],
        axes @ growth @ axes.T / scale**2,
        stretch,
        np.abs(axes) @ np.linalg.norm(others * shape_errors[6:], axis=1).reshape(3, 3) @ np.abs(back),
        float(shape.misfit),
        np.linalg.solve(stretch, to_readings @ shape.constants[:3]),
        np.abs(to_readings) @ shape_errors[:3],
    )


def _fitted(grams: Array, start: Array, changes: Array, costs: Array) -> tuple[Fit, Array]:
    """Fit of constants to the Gram matrices of chunks, and their standard errors.

    To the scatter of the slopes of the chunks comes the misfit itself, which scale and mounting of the gyro make alike
    in all chunks. It counts as that of `INDEPENDENT_STEPS` steps.
    """
    fit = least_misfit(grams.sum(axis=0), start, changes, costs)
    slopes = grams @ fit.column @ changes
    moved = fit.inverse @ (slopes - slopes.mean(axis=0)).T
    variances = np.sum(moved**2, axis=1) + np.diag(fit.inverse) * fit.misfit**2 / INDEPENDENT_STEPS
    return fit, np.sqrt(variances)
