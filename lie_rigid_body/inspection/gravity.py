"""Constant part of the specific force: gravity in some unit, none, or gravity less a constant of the sensor's axes."""

from __future__ import annotations

from collections.abc import Mapping
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


def nearest_unit(size: float, units: Mapping[str, float]) -> tuple[str, float, float]:
    """Unit in which a size is most like the one of a table, this, and the logarithm of their ratio."""
    unit, known = min(units.items(), key=lambda item: abs(np.log(size / item[1])))
    return unit, known, abs(float(np.log(size / known)))


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
    def has_unit(self) -> bool:
        """Whether the size is that of gravity in a known unit."""
        return nearest_unit(self.size, ACCELEROMETER_UNITS)[2] < SAME_UNIT

    @property
    def is_healthy(self) -> bool:
        """Whether the vector is gravity without an offset."""
        return self.has_unit and self.swing < MAX_SWING and self.offset < MIN_TAKEN_OFF

    @property
    def is_without_gravity(self) -> bool:
        """Whether there is no gravity in m/s²."""
        return self.size < MAX_NO_GRAVITY * GRAVITY

    def is_better_than(self, held: Weight) -> bool:
        """Whether the vector is gravity less a constant, compared with the fit that keeps offsets small."""
        is_gravity = self.has_unit and self.swing < MAX_SWING and self.offset > MIN_TAKEN_OFF
        gain = held.misfit * held.size / (self.misfit * self.size)
        return is_gravity and gain > (MIN_GAIN if held.has_unit else 1.0)


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
