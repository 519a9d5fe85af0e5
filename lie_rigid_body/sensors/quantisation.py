"""Saturation and quantisation of readings: the last stage of a sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import ParameterError

FINEST_RESOLUTION: Final = 1e-18
"""Finest step of a converter, in the sensor's unit: far finer than any instrument, and no count of steps overflows."""
_ROUND_OFF: Final = 2.0**-50
"""Relative round-off granted to a limit over a step: 0.3 holds three steps of 0.1, though 3 · 0.1 exceeds 0.3."""


@dataclass(frozen=True)
class Converter:
    """A converter that counts in steps, and saturates at the last step within its range.

    Parameters
    ----------
    resolution : float
        One step, in the unit of the reading; 0: continuous.
    range : float
        Largest size of a reading; 0: no limit.
    """

    resolution: float
    range: float

    def read(self, values: Array) -> Array:
        """The readings: the nearest multiple of the resolution, ties to even, that is within the range.

        Parameters
        ----------
        values : ndarray, shape (..., 3)

        Returns
        -------
        ndarray, shape (..., 3)
        """
        if self.range:
            values = _within(values, self.range)  # beyond it the number of steps may overflow
        if self.resolution:
            values = np.rint(values / self.resolution) * self.resolution
        return _within(values, self.largest_within(self.range)) if self.range else values

    def largest_within(self, limit: float) -> float:
        """The largest reading within a limit: the last multiple of the resolution."""
        if not self.resolution:
            return limit
        steps = float(np.floor(limit / self.resolution * (1.0 + _ROUND_OFF)))
        return min(steps * self.resolution, limit)

    @property
    def variance(self) -> float:
        """Variance that rounding adds to a signal that crosses many steps, resolution²/12."""
        return self.resolution * self.resolution / 12.0

    def validate(self, sensor: str) -> None:
        """Refuse a resolution that has no meaning.

        Parameters
        ----------
        sensor : str
            Begin of the names of its parameters.

        Raises
        ------
        ParameterError
            If the resolution is too fine for double precision, or coarser than the range.
        """
        name, step = f"{sensor}_resolution", self.resolution
        if 0.0 < step < FINEST_RESOLUTION:
            raise ParameterError(
                name, f"{step:g} is finer than {FINEST_RESOLUTION:g}, the finest step: give 0 for a continuous reading"
            )
        if self.range and step > self.range:
            raise ParameterError(
                name,
                f"{step:g} is more than {sensor}_range, {self.range:g}: give a finer resolution, or a range of 0 "
                "for none",
            )


def _within(values: Array, limit: float) -> Array:
    return np.asarray(np.minimum(np.maximum(values, -limit), limit))
