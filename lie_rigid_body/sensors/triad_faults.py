"""Faults of a triad's axes: spikes, bursts of noise, an axis that is stuck, saturation, a drift with temperature."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.parameters import Value
from lie_rigid_body.sensors.episodes import Episodes, Window, nanoseconds
from lie_rigid_body.sensors.fault import AXES, Fault, stream
from lie_rigid_body.sensors.noise import BlockBuffer, Draws, WhiteNoise
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.sensors.signal import Signal


@dataclass(frozen=True)
class TriadFaults:
    """The faults of a triad.

    Parameters
    ----------
    sensor : str
        See `Fault`.
    seed : int
    window : Window
    spike_probability : float
        That a reading has one, on one axis.
    spike_size : float
        Unit of the reading; its sign is drawn.
    noise_bursts : Episodes or None
        In which there is more white noise.
    burst_density : float
        Unit/√Hz.
    stuck : Episodes or None
        In which an axis repeats what it read before.
    saturation : Episodes or None
        In which the readings saturate at a lower level.
    saturation_level : float
        Unit; no multiple of the resolution that is above it, but for round-off, is read.
    drift : float
        Standard deviation of the change of the bias on each axis, unit.
    drift_duration_ns : int
        In which it comes about, from the window's begin on, evenly.
    """

    sensor: str
    seed: int
    window: Window
    spike_probability: float
    spike_size: float
    noise_bursts: Episodes | None
    burst_density: float
    stuck: Episodes | None
    saturation: Episodes | None
    saturation_level: float
    drift: float
    drift_duration_ns: int

    @classmethod
    def from_values(cls, sensor: str, values: Mapping[str, Value]) -> TriadFaults | None:
        """The faults of the parameters whose names begin with ``sensor``; None if there are none.

        Raises
        ------
        ParameterError
        """
        number = {key: cast(float, values[f"{sensor}_{key}"]) for key in _NUMBERS}
        bursts, stuck, saturation = (Episodes.from_values(values, sensor, kind) for kind in _EPISODES)
        found = cls(
            sensor,
            cast(int, values["sensor_seed"]),
            Window.from_values(values),
            number["spike_probability"],
            number["spike_size"],
            bursts,
            number["noise_burst_density"],
            stuck,
            saturation,
            number["saturation_level"],
            number["temperature_drift"],
            nanoseconds(number["temperature_drift_duration"]),
        )
        return found if found.spike_probability or bursts or stuck or saturation or found.drift else None

    def drifted(self) -> Array:
        """The whole change of the bias with temperature on each axis, unit, shape (3,)."""
        drawn: Array = WhiteNoise(self.seed, stream(self.sensor, "temperature_drift"), self.drift).draw(1)[0]
        return drawn

    def spikes(self, first: int, times_ns: Integers) -> Array:
        """What spikes add to some readings, shape (N, 3), unit; see `Delivery.lost` for the arguments."""
        spikes = np.zeros((len(times_ns), 3))
        if self.spike_probability:
            drawn = Draws(self.seed, stream(self.sensor, "spike")).following(first, len(times_ns))
            hit = np.flatnonzero((drawn[:, 0] < self.spike_probability) & self.window.holds(times_ns))
            signed = np.where(drawn[hit, 2] < 0.5, -self.spike_size, self.spike_size)
            spikes[hit, axis_of(drawn[hit, 1])] = signed
        return spikes

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> list[Fault]:
        """Faults that begin in a stretch of time; see `Faulty`."""
        return [*self._drifts(begin_ns, end_ns), *self._spikes(first, times_ns), *self._episodes(begin_ns, end_ns)]

    def _drifts(self, begin_ns: int, end_ns: int) -> Iterator[Fault]:
        start = self.window.begin_ns
        if self.drift and begin_ns <= start < end_ns:
            for axis, size in zip(AXES, self.drifted().tolist(), strict=True):
                yield Fault("temperature_drift", self.sensor, axis, start, start + self.drift_duration_ns, size)

    def _spikes(self, first: int, times_ns: Integers) -> Iterator[Fault]:
        spikes = self.spikes(first, times_ns)
        for row, axis in np.argwhere(spikes).tolist():
            time = int(times_ns[row])
            yield Fault("spike", self.sensor, AXES[axis], time, time, float(spikes[row, axis]))

    def _episodes(self, begin_ns: int, end_ns: int) -> Iterator[Fault]:
        if self.noise_bursts is not None:
            for _, begin, end in self.noise_bursts.between(begin_ns, end_ns):
                yield Fault("noise_burst", self.sensor, "", begin, end, self.burst_density)
        if self.stuck is not None:
            for number, begin, end in self.stuck.between(begin_ns, end_ns):
                axis = int(axis_of(self.stuck.draws(np.array([number]))[:, 0])[0])
                yield Fault("stuck", self.sensor, AXES[axis], begin, end)
        if self.saturation is not None:
            for _, begin, end in self.saturation.between(begin_ns, end_ns):
                yield Fault("saturation", self.sensor, "", begin, end, self.saturation_level)

    def repeated(
        self, number: int, elapsed_ns: Callable[[int], int], number_before: Callable[[int], int]
    ) -> Iterator[int]:
        """Readings that those after one may repeat on an axis that is stuck; see `Instrument.repeated`."""
        stuck_axis = None
        if self.stuck is not None:
            yield number
        while self.stuck is not None and (time_ns := elapsed_ns(number)) >= 0:
            episode = self.stuck.at(np.array([time_ns]))
            axis = int(axis_of(self.stuck.draws(np.maximum(episode, 0))[:, 0])[0])
            if episode[0] < 0 or stuck_axis not in (None, axis):
                return
            stuck_axis, number = axis, number_before(int(self.stuck.begins_ns(episode)[0]))
            yield number


_NUMBERS: Final = (
    *("spike_probability", "spike_size", "noise_burst_density", "saturation_level"),
    *("temperature_drift", "temperature_drift_duration"),
)
_EPISODES: Final = ("noise_burst", "stuck", "saturation")


def axis_of(drawn: Array) -> Integers:
    """The axis, from 0 to 2, of each number that is uniform between 0 and 1."""
    return (3.0 * drawn).astype(np.int64)


class FaultyTriad:
    """The faults of three axes at work, on readings in order.

    Parameters
    ----------
    model : TriadFaults
    rate : float
        Readings per second.
    converter : Converter
        What makes readings of the signal.
    """

    def __init__(self, model: TriadFaults, rate: float, converter: Converter) -> None:
        self.model = model
        self._count = 0
        self._drift = model.drifted()
        self._last: Signal | None = None
        self._level = converter.largest_within(model.saturation_level)
        sigma = model.burst_density * math.sqrt(rate)
        self._burst = BlockBuffer(WhiteNoise(model.seed, stream(model.sensor, "noise_burst", 1), sigma))

    def drift(self, times_ns: Integers) -> Array:
        """What the drift with temperature adds to the bias at some times since the segment's start, shape (N, 3)."""
        age, duration = times_ns - self.model.window.begin_ns, self.model.drift_duration_ns
        share = np.clip(age / duration, 0.0, 1.0) if duration else np.where(age >= 0, 1.0, 0.0)
        return np.asarray(share[:, np.newaxis] * self._drift)

    def disturbed(self, times_ns: Integers, signal: Signal) -> Signal:
        """The signal of the next readings with bursts, spikes, saturation and what is stuck."""
        return self._stuck(times_ns, self._saturated(times_ns, self._added(times_ns, signal)))

    def skip(self, count: int) -> None:
        """Leave out the next readings, which an axis that is stuck then does not repeat."""
        self._burst.skip(count)
        self._count += count

    def _added(self, times_ns: Integers, signal: Signal) -> Signal:
        """The signal with bursts and spikes."""
        model, count = self.model, len(times_ns)
        if model.noise_bursts is not None:
            inside = model.noise_bursts.at(times_ns)[:, np.newaxis] >= 0
            signal = signal.plus(np.where(inside, self._burst.take(count), 0.0))
        signal = signal.plus(model.spikes(self._count, times_ns))
        self._count += count
        return signal

    def _saturated(self, times_ns: Integers, signal: Signal) -> Signal:
        """The signal clipped at a level; this keeps the order of numbers, and adds no round-off."""
        model = self.model
        if model.saturation is None:
            return signal
        inside = model.saturation.at(times_ns)[:, np.newaxis] >= 0
        clipped = np.clip(signal.values, -self._level, self._level)
        return replace(signal, values=np.where(inside, clipped, signal.values))

    def _stuck(self, times_ns: Integers, signal: Signal) -> Signal:
        """The signal that repeats, on a stuck axis, that of the reading before: so whatever the converter."""
        if self.model.stuck is None or not len(times_ns):
            return signal
        numbers = self.model.stuck.at(times_ns)
        axes = axis_of(self.model.stuck.draws(np.maximum(numbers, 0))[:, 0])
        rows = np.repeat(np.arange(len(times_ns))[:, np.newaxis], 3, axis=1)
        for number in np.unique(numbers[numbers >= 0]):
            inside = np.flatnonzero(numbers == number)
            axis, first = int(axes[inside[0]]), int(inside[0])
            if first:
                rows[inside, axis] = rows[first - 1, axis]
            else:
                rows[inside, axis] = 0 if self._last is None else -1
        signal = signal.held(rows, self._last)
        self._last = signal[-1:]
        return signal
