"""Faults of sensors: what goes wrong and when, and its text; also on the way of readings, lost, late or mis-stamped."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS, Names
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.sensors.noise import Draws
from lie_rigid_body.sensors.parameters import Values, values_of

if TYPE_CHECKING:
    from typing_extensions import Self

KINDS: Final = (
    "dropout",
    "outage",
    "latency",
    "latency_jitter",
    "clock_offset",
    "clock_skew",
    "spike",
    "noise_burst",
    "stuck",
    "saturation",
    "temperature_drift",
    "magnetic_disturbance",
)
"""The kinds of faults. The order is part of the keys of the random numbers."""
AXES: Final = ("x", "y", "z")
"""Names of the axes in the text of a fault."""
STREAMS: Final[dict[str, int]] = {}
"""Number of each sensor, and part of a sensor, that can have faults, in the keys of the random numbers, as
`SensorRegistry.register` takes them from the sensors' entries."""
MAX_FAULT_TEXT: Final = 192
"""Largest length of the text of a fault, characters."""
MIN_INTERVAL_S: Final = 1e-3
"""Shortest interval from one episode to the next, s."""
END_OF_TIME: Final = 2**62
"""A time since a start that no run reaches, ns."""


@short_dataclass
class Fault:
    """One fault of a sensor, from its begin to its end.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    sensor : str
        The sensor, or the part of it, that has the fault: one of `STREAMS`.
    axis : str
        ``x``, ``y`` or ``z``; empty where a fault is not of one axis.
    begin_ns : int
        Simulated time at which it begins, ns; for a fault of one reading the time of the measurement.
    end_ns : int or None
        First time after it, ns; for a fault of one reading the time of the measurement; None: it lasts until a reset.
    size : float or None
        Size in the unit of the parameter that sets it; None where the fault has none.
    """

    kind: str
    sensor: str
    axis: str
    begin_ns: int
    end_ns: int | None
    size: float | None = None

    def later(self, by_ns: int) -> Fault:
        """Move the fault to a later time, by so many ns."""
        end_ns = None if self.end_ns is None else self.end_ns + by_ns
        return replace(self, begin_ns=self.begin_ns + by_ns, end_ns=end_ns)

    def to_json(self) -> str:
        """The text of the fault, as the topic of faults has it."""
        return json.dumps(vars(self))

    @classmethod
    def from_json(cls, text: str) -> Fault:
        """The fault that a text tells.

        Raises
        ------
        InputError
            If the text tells of no fault.
        """
        try:
            fault = cls(**json.loads(text[: 2 * MAX_FAULT_TEXT]))
            names = fault.kind in KINDS and fault.sensor in STREAMS and fault.axis in (*AXES, "")
            times = type(fault.begin_ns) is int and (fault.end_ns is None or type(fault.end_ns) is int)
            if names and times and (fault.size is None or type(fault.size) in (int, float)):
                return fault
        except (ValueError, TypeError, RecursionError):
            pass
        raise InputError(f"{shown(text)} tells of no fault of lie_rigid_body: give the topic ~/faults")


def stream(sensor: str, kind: str, part: int = 0) -> int:
    """Source of the random numbers of one kind of fault; ``part`` is 1 for a second source of the kind."""
    return 256 * STREAMS[sensor] + 2 * KINDS.index(kind) + part


def nanoseconds(seconds: float) -> int:
    """Convert a time in s to the nearest integer of ns."""
    return round(seconds * NS)


@short_dataclass
class Window:
    """Time in which faults come and go, ns since the segment's start; the end is not part of it."""

    begin_ns: int
    end_ns: int

    @classmethod
    def from_values(cls, values: Values) -> Window:
        """Make the window of the parameters ``fault_begin`` and ``fault_end``.

        Raises
        ------
        ParameterError
            If it ends before it begins.
        """
        begin = values["fault_begin"]
        end = values["fault_end"]
        if 0.0 < end <= begin:
            raise ParameterError("fault_end", f"{end:g} s is not after fault_begin, {begin:g} s: give more, or 0")
        return cls(nanoseconds(begin), nanoseconds(end) if end else END_OF_TIME)

    def holds(self, times_ns: Integers) -> Booleans:
        """Tell of each time whether it is in the window, shape (N,)."""
        return (times_ns >= self.begin_ns) & (times_ns < self.end_ns)


@short_dataclass
class IntermittentFault:
    """Episodes of one kind: one in each interval from the window's begin on, at a place in it that the seed decides.

    A long time has as many episodes as intervals, and no episode meets the next, whatever the seed. Where the duration
    is the interval, one begins as the other ends.

    Parameters
    ----------
    seed : int
    sensor, kind : str
        See `Fault`.
    window : Window
    interval_ns, duration_ns : int
    """

    seed: int
    sensor: str
    kind: str
    window: Window
    interval_ns: int
    duration_ns: int

    @classmethod
    def from_values(cls, values: Values, sensor: str, kind: str, name: str = "") -> IntermittentFault | None:
        """Make the episodes of the parameters that begin with ``sensor_kind``, or ``name``; None if the interval is 0.

        Raises
        ------
        ParameterError
            If the duration is longer than the interval, or the interval is too short.
        """
        name = name or f"{sensor}_{kind}"
        interval = values[f"{name}_interval"]
        duration = values[f"{name}_duration"]
        if not interval:
            return None
        if interval < MIN_INTERVAL_S:
            raise ParameterError(
                f"{name}_interval", f"{interval:g} s is below {MIN_INTERVAL_S:g} s: give more, or 0 for none"
            )
        if not 0 < nanoseconds(duration) <= nanoseconds(interval):
            raise ParameterError(
                f"{name}_duration",
                f"{duration:g} s is not above 0 and at most {name}_interval, {interval:g} s: give a time between",
            )
        window = Window.from_values(values)
        return cls(values["sensor_seed"], sensor, kind, window, nanoseconds(interval), nanoseconds(duration))

    def draws(self, numbers: Integers) -> Array:
        """Four uniform numbers for each episode, shape (N, 4): the first decides its time, the others all else."""
        return Draws(self.seed, stream(self.sensor, self.kind)).of(numbers)

    def begins_ns(self, numbers: Integers) -> Integers:
        """Begin of each episode, ns since the segment's start, shape (N,)."""
        spare = self.draws(numbers)[:, 0] * (self.interval_ns - self.duration_ns)
        return self.window.begin_ns + numbers * self.interval_ns + spare.astype(np.int64)

    def at(self, times_ns: Integers) -> Integers:
        """Number of the episode at each time, shape (N,); -1: none."""
        numbers = (times_ns - self.window.begin_ns) // self.interval_ns
        found = np.full(len(times_ns), -1, dtype=np.int64)
        inside = np.flatnonzero(self.window.holds(times_ns))
        age = times_ns[inside] - self.begins_ns(numbers[inside])
        inside = inside[(age >= 0) & (age < self.duration_ns)]
        found[inside] = numbers[inside]
        return found

    def between(self, begin_ns: int, end_ns: int) -> Iterator[tuple[int, int, int]]:
        """Number, begin and end of each episode that begins in a stretch of time without its end, ns."""
        begin_ns = max(begin_ns, self.window.begin_ns)
        end_ns = min(end_ns, self.window.end_ns)
        if begin_ns >= end_ns:
            return
        low, high = ((time - self.window.begin_ns) // self.interval_ns for time in (begin_ns, end_ns - 1))
        numbers = np.arange(low, high + 1, dtype=np.int64)
        for number, begin in zip(numbers.tolist(), self.begins_ns(numbers).tolist(), strict=True):
            if begin_ns <= begin < end_ns:
                yield number, begin, min(begin + self.duration_ns, self.window.end_ns)


@short_dataclass
class FaultModel(ABC):
    """The faults of one part of a sensor. `from_values` makes them of parameters with the names of the fields.

    Parameters
    ----------
    sensor : str
        See `Fault`.
    seed : int
        Seed of the random numbers.
    window : Window
        Time in which faults come and go.
    """

    sensor: str
    seed: int
    window: Window

    switches: ClassVar[Names] = ()
    """Ends of the names of the parameters any of which switches a fault on."""
    intermittent_kinds: ClassVar[Names] = ()
    """Fields that are `IntermittentFault`, or None if their interval is 0."""

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> Self | None:
        """Make the faults of the parameters whose names begin with ``sensor``; None if there are none.

        Raises
        ------
        ParameterError
        """
        window = Window.from_values(values)
        if not any(values[f"{sensor}_{switch}"] for switch in cls.switches):
            return None
        episodes = {kind: IntermittentFault.from_values(values, sensor, kind) for kind in cls.intermittent_kinds}
        return cls(sensor, values["sensor_seed"], window, **values_of(cls, sensor, values), **episodes)

    def draws(self, kind: str) -> Draws:
        """Random numbers of one kind of fault."""
        return Draws(self.seed, stream(self.sensor, kind))

    @abstractmethod
    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> Iterator[Fault]:
        """Faults that begin in a stretch of time since the segment's start.

        Parameters
        ----------
        begin_ns, end_ns : int
            Begin and end of the stretch, ns; the end is not part of it.
        first : int
            Number of the sensor's first reading in it, counted from 0 in the segment.
        times_ns : ndarray of int64, shape (N,)
            Times of the readings in it, ns.
        """


@short_dataclass
class TransportFaults(FaultModel):
    """Faults on the way of a sensor's readings to whoever listens.

    A reading measured at t arrives at the largest of t + latency + jitter · u so far, with u uniform between 0 and 1:
    none overtakes another. It is stamped t + offset + skew · (t − epoch), what the sensor's clock shows at t.

    Parameters
    ----------
    sensor, seed, window
        See `FaultModel`.
    dropout_probability : float
        Probability that a reading is lost, independent of the others.
    outage : IntermittentFault or None
        Episodes in which every reading is lost.
    latency, latency_jitter : float
        Constant and largest random part of the delay, s.
    clock_offset : float
        Lead of the sensor's clock at the epoch, s.
    clock_skew : float
        Rate at which the clock gains, s/s.
    """

    dropout_probability: float
    outage: IntermittentFault | None
    latency: float
    latency_jitter: float
    clock_offset: float
    clock_skew: float

    switches = ("dropout_probability", "outage_interval", "latency", "latency_jitter", "clock_offset", "clock_skew")
    intermittent_kinds = ("outage",)

    @property
    def has_clock_error(self) -> bool:
        """Whether the sensor's clock is wrong."""
        return bool(nanoseconds(self.clock_offset) or self.clock_skew)

    def lost(self, numbers: Integers, times_ns: Integers) -> Booleans:
        """Tell which of some readings never arrive.

        Parameters
        ----------
        numbers : ndarray of int64, shape (N,)
            Their numbers, counted from 0 in the segment.
        times_ns : ndarray of int64, shape (N,)
            Times of their measurement since the segment's start, ns.
        """
        lost = self._dropped(numbers, times_ns)
        return lost if self.outage is None else lost | (self.outage.at(times_ns) >= 0)

    def _dropped(self, numbers: Integers, times_ns: Integers) -> Booleans:
        if not self.dropout_probability:
            return np.zeros(len(times_ns), dtype=np.bool_)
        drawn = self.draws("dropout").of(numbers)[:, 0]
        return (drawn < self.dropout_probability) & self.window.holds(times_ns)

    def delays_ns(self, first: int, count: int) -> Integers:
        """Delays of some readings, ns: latency and jitter, by which alone one could overtake another."""
        drawn = self.draws("latency_jitter").following(first, count)[:, 0]
        return nanoseconds(self.latency) + (drawn * nanoseconds(self.latency_jitter)).astype(np.int64)

    def stamps_ns(self, measured_ns: Integers, epoch_ns: int) -> Integers:
        """Stamps that the sensor's clock gives at some times, ns.

        Parameters
        ----------
        measured_ns : ndarray of int64, shape (N,)
        epoch_ns : int
            Time at which the clock is wrong by its offset alone, ns.

        Raises
        ------
        ParameterError
            If a stamp is negative, or beyond the last that ROS can tell.
        """
        stamps = np.asarray(measured_ns + self.error_ns(measured_ns, epoch_ns), dtype=np.int64)
        if len(stamps) and not 0 <= stamps.min() <= stamps.max() <= MAX_EPOCH_NS:
            worst = stamps[np.argmax((stamps < 0) | (stamps > MAX_EPOCH_NS))]
            raise ParameterError(
                f"{self.sensor}_clock_offset",
                f"a reading would be stamped {worst} ns, outside [0, {MAX_EPOCH_NS}]: give another epoch_ns",
            )
        return stamps

    def error_ns(self, measured_ns: Integers, epoch_ns: int) -> Integers:
        """Lead of the sensor's clock at some times, ns; see `stamps_ns`."""
        drift = np.rint(self.clock_skew * (measured_ns - epoch_ns)).astype(np.int64)
        return nanoseconds(self.clock_offset) + drift

    def measured_ns(self, stamps_ns: Integers, epoch_ns: int) -> Integers:
        """Times at which the sensor's clock shows some stamps, to 8 ns; see `stamps_ns`.

        With a skew of at most 0.01 and times below 2³¹ s, roundings to doubles made 6 ns at most in 600 000 stamps.
        """
        since = stamps_ns - nanoseconds(self.clock_offset) - epoch_ns
        drift = np.rint(since * (self.clock_skew / (1.0 + self.clock_skew))).astype(np.int64)
        return epoch_ns + since - drift

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> Iterator[Fault]:
        """Faults of the delivery in a stretch of time; see `FaultModel`."""
        lasting = {
            "latency": nanoseconds(self.latency) / 1e9,
            "latency_jitter": nanoseconds(self.latency_jitter) / 1e9,
            "clock_offset": nanoseconds(self.clock_offset) / 1e9,
            "clock_skew": self.clock_skew,
        }
        for kind, size in lasting.items() if begin_ns <= 0 < end_ns else ():
            if size:
                yield Fault(kind, self.sensor, "", 0, None, size)
        for time in times_ns[self._dropped(first + np.arange(len(times_ns)), times_ns)].tolist():
            yield Fault("dropout", self.sensor, "", time, time)
        for _, begin, end in self.outage.between(begin_ns, end_ns) if self.outage else ():
            yield Fault("outage", self.sensor, "", begin, end)
