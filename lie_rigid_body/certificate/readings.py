"""Readings of the sensors computed anew from a scenario, and between which bounds a faithful reading lies.

A reading is computed as the simulation does, with the same noise, but from the exact motion. The declared stepper may
err from that by the limits of the certificate, δω of the body rate and δA of the attitude. They reach a reading through

- gyro: δω, or that of the mean rate over an interval;
- accelerometer: Euler's equations and the lever arm r: |δ(ω̇×r + ω×(ω×r))| ≤ (√2 + 2) Ω |r| |δω|, and g δA;
- magnetometer: |B| δA;
- orientation, attitude sensor: δA/2, as a quaternion has half angles; its covariance: 2 |σ_r² − σ_c²| δA;
- sun sensor: δA;

and through scale factors or soft iron, of which a row has the norm |s|. Noise adds nothing to that but round-off: its
words are the same everywhere, and what libraries make of them differs in last bits. A bias that walks sums them up, and
its roundings, k of them, at random. Faults of axes come and go at times that the seed determines exactly, and are part
of the signal. At last the sensor rounds and saturates, which keeps the order of numbers: a faithful reading lies
between what becomes of the two ends, which is one number, unless a step lies between them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.tolerance import Tolerance, tolerance
from lie_rigid_body.lie import so3
from lie_rigid_body.motion.drift import U
from lie_rigid_body.sensors import Magnetometer
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.sensors.triad_faults import TriadFaults
from lie_rigid_body.simulation import SampleClock, Segment

ROUNDINGS: Final = 32.0
"""Roundings of a reading, in units of u and of the sum of its parts' sizes."""
LARGEST_DEVIATE: Final = 8.3
"""No normal deviate is larger: they are made of 53-bit numbers."""
DEVIATE: Final = 16.0
"""Difference of a normal deviate between libraries, in units of u."""
BLOCK: Final = 8192
"""Readings that are computed at once."""
_CONTINUOUS: Final = Converter(0.0, 0.0)


@dataclass(frozen=True)
class Expected:
    """What readings should be.

    Parameters
    ----------
    signal : ndarray, shape (N, 3)
        Before saturation and quantisation.
    uncertainty : ndarray, shape (N, 3)
        How far that of a faithful recording may be from it.
    converter : Converter
    """

    signal: Array
    uncertainty: Array
    converter: Converter = _CONTINUOUS

    def __getitem__(self, rows: Integers) -> Expected:
        return Expected(self.signal[rows], self.uncertainty[rows], self.converter)

    def residuals(self, recorded: Array) -> tuple[Array, Array]:
        """Distance of recorded readings from these, and how far they may be, of the axis that is worst; shape (N,)."""
        read = self.converter.read
        value = read(self.signal)
        distance = np.abs(recorded - value)
        if not distance.any():  # as of one's own recordings; then no axis is worse than the first
            return distance[:, 0], value[:, 0] - read(self.signal[:, 0] - self.uncertainty[:, 0])
        low, high = read(self.signal - self.uncertainty), read(self.signal + self.uncertainty)
        allowed = np.where(recorded > value, high - value, value - low)
        if self.converter.resolution:
            allowed = np.where((recorded == value) | (read(recorded) == recorded), allowed, 0.0)
        axis = np.argmax(np.where(distance <= allowed, distance, np.inf), axis=1)
        at = axis + np.arange(0, distance.size, distance.shape[1])
        return distance.take(at), allowed.take(at)


def sensor_clock(segment: Segment, rate: float) -> tuple[SampleClock, int]:
    """The clock of a sensor of a rate, and the number of its first reading in a segment."""
    clock = SampleClock(segment.scenario.epoch_ns, rate)
    return clock, clock.count_until(segment.start_ns - 1)


class Times:
    """The times of a sensor's readings in a segment, and its exact motion.

    Parameters
    ----------
    segment : Segment
    rate : float
        Readings per second.
    """

    def __init__(self, segment: Segment, rate: float) -> None:
        self._clock, self.first = sensor_clock(segment, rate)
        self._start_ns, self.motion = segment.start_ns, segment.scenario.exact_motion()
        self.next = self.first

    def before(self, number: int) -> int:
        """Time of the reading before a number, ns since the segment's start."""
        return self._clock.stamp_ns(number - 1) - self._start_ns

    def advance(self, first: int, count: int) -> int:
        """Go on behind readings; return how many were left out before them."""
        left_out, self.next = first - self.next, first + count
        return left_out

    def elapsed_ns(self, first: int, count: int) -> Integers:
        """Times of readings, ns since the segment's start."""
        return self._clock.stamps_ns(first, count) - self._start_ns

    def blocks_ns(self, first: int, count: int) -> Iterator[Integers]:
        """The same in blocks."""
        for done in range(0, count, BLOCK):
            yield self.elapsed_ns(first + done, min(BLOCK, count - done))

    def since_start(self, first: int, count: int) -> Array:
        """How many readings of the segment come before each of these, shape (count, 1)."""
        return np.arange(first - self.first, first - self.first + count, dtype=np.float64)[:, np.newaxis]


class Readings(ABC):
    """The readings of one topic in one segment, in order.

    Parameters
    ----------
    segment : Segment
    rate : float
        Readings per second.
    duration : float
        Of the segment, s.

    Attributes
    ----------
    motion_error : float
        How far the declared motion that the readings are of may err, rad, before any cap.
    walks : bool
        Whether every reading depends on all before it, so that those that are left out have to be computed.
    repeats : bool
        Whether a reading may repeat one before it, so that those that are left out have to be computed in full.
    """

    walks = repeats = False
    _sensor: Any

    def __init__(self, segment: Segment, rate: float, duration: float) -> None:
        self._times, self._tolerance = Times(segment, rate), limits_of(segment, rate, duration)
        self.motion_error = float(self._tolerance.attitude_uncapped(np.array([duration]))[0])

    @property
    def next(self) -> int:
        """Number of the reading that comes next."""
        return self._times.next

    def take(self, first: int, count: int) -> tuple[Expected, ...]:
        """Each vector of so many readings, from number ``first`` on, which is ``next`` or beyond it."""
        if left_out := self._times.advance(first, count):
            self._leave_out(first, left_out)
        elapsed = self._times.elapsed_ns(first, count)
        return self._expected(self._signal(elapsed), elapsed, self._times.since_start(first, count))

    def _leave_out(self, first: int, count: int) -> None:
        """Go on to a reading from so many before it."""
        if not self.repeats:
            self._skip(first, count)
            return
        for elapsed in self._times.blocks_ns(first - count, count):
            self._signal(elapsed)

    def _skip(self, first: int, count: int) -> None:
        """Leave out so many readings before one."""
        before_ns = self._times.before(first)
        self._sensor.skip(count, before_ns, self._times.motion.at(before_ns))

    def _signal(self, elapsed_ns: Integers) -> Any:
        """What the sensor makes of the exact motion, before its converter, at its next readings."""
        return self._sensor.signals(elapsed_ns, self._times.motion.at(elapsed_ns))

    @abstractmethod
    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """Each vector of readings with its limits, at so many ns after the start, with so many readings before each."""


class FieldReadings(Readings):
    """What a magnetometer reads; nothing of it walks. See `Readings` for the parameters."""

    def __init__(self, segment: Segment, duration: float) -> None:
        model = segment.scenario.sensors.magnetometer
        assert model is not None
        super().__init__(segment, model.rate, duration)
        self._sensor, self._converter, self.repeats = Magnetometer(model), model.converter, may_repeat(model.faults)
        passing = 0.0 if model.disturbance is None else model.disturbance.size
        field = float(so3.norm(np.array(model.field))) + passing
        self._gain = field * so3.norm(np.array(model.soft_iron).reshape(3, 3))
        noise = LARGEST_DEVIATE * model.noise_density * math.sqrt(model.rate)
        self._rounding = (
            ROUNDINGS * U * (self._gain + np.abs(model.hard_iron) + noise + size_of(model.faults, model.rate))
        )

    def _expected(self, signal: Any, elapsed_ns: Integers, before: Array) -> tuple[Expected, ...]:
        """The field."""
        angle = self._tolerance.attitude(seconds(elapsed_ns))[:, np.newaxis]
        return (Expected(signal["field"].values, self._gain * angle + self._rounding, self._converter),)


def seconds(elapsed_ns: Integers) -> Array:
    """Times in s."""
    return np.asarray(elapsed_ns * 1e-9, dtype=np.float64)


def may_repeat(*faults: TriadFaults | None) -> bool:
    """Whether a reading may repeat one before it, with these faults."""
    return any(of_one is not None and of_one.stuck is not None for of_one in faults)


def size_of(faults: TriadFaults | None, rate: float) -> float:
    """Largest size of what faults add to a signal."""
    if faults is None:
        return 0.0
    burst = 0.0 if faults.noise_bursts is None else faults.burst_density * math.sqrt(rate)
    spike = faults.spike_size if faults.spike_probability else 0.0
    return LARGEST_DEVIATE * (burst + faults.drift) + spike


def turned(attitude_xyzw: Array, angle: Array, noise: float) -> Expected:
    """Attitudes that may be turned by angles, rad, shape (N,), and by a noise of so many rad in all."""
    uncertainty = 0.5 * angle + ROUNDINGS * U * (1.0 + LARGEST_DEVIATE * noise)
    return Expected(attitude_xyzw, np.broadcast_to(uncertainty[:, np.newaxis], attitude_xyzw.shape))


def limits_of(segment: Segment, rate: float, duration: float) -> Tolerance:
    """The limits of the motion that a sensor feels, which takes steps of its own from one reading to the next."""
    scenario = segment.scenario
    own, truth = (1.0 / (f * scenario.steps_per_sample(f)) for f in (rate, scenario.rate))
    has_same = scenario.motion == "closed_form" or math.isclose(own, truth)
    return tolerance(scenario if has_same else replace(scenario, rate=rate), duration)


def deviate_rounding(sigma: float) -> float:
    """Round-off of a normal deviate of a standard deviation."""
    return U * (DEVIATE + ROUNDINGS) * LARGEST_DEVIATE * sigma
