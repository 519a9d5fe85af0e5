"""Signals: the quantity that an instrument measures, its converter, and how far another computer's value may differ."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.sensors.parameters import Values, values_of

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

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> Converter:
        """Make the converter of the parameters whose names begin with ``sensor``.

        Raises
        ------
        ParameterError
            If the resolution is too fine for double precision, or coarser than the range.
        """
        found, name = cls(**values_of(cls, sensor, values)), f"{sensor}_resolution"
        step = found.resolution
        if 0.0 < step < FINEST_RESOLUTION:
            raise ParameterError(
                name, f"{step:g} is finer than {FINEST_RESOLUTION:g}, the finest step: give 0 for a continuous reading"
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
        largest = min(float(np.floor(limit / step * (1.0 + _ROUND_OFF))) * step, limit) if step else limit
        return np.asarray(np.clip(values, -largest, largest))

    @property
    def variance(self) -> float:
        """Variance that rounding adds to a signal that crosses many steps, resolution²/12."""
        return self.resolution * self.resolution / 12.0


@short_dataclass(frozen=True)
class Conditioning:
    """Sensitivity of a signal to round-off and to errors of the body's state.

    Parameters
    ----------
    numbers : ndarray, shape (3, N, 1) or (3, N, 3)
        For each reading, on all axes alike or on each. First the sum of the absolute values of the parts that the
        signal is added up from, as they were drawn, of which the round-off is a multiple. Then the change of the signal
        per rad of an error of the attitude, and its change per rad/s of an error of the body rate.
    span : float
        Time over which that rate is a mean, s; 0: it is that of an instant.
    """

    numbers: Array
    span: float = 0.0

    @classmethod
    def of(
        cls, size: Array, per_attitude: Array | float = 0.0, per_rate: Array | float = 0.0, span: float = 0.0
    ) -> Conditioning:
        """The conditioning of given numbers for each reading, shape (N,), all axes alike."""
        return cls(np.stack(np.broadcast_arrays(size, per_attitude, per_rate))[..., np.newaxis], span)

    def scaled(self, gains: Array | float) -> Conditioning:
        """The conditioning of a signal that is multiplied by a number, or by one on each axis."""
        return replace(self, numbers=gains * self.numbers)

    def enlarged(self, part: Array | float) -> Conditioning:
        """The conditioning of a signal that has one more part of this size on each axis."""
        parts = np.zeros((3, *np.broadcast_shapes(self.numbers.shape[1:], np.shape(part))))
        parts[0] = part
        return replace(self, numbers=self.numbers + parts)


@short_dataclass(frozen=True)
class Signal:
    """One quantity of an instrument before its converter.

    Parameters
    ----------
    values : ndarray, shape (N, ...)
        In the unit of the reading.
    converter : Converter or None
        What makes readings of the values; None: the readings are the values.
    condition : callable or None
        Makes the `Conditioning` of the values, which only a certificate asks for. None: that of a vector which is known
        in the world.
    """

    values: Array
    converter: Converter | None = None
    condition: Callable[[], Conditioning] | None = None

    def read(self) -> Array:
        """The readings, of the shape of the values."""
        return self.values if self.converter is None else self.converter.read(self.values)

    def conditioning(self) -> Conditioning:
        """Sensitivity of the values to round-off and to errors of the body's state."""
        if self.condition is not None:
            return self.condition()
        size = np.sqrt(np.sum(self.values * self.values, axis=-1))
        return Conditioning.of(size, per_attitude=size)

    def through(self, matrix: Array) -> Signal:
        """The signal on axes whose sensitivities are the rows of a matrix, shape (3, 3)."""
        gains = so3.norm(matrix)
        values = apply_tensor(matrix, self.values)
        return replace(self, values=values, condition=lambda: self.conditioning().scaled(gains))

    def plus(self, part: Array, roundings: Callable[[], Array | float] = lambda: 0.0) -> Signal:
        """The signal with one more part.

        Parameters
        ----------
        part : ndarray, shape (N, 3) or (3,)
        roundings : callable, optional
            Makes the size, shape (N, 3), of which the part has roundings beside those of its own size.
        """
        values = self.values + part
        return replace(self, values=values, condition=lambda: self.conditioning().enlarged(np.abs(part) + roundings()))

    def held(self, rows: Integers, before: Signal | None) -> Signal:
        """The signal with the values of other rows, chosen for each axis.

        Parameters
        ----------
        rows : ndarray of int64, shape (N, 3)
            Number of the other row; −1: the last row of the signal before.
        before : Signal or None
            Signal before this one; None if no row asks for it.
        """
        earlier = self[:1] if before is None else before

        def conditioning() -> Conditioning:
            own = self.conditioning()
            return replace(own, numbers=_held(earlier.conditioning().numbers, own.numbers, rows))

        return replace(self, values=_held(earlier.values, self.values, rows), condition=conditioning)

    def __getitem__(self, rows: slice) -> Signal:
        """Some readings as a copy, which does not keep the others in memory."""
        whole = self.conditioning()
        some = replace(whole, numbers=whole.numbers[:, rows].copy())
        return replace(self, values=self.values[rows].copy(), condition=lambda: some)


def _held(before: Array, values: Array, rows: Integers) -> Array:
    """The rows of values, shape (..., N, 1) or (..., N, 3), on each axis; −1 is the last row before."""
    shape = (*values.shape[:-2], *rows.shape)
    wide = [np.broadcast_to(part, (*shape[:-2], part.shape[-2], 3)) for part in (before[..., -1:, :], values)]
    return np.asarray(np.take_along_axis(np.concatenate(wide, axis=-2), np.broadcast_to(rows + 1, shape), axis=-2))
