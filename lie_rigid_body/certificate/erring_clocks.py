"""The stamps of a sensor whose clock errs, turned back into the times of its measurements.

Such a clock shows s = t + o + rint(σ (t − t₀)) at the time t; offset o, skew σ and epoch t₀ are of the segment's
scenario. With |σ| ≤ 0.01, u = 2⁻⁵³ and times below 2³¹ s, rint and the roundings of the product move s by
½ + 2.1 u |σ (t − t₀)| ≤ 6 ns at most, and those of the inverse t₀ + y − y σ/(1 + σ), with y = s − o − t₀, move that by
½ + 4 u |y σ/(1 + σ)| ≤ 11 ns. So it is less than 20 ns off, the nearest reading of the sensor's grid is the right one,
and what the clock shows at that reading is compared with the stamp to the nanosecond.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.certificate.readings import sensor_clock
from lie_rigid_body.certificate.stamps import grid
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.recording.segments import number_samples
from lie_rigid_body.recording.sensor_reader import SensorMessages
from lie_rigid_body.sensors import SensorModel
from lie_rigid_body.simulation import Segment

FASTEST: Final = 1e7
"""Readings per second beyond which the nearest is not surely the right one."""
_ROUNDING_NS: Final = 20
_UNKNOWN: Final = np.iinfo(np.int64).max


class ErringClocks:
    """The clocks of a sensor in the segments of a bag.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    models : sequence of (SensorModel or None)
        The sensor in each.
    """

    def __init__(self, segments: Sequence[Segment], models: Sequence[SensorModel | None]) -> None:
        self._segments, self._models = segments, models
        self._starts = np.array([segment.start_ns for segment in segments])
        self._has_clock = np.array([model is not None for model in models])
        shown = [shown_ns(segments[i], models[i], self._starts[i : i + 2]) for i in range(len(segments))]
        self._from_ns = np.array([of_one[0] for of_one in shown]) - _ROUNDING_NS
        self._until_ns = np.array([of_one[-1] for of_one in shown]) + _ROUNDING_NS
        self._until_ns[-1] = _UNKNOWN
        self._previous_ns = 0

    def measured(self, messages: SensorMessages, *, in_order: bool) -> tuple[SensorMessages, Integers]:
        """Messages with the times of measurement in place of their stamps, and those stamps that no clock shows.

        A stamp that is off what the clock shows at a reading becomes a time that is as much off that of the reading.

        Parameters
        ----------
        messages : SensorMessages
            Those that come next in the file.
        in_order : bool
            Whether their log times tell the segments. Otherwise, of several clocks that show a stamp, the right one is
            that which shows it at the time nearest to the reading before.
        """
        stamps = messages.stamps_ns
        times, off = np.zeros(len(stamps), dtype=np.int64), np.full(len(stamps), _UNKNOWN)
        found = [
            (rows, *self._of_segment(place, stamps[rows]))
            for place, rows in self._places(stamps, messages.log_times_ns if in_order else None)
        ]
        for rows, own, by in found:
            nearer = np.abs(by) < np.abs(off[rows])
            times[rows[nearer]], off[rows[nearer]] = own[nearer], by[nearer]
        known = off != _UNKNOWN
        if len(found) > 1:
            self._choose(times, np.abs(off), known, found)
        self._previous_ns = int(times[-1]) if len(times) else self._previous_ns
        is_early = ~known & (stamps < self._from_ns.min())
        times[is_early], off[is_early] = self._starts[0] - 1, 0
        known |= is_early
        return replace(messages, stamps_ns=times + off)[known], stamps[~known]

    def _choose(
        self,
        times_ns: Integers,
        off_ns: Integers,
        known: Booleans,
        found: Sequence[tuple[Integers, Integers, Integers]],
    ) -> None:
        """Of several times that are as little off take the one nearest to that of the reading before."""
        count = np.zeros(len(times_ns), dtype=np.int64)
        for rows, _, by in found:
            count[rows] += known[rows] & (np.abs(by) == off_ns[rows])
        for row in np.flatnonzero(count > 1).tolist():
            before = times_ns[row - 1] if row else self._previous_ns
            options = np.concatenate([own[(rows == row) & (np.abs(by) == off_ns[row])] for rows, own, by in found])
            times_ns[row] = options[np.argmin(np.abs(options - before))]

    def _places(self, stamps_ns: Integers, log_times_ns: Integers | None) -> Iterator[tuple[int, Integers]]:
        """The segments whose clocks may have shown some of the stamps, and which of them."""
        if log_times_ns is not None:
            at = np.maximum(np.searchsorted(self._starts, log_times_ns, side="right") - 1, 0)
            for place in np.unique(at).tolist():
                yield place, np.flatnonzero(at == place)
        elif len(stamps_ns):
            near = self._has_clock & (self._from_ns <= stamps_ns.max()) & (self._until_ns >= stamps_ns.min())
            for place in np.flatnonzero(near).tolist():
                inside = (stamps_ns >= self._from_ns[place]) & (stamps_ns <= self._until_ns[place])
                yield place, np.flatnonzero(inside)

    def _of_segment(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers]:
        """The time of the reading of a segment that is nearest to each stamp, and how far the stamp is off, ns."""
        times, off = np.zeros(len(stamps_ns), dtype=np.int64), np.full(len(stamps_ns), _UNKNOWN)
        near = self._near(place, stamps_ns)
        segment, model = self._segments[place], self._models[place]
        clock = segment.clock() if model is None else sensor_clock(segment, model.rate)[0]
        rows = np.flatnonzero((near >= 0) & (near <= MAX_EPOCH_NS - int(clock.period_ns)))
        if len(rows):
            own = near[rows] if model is None else grid(clock, number_samples(clock, near[rows]))
            inside = np.searchsorted(self._starts, own, side="right") - 1 == place
            rows, own = rows[inside], own[inside]
            times[rows], off[rows] = own, stamps_ns[rows] - shown_ns(segment, model, own)
        return times, off

    def _near(self, place: int, stamps_ns: Integers) -> Integers:
        """The times at which the clock of a segment shows the stamps, but for rounding, ns."""
        model, epoch = self._models[place], self._segments[place].scenario.epoch_ns
        if model is None or model.delivery is None:
            return stamps_ns
        skew = model.delivery.clock_skew
        since = stamps_ns - model.delivery.clock_offset_ns - epoch
        return np.asarray(epoch + since - np.rint(since * (skew / (1.0 + skew))).astype(np.int64))


def shown_ns(segment: Segment, model: SensorModel | None, times_ns: Integers) -> Integers:
    """What the clock of a sensor shows at some times in a segment, ns."""
    if model is None or model.delivery is None:
        return times_ns
    return times_ns + model.delivery.error_ns(times_ns, segment.scenario.epoch_ns)


def err(models: Sequence[SensorModel | None]) -> bool:
    """Whether the clock of any of these errs."""
    return any(model is not None and model.delivery is not None and model.delivery.is_off for model in models)
