"""Constant part of the specific force: gravity in some unit, none, or gravity less a constant of the sensor's axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_UNITS,
    GRAVITY,
    MAX_NO_GRAVITY,
    MAX_SWING,
    MIN_GAIN,
    MIN_TAKEN_OFF,
    SAME_UNIT,
    SWING_LENGTH_S,
)
from lie_rigid_body.inspection.search import Misfits
from lie_rigid_body.inspection.world import gram, mean_vectors


class Weight(NamedTuple):
    """Constant part of a vector under the hypothesis that fits it best.

    Attributes
    ----------
    size : float
        RMS of its means, in the unit of the readings.
    swing : float
        RMS of the change from window to window, as a share of the size.
    offset : float
        Size of the offset, as a share of the size.
    misfit : float
        As a share of the size.
    """

    size: float
    swing: float
    offset: float
    misfit: float

    @property
    def unit(self) -> str | None:
        """The unit in which the size is that of gravity."""
        return next((unit for unit, g in ACCELEROMETER_UNITS.items() if abs(np.log(self.size / g)) < SAME_UNIT), None)

    @property
    def is_healthy(self) -> bool:
        """Whether the vector is gravity without an offset."""
        return self.unit is not None and self.swing < MAX_SWING and self.offset < MIN_TAKEN_OFF

    @property
    def is_without_gravity(self) -> bool:
        """Whether there is no gravity in m/s²."""
        return self.size < MAX_NO_GRAVITY * GRAVITY

    def is_better_than(self, held: Weight) -> bool:
        """Whether the vector is gravity less a constant, compared with the fit that keeps offsets small."""
        is_gravity = self.unit is not None and self.swing < MAX_SWING and self.offset > MIN_TAKEN_OFF
        gain = held.misfit * held.size / (self.misfit * self.size)
        return is_gravity and gain > (1.0 if held.unit is None else MIN_GAIN)


def weight(found: Misfits) -> Weight:
    """Weigh a vector under its best hypothesis."""
    _, gyro, delay_s, turn = found.best()
    length_s = min(found.lengths_s, key=lambda length: abs(length - SWING_LENGTH_S))
    windows, swinging = found.windows(gyro, delay_s, found.length_s, length_s)
    fit = found.vector.fit(gram(windows))
    means = mean_vectors(swinging, fit.column[turn])
    size = rms(np.linalg.norm(means, axis=1))
    swing = rms(np.linalg.norm(np.diff(means[::2], axis=0), axis=1))
    offset = float(np.linalg.norm(fit.constants[turn, :3]))
    return Weight(size * found.vector.size, swing / size, offset / size, float(fit.misfit[turn]) / size)
