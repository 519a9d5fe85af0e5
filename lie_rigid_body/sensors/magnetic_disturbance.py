"""A magnetic disturbance that passes: something of iron comes by, or a current flows for a while."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.parameters import Value
from lie_rigid_body.sensors.episodes import Episodes
from lie_rigid_body.sensors.fault import AXES, Fault

_KIND: Final = "magnetic_disturbance"
_SENSOR: Final = "magnetometer"


@dataclass(frozen=True)
class MagneticDisturbance:
    """A field that comes and goes in the world: its size times (1 − s²)², with s from −1 to 1 over an episode.

    Parameters
    ----------
    episodes : Episodes
    size : float
        Magnitude at its height, T; the direction in the world is drawn evenly over the sphere.
    """

    episodes: Episodes
    size: float

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> MagneticDisturbance | None:
        """Make the disturbance of the parameters; None if there is none.

        Raises
        ------
        ParameterError
        """
        episodes = Episodes.from_values(values, _SENSOR, _KIND, _KIND)
        return None if episodes is None else cls(episodes, cast(float, values[f"{_KIND}_size"]))

    def field(self, times_ns: Integers) -> Array:
        """The field in the world at some times since the segment's start, shape (N, 3), T."""
        numbers = self.episodes.at(times_ns)
        inside = np.flatnonzero(numbers >= 0)
        field = np.zeros((len(times_ns), 3))
        age = times_ns[inside] - self.episodes.begins_ns(numbers[inside])
        s = 2.0 * age / self.episodes.duration_ns - 1.0
        bump = 1.0 - s * s
        field[inside] = (bump * bump)[:, np.newaxis] * self._heights(numbers[inside])
        return field

    def _heights(self, numbers: Integers) -> Array:
        """The field at the height of each episode, shape (N, 3), T."""
        from scipy.special import ndtri  # slow to import: not before there is a disturbance

        # the direction of three normal deviates is uniform on the sphere
        x, y, z = ndtri(self.episodes.draws(numbers)).T
        return np.asarray(self.size * np.stack([x, y, z], axis=-1) / np.sqrt(x * x + y * y + z * z)[:, np.newaxis])

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> list[Fault]:
        """Faults that begin in a stretch of time, one for each axis of the world; see `Faulty`."""
        return [
            Fault(_KIND, _SENSOR, axis, begin, end, size)
            for number, begin, end in self.episodes.between(begin_ns, end_ns)
            for axis, size in zip(AXES, self._heights(np.array([number]))[0].tolist(), strict=True)
        ]
