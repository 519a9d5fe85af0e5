"""Readings of a sensor, replayed with the exact motion, and the bounds of a faithful reading.

A reading is computed by the simulation's own instruments, from the exact motion. Before saturation and rounding the
recorded signal may differ from it by t = max(L, 1e-12) (m + 1/Δt). Here L is the limit of the attitude's error, m the
largest size of the signal up to then, and 1/Δt stands for gyros that integrate over an interval Δt. Saturation and
rounding keep the order of numbers. So a faithful reading lies between the two that the ends of this range become.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.certificate.limits import max_attitude_error
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.sensors.signal import Converter, Signal
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.samples import Measurement

MIN_READING_ERROR: Final = 1e-12
"""Least limit of a signal's relative error: libraries differ in last bits, and parts of a sum may cancel."""
REPLAY_BLOCK: Final = 8192
"""Largest number of readings replayed at once."""
MOST_DRAWN: Final = 200_000_000
"""Largest number of normal deviates drawn for readings that a bag lacks, as a bias walks through them. Drawing so many
takes 5 s."""
_LONGEST_GAP: Final = 256
"""Largest gap between two recorded readings, in readings, that is replayed; a longer gap is skipped."""
_MAX_PIECES: Final = 4
"""Number of replayed pieces kept for a topic that lags behind the sensor's others, or for a message out of order."""
_CONTINUOUS: Final = Converter(0.0, 0.0)


@dataclass(frozen=True)
class Expected:
    """Expected readings of a sensor, with their uncertainty.

    Parameters
    ----------
    signal : ndarray, shape (N, K)
        Values before saturation and quantisation, unit of the reading.
    uncertainty : ndarray, shape (N, 1)
        Largest difference of a faithful recording's signal from this one, unit of the reading.
    converter : Converter
    """

    signal: Array
    uncertainty: Array
    converter: Converter = _CONTINUOUS

    def __getitem__(self, rows: slice | Integers) -> Expected:
        return Expected(self.signal[rows], self.uncertainty[rows], self.converter)

    @cached_property
    def values(self) -> Array:
        """The readings, shape (N, K)."""
        return self.converter.read(self.signal)

    def residuals(self, recorded: Array) -> tuple[Array, Callable[[], Array]]:
        """Distances of recorded readings from these, and their limits, on the worst axis; shape (N,) each."""
        distance = np.abs(recorded - self.values)
        if not distance.any():  # as of one's own recordings; then no axis is worse than the first
            return distance[:, 0], lambda: self._allowed(recorded)[:, 0]
        allowed = self._allowed(recorded)
        axis = np.argmax(np.where(distance <= allowed, distance, np.inf), axis=1)
        at = axis + np.arange(0, distance.size, distance.shape[1])
        return distance.take(at), lambda: allowed.take(at)

    def _allowed(self, recorded: Array) -> Array:
        read, values = self.converter.read, self.values
        low, high = read(self.signal - self.uncertainty), read(self.signal + self.uncertainty)
        allowed = np.where(recorded > values, high - values, values - low)
        if self.converter.resolution:
            allowed = np.where((recorded == values) | (read(recorded) == recorded), allowed, 0.0)
        return allowed


@dataclass(frozen=True)
class Piece:
    """Consecutive replayed readings of one sensor.

    Parameters
    ----------
    first : int
        Number of the first reading.
    times_ns : ndarray of int64, shape (N,)
        Arrival times, ns.
    arrays : mapping of str to Expected
        Expected readings, by the names of their arrays.
    """

    first: int
    times_ns: Integers
    arrays: Mapping[str, Expected]

    @property
    def end(self) -> int:
        """Number of the reading behind the last one."""
        return self.first + len(self.times_ns)


class Replays:
    """Replays of a bag, for each sensor that of its latest segment, with a limit of the deviates drawn.

    Parameters
    ----------
    max_attitude : float, optional
        Limit of the attitude's error, rad, in place of that of the declared motion.
    """

    def __init__(self, max_attitude: float | None = None) -> None:
        self._max_attitude = max_attitude
        self._left, self._last = MOST_DRAWN, dict[str, Replay]()

    def of(self, segment: Segment, name: str) -> Replay:
        """The replay of a sensor in a segment; see `Replay` for the parameters."""
        known = self._last.get(name)
        if known is None or known.segment is not segment:
            limit = max_attitude_error(segment.scenario) if self._max_attitude is None else self._max_attitude
            known = self._last[name] = Replay(segment, name, limit, self)
        return known

    def allow(self, count: int) -> bool:
        """Take ``count`` deviates from the number that may be drawn; return False if that is too small."""
        if count > self._left:
            return False
        self._left -= count
        return True


class Replay:
    """The readings of one sensor in one segment, replayed as they are asked for.

    Parameters
    ----------
    segment : Segment
    name : str
        Name of the sensor.
    limit : float
        Limit L of the attitude's error, rad.
    replays : Replays
        Replays of the whole bag, which limit the deviates.
    """

    def __init__(self, segment: Segment, name: str, limit: float, replays: Replays) -> None:
        self.segment, self._name, self._replays = segment, name, replays
        self._relative_error = max(limit, MIN_READING_ERROR)
        self._largest = dict[str, float]()
        self._measurement = self._begun()
        self._pieces: list[Piece] = []

    def _begun(self) -> Measurement:
        return Measurement(self.segment, self._name, self.segment.scenario.exact_motion())

    def piece(self, numbers: Integers) -> Piece | None:
        """Replayed readings from the first of some rising numbers on; None if the gap before is too long."""
        first = int(numbers[0])
        for known in self._pieces:
            if known.first <= first < known.end:
                return known
        if first < self._measurement.next:
            self._measurement = self._begun()
        if not self._replays.allow(self._measurement.walk_deviates * (first - self._measurement.next)):
            return None
        near = numbers[: np.searchsorted(numbers, first + REPLAY_BLOCK)]
        gaps = np.flatnonzero(np.diff(near) > _LONGEST_GAP)
        last = int(near[gaps[0]] if len(gaps) else near[-1])
        self._pieces = [*self._pieces[1 - _MAX_PIECES :], self._replayed(first, last + 1 - first)]
        return self._pieces[-1]

    def _replayed(self, first: int, count: int) -> Piece:
        self._measurement.begin_at(first)
        times, _, signals = self._measurement.replay(count)
        return Piece(first, times, {name: self._expected(name, signal) for name, signal in signals.items()})

    def _expected(self, name: str, signal: Signal) -> Expected:
        """Expected readings of a signal, with their uncertainty."""
        values = signal.values.reshape(len(signal.values), -1)
        sizes = np.sqrt(np.einsum("ij,ij->i", values, values))
        largest = np.maximum(np.maximum.accumulate(sizes), self._largest.get(name, 0.0))
        self._largest[name] = float(largest[-1])
        turn = 1.0 / signal.interval if signal.interval else 0.0
        uncertainty = self._relative_error * (largest + turn)
        return Expected(values, uncertainty[:, np.newaxis], signal.converter or _CONTINUOUS)
