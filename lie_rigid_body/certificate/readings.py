"""Readings of a sensor, replayed with the exact motion, and the bounds of a faithful reading.

A reading is computed by the simulation's own instruments, from the exact motion. It may differ from the recorded one

- by round-off: `ROUNDINGS` u times the sum of the sizes of the parts that were added up for it, as they were drawn;
- by what the declared stepper errs, δA of the attitude and δω of the body rate, as far as they reach the signal.

No declared parameter widens the bounds otherwise: an effect that does not occur adds nothing. Rounding and saturation
in the sensor are monotonic. So a faithful reading lies between the two bounds after rounding and saturation. These are
one number unless a step of the converter lies between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.certificate.tolerance import Tolerance, tolerance
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.motion.drift import U
from lie_rigid_body.sensors.signal import Converter, Signal
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.samples import Measurement

ROUNDINGS: Final = 64.0
"""Limit of the round-off of a reading, in units of u and of the summed sizes of its parts. At most 53 were needed, with
normal deviates 16 u off, as in another library, and states off by 1e-15 rad and 12 u."""
REPLAY_BLOCK: Final = 8192
"""Largest number of readings replayed at once."""
MOST_DRAWN: Final = 200_000_000
"""Largest number of normal deviates drawn for readings that a bag lacks, as a bias walks through them. Drawing so many
takes 5 s."""
_LONGEST_GAP: Final = 256
"""Largest gap between two recorded readings, in readings, that is replayed; a longer gap is skipped."""
_PIECES_KEPT: Final = 4
"""Number of replayed pieces kept for a topic that lags behind the sensor's others, or for a message out of order."""
_CONTINUOUS: Final = Converter(0.0, 0.0)


@dataclass(frozen=True)
class Expected:
    """Expected readings of a sensor, with their uncertainty.

    Parameters
    ----------
    signal : ndarray, shape (N, K)
        Values before saturation and quantisation, unit of the reading.
    bound : callable
        Function that computes the `uncertainty`: costly, so called only where readings differ.
    converter : Converter
    """

    signal: Array
    bound: Callable[[], Array]
    converter: Converter = _CONTINUOUS

    def __getitem__(self, rows: slice | Integers) -> Expected:
        return Expected(self.signal[rows], lambda: self.uncertainty[rows], self.converter)

    @cached_property
    def uncertainty(self) -> Array:
        """Largest difference of a faithful recording's signal from this one, unit of the reading, shape (N, K)."""
        return self.bound()

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
    """Replays of a bag, for each sensor that of its latest segment, with a limit of the deviates drawn."""

    def __init__(self) -> None:
        self._left, self._last = MOST_DRAWN, dict[str, Replay]()

    def of(self, segment: Segment, name: str, duration: float) -> Replay:
        """The replay of a sensor in a segment; see `Replay` for the parameters."""
        known = self._last.get(name)
        if known is None or known.segment is not segment:
            known = self._last[name] = Replay(segment, name, duration, self)
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
    duration : float
        Time of the truth's last sample since the segment's start, s.
    replays : Replays
        Replays of the whole bag, which limit the deviates.
    """

    def __init__(self, segment: Segment, name: str, duration: float, replays: Replays) -> None:
        self.segment, self._name, self._duration, self._replays = segment, name, duration, replays
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
        self._pieces = [*self._pieces[1 - _PIECES_KEPT :], self._replayed(first, last + 1 - first)]
        return self._pieces[-1]

    def _replayed(self, first: int, count: int) -> Piece:
        self._measurement.begin_at(first)
        times, elapsed, signals = self._measurement.replay(count)
        t = np.asarray(elapsed * 1e-9, dtype=np.float64)
        limits = self._limits(float(t[-1]))
        return Piece(first, times, {name: _expected(signal, t, limits) for name, signal in signals.items()})

    def _limits(self, until: float) -> Tolerance:
        """Limits of the motion until a time, s. The recorder may have lost the truth before; errors then grow on."""
        duration = self._duration if until <= self._duration else 2.0 ** math.ceil(math.log2(until))
        return limits_of(self.segment, self._name, duration)


def _expected(signal: Signal, t: Array, limits: Tolerance) -> Expected:
    """Expected readings of a signal at times t, s, with their uncertainty."""
    values = signal.values.reshape(len(t), -1)

    def bound() -> Array:
        conditioning = signal.conditioning()
        span = conditioning.span
        rate = limits.stepper_mean_rate(t, span) if span else limits.stepper_rate(t)
        size, per_attitude, per_rate = conditioning.numbers
        carried = per_attitude * limits.stepper_attitude(t)[:, np.newaxis] + per_rate * rate[:, np.newaxis]
        return np.broadcast_to(ROUNDINGS * U * size + carried, values.shape)

    return Expected(values, bound, signal.converter or _CONTINUOUS)


def limits_of(segment: Segment, name: str, duration: float) -> Tolerance:
    """Limits of the motion that a sensor measures, whose integrator steps follow from the sensor's rate."""
    scenario = segment.scenario
    rate = scenario.sensors.on[name].rate
    own, truth = (1.0 / (f * scenario.steps_per_sample(f)) for f in (rate, scenario.rate))
    has_same = scenario.motion == "closed_form" or math.isclose(own, truth)
    return tolerance(scenario if has_same else scenario.resampled(rate=rate), duration)
