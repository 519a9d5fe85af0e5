"""Readings of a sensor, replayed with the exact motion, and the bounds of a faithful reading.

A reading is computed by the simulation's own instruments, from the exact motion. Before saturation and rounding the
recorded signal may differ from it by t = max(L, 1e-12) (m + 1/Δt). Here L is the limit of the attitude's error, m the
largest size of the signal up to then, and 1/Δt stands for gyros that integrate over an interval Δt. Saturation and
rounding keep the order of numbers. So a faithful reading lies between the two that the ends of this range become.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.certificate.limits import LargestSoFar, max_attitude_error
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.sensors.signal import Converter, Signal
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.samples import Measurement

MIN_READING_ERROR: Final = 1e-12
"""Least limit of a signal's relative error: libraries differ in last bits, and parts of a sum may cancel."""
REPLAY_BLOCK: Final = 8192
"""Largest number of readings replayed at once."""
_KEPT_BLOCKS: Final = 4
"""Number of replayed blocks kept for messages out of order."""


@short_dataclass
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
    converter: Converter

    def __getitem__(self, rows: Integers) -> Expected:
        return Expected(self.signal[rows], self.uncertainty[rows], self.converter)

    @cached_property
    def values(self) -> Array:
        """The readings, shape (N, K)."""
        return self.converter.read(self.signal)

    def residuals(self, recorded: Array) -> tuple[Array, Array]:
        """Distances of recorded readings from these, and their limits, on the worst axis; shape (N,) each."""
        distance = np.abs(recorded - self.values)
        allowed = self._allowed(recorded)
        axis = np.argmax(np.where(distance <= allowed, distance, np.inf), axis=1)
        at = axis + np.arange(0, distance.size, distance.shape[1])
        return distance.take(at), allowed.take(at)

    def _allowed(self, recorded: Array) -> Array:
        read = self.converter.read
        values = self.values
        low = read(self.signal - self.uncertainty)
        high = read(self.signal + self.uncertainty)
        allowed = np.where(recorded > values, high - values, values - low)
        if self.converter.resolution:
            allowed = np.where((recorded == values) | (read(recorded) == recorded), allowed, 0.0)
        return allowed


@short_dataclass
class ReplayedBlock:
    """Consecutive replayed readings of one sensor.

    Parameters
    ----------
    first : int
        Number of the first reading.
    times_ns : ndarray of int64, shape (N,)
        Arrival times, ns.
    lost : ndarray of bool, shape (N,)
        Which of them never arrive.
    arrays : mapping of str to Expected
        Expected readings, by the names of their arrays.
    """

    first: int
    times_ns: Integers
    lost: Booleans
    arrays: Mapping[str, Expected]

    @property
    def end(self) -> int:
        """Number of the reading behind the last one."""
        return self.first + len(self.times_ns)


class Replay:
    """The readings of one sensor in one segment, replayed from the segment's start on; the latest blocks are kept.

    Parameters
    ----------
    segment : Segment
    name : str
        Name of the sensor.
    max_attitude : float, optional
        Limit of the attitude's error, rad, in place of that of the declared motion.
    """

    def __init__(self, segment: Segment, name: str, max_attitude: float | None = None) -> None:
        limit = max_attitude_error(segment.scenario) if max_attitude is None else max_attitude
        self._relative_error = max(limit, MIN_READING_ERROR)
        self._largest = LargestSoFar()
        self._measurement = Measurement(segment, name, segment.scenario.exact_motion())
        self._blocks = deque[ReplayedBlock](maxlen=_KEPT_BLOCKS)

    @property
    def first(self) -> int:
        """Number of the first reading that is kept, or comes next."""
        return self._blocks[0].first if self._blocks else self.next

    @property
    def next(self) -> int:
        """Number of the reading that is replayed next."""
        return self._measurement.next

    def block(self, number: int, last: int) -> ReplayedBlock:
        """The block with a reading, not before `first`; no reading behind number ``last`` is replayed for it."""
        while number >= self.next:
            self._blocks.append(self._replayed(min(REPLAY_BLOCK, last + 1 - self.next)))
        return next(block for block in self._blocks if number < block.end)

    def _replayed(self, count: int) -> ReplayedBlock:
        first = self.next
        times_ns, lost, signals = self._measurement.replay(count)
        arrays = {name: self._expected(name, signal) for name, signal in signals.items()}
        return ReplayedBlock(first, times_ns, lost, arrays)

    def _expected(self, name: str, signal: Signal) -> Expected:
        """Expected readings of a signal, with their uncertainty."""
        values = signal.values.reshape(len(signal.values), -1)
        sizes = np.sqrt(np.einsum("ij,ij->i", values, values))
        largest = self._largest.with_more(name, sizes)
        turn = 1.0 / signal.interval if signal.interval else 0.0
        uncertainty = self._relative_error * (largest + turn)
        return Expected(values, uncertainty[:, np.newaxis], signal.converter)
