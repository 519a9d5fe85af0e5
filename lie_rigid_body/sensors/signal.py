"""Signals: what an instrument measures before its converter, and how far another computer may find it otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class Conditioning:
    """What decides how far a signal may differ: its round-off, and what errors of the body's state make of it.

    Parameters
    ----------
    numbers : ndarray, shape (3, N, 1) or (3, N, 3)
        For each reading, on all axes alike or on each: the sum of the absolute values of the parts that the signal is
        added up from, as they were drawn, of which the round-off is a multiple; the change of the signal per rad of an
        error of the attitude; and its change per rad/s of an error of the body rate.
    span : float
        Time over which that rate is a mean, s; 0: it is that of an instant.
    """

    numbers: Array
    span: float = 0.0

    __repr__ = short_repr

    @classmethod
    def of(
        cls, size: Array, per_attitude: Array | float = 0.0, per_rate: Array | float = 0.0, span: float = 0.0
    ) -> Conditioning:
        """The conditioning of these numbers for each reading, shape (N,), all axes alike."""
        return cls(np.stack(np.broadcast_arrays(size, per_attitude, per_rate))[..., np.newaxis], span)

    @property
    def size(self) -> Array:
        """Sum of the sizes of the parts, in the unit of the signal, shape (N, 1) or (N, 3)."""
        return np.asarray(self.numbers[0])

    @property
    def per_attitude(self) -> Array:
        """Change of the signal per rad of an error of the attitude, shape (N, 1) or (N, 3)."""
        return np.asarray(self.numbers[1])

    @property
    def per_rate(self) -> Array:
        """Change of the signal per rad/s of an error of the body rate, shape (N, 1) or (N, 3)."""
        return np.asarray(self.numbers[2])

    def enlarged(self, part: Array | float) -> Conditioning:
        """The conditioning of a signal that has one more part of this size on each axis."""
        parts = np.zeros((3, *np.broadcast_shapes(self.size.shape, np.shape(part))))
        parts[0] = part
        return replace(self, numbers=self.numbers + parts)


@dataclass(frozen=True)
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

    __repr__ = short_repr

    def read(self) -> Array:
        """The readings, of the shape of the values."""
        return self.values if self.converter is None else self.converter.read(self.values)

    def conditioning(self) -> Conditioning:
        """How far the values may differ elsewhere."""
        if self.condition is not None:
            return self.condition()
        size = np.sqrt(np.sum(self.values * self.values, axis=-1))
        return Conditioning.of(size, per_attitude=size)

    def through(self, matrix: Array) -> Signal:
        """The signal on axes whose sensitivities are the rows of a matrix, shape (3, 3)."""
        gains = so3.norm(matrix)
        values = apply_tensor(matrix, self.values)
        return replace(self, values=values, condition=lambda: self._scaled(gains))

    def _scaled(self, gains: Array) -> Conditioning:
        whole = self.conditioning()
        return replace(whole, numbers=gains * whole.numbers)

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
        """The signal with, on each axis, what it is in another row.

        Parameters
        ----------
        rows : ndarray of int64, shape (N, 3)
            Number of that row; −1: the last row of the signal before.
        before : Signal or None
            That signal; None: no row asks for it.
        """
        earlier = self[:1] if before is None else before

        def conditioning() -> Conditioning:
            own = self.conditioning()
            return replace(own, numbers=_held(earlier.conditioning().numbers, own.numbers, rows))

        return replace(self, values=_held(earlier.values, self.values, rows), condition=conditioning)

    def __getitem__(self, rows: slice) -> Signal:
        """Some readings, which keep no memory of the others."""
        whole = self.conditioning()
        some = replace(whole, numbers=whole.numbers[:, rows].copy())
        return replace(self, values=self.values[rows].copy(), condition=lambda: some)


def _held(before: Array, values: Array, rows: Integers) -> Array:
    """The rows of values, shape (..., N, 1) or (..., N, 3), on each axis; −1 is the last row before."""
    shape = (*values.shape[:-2], *rows.shape)
    wide = [np.broadcast_to(part, (*shape[:-2], part.shape[-2], 3)) for part in (before[..., -1:, :], values)]
    return np.asarray(np.take_along_axis(np.concatenate(wide, axis=-2), np.broadcast_to(rows + 1, shape), axis=-2))
