"""Signals: the quantity that an instrument measures, and the converter that makes readings of it."""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.sensors.parameters import Values, values_of

MIN_RESOLUTION: Final = 1e-18
"""Finest step of a converter, in the sensor's unit: far finer than any instrument, and no count of steps overflows."""
_ROUND_OFF: Final = 2.0**-50
"""Relative round-off granted to a limit over a step: 0.3 holds three steps of 0.1, though 3 · 0.1 exceeds 0.3."""


@short_dataclass
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

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> Converter:
        """Make the converter of the parameters whose names begin with ``sensor``.

        Raises
        ------
        ParameterError
            If the resolution is too fine for double precision, or coarser than the range.
        """
        found = cls(**values_of(cls, sensor, values))
        name = f"{sensor}_resolution"
        step = found.resolution
        if 0.0 < step < MIN_RESOLUTION:
            raise ParameterError(
                name, f"{step:g} is finer than {MIN_RESOLUTION:g}, the finest step: give 0 for a continuous reading"
            )
        if found.range and step > found.range:
            raise ParameterError(
                name,
                f"{step:g} is more than {sensor}_range, {found.range:g}: give a finer resolution, or a range of 0 "
                "for none",
            )
        return found

    def read(self, values: Array) -> Array:
        """Readings of values: the nearest multiples of the resolution, ties to even, within the range.

        Parameters
        ----------
        values : ndarray, shape (..., 3)

        Returns
        -------
        ndarray, shape (..., 3)
        """
        if self.range:
            values = np.clip(values, -self.range, self.range)  # beyond it the number of steps may overflow
        if self.resolution:
            values = np.rint(values / self.resolution) * self.resolution
        return self.limited(values, self.range) if self.range else values

    def limited(self, values: Array, limit: float) -> Array:
        """Values that saturate at the largest reading within a limit."""
        step = self.resolution
        # the last multiple of the resolution
        largest = min((np.floor(limit / step * (1.0 + _ROUND_OFF))) * step, limit) if step else limit
        return np.clip(values, -largest, largest)

    @property
    def variance(self) -> float:
        """Variance that rounding adds to a signal that crosses many steps, resolution²/12."""
        return self.resolution * self.resolution / 12.0


CONTINUOUS: Final = Converter(0.0, 0.0)
"""The converter that changes nothing."""


@short_dataclass
class Signal:
    """One quantity of an instrument before its converter.

    Parameters
    ----------
    values : ndarray, shape (N, ...)
        In the unit of the reading.
    converter : Converter
        What makes readings of the values; by default the readings are the values.
    interval : float
        Time over which each value is a mean, s; 0: it is that of an instant.
    """

    values: Array
    converter: Converter = CONTINUOUS
    interval: float = 0.0

    def read(self) -> Array:
        """The readings, of the shape of the values."""
        return self.converter.read(self.values)


Signals: TypeAlias = dict[str, Signal]
"""The quantities of an instrument, by the names of their arrays."""
