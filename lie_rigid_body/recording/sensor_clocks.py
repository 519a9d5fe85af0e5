"""The segments that readings of a sensor belong to, and their numbers, by the clocks that stamp them.

The clock of a sensor shows s = t + o + rint(σ (t − t₀)) at the time t; offset o, skew σ and epoch t₀ are those of the
segment's scenario. `Delivery.measured_ns` inverts this to 20 ns, so that the nearest reading of the sensor's grid is
the right one, and what the clock shows at that reading is compared with the stamp to the nanosecond.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.recording.segments import declared_segments, grid, number_samples, segment_parts
from lie_rigid_body.recording.sensor_reader import SensorMessages
from lie_rigid_body.recording.tracks import Recording
from lie_rigid_body.sensors import SENSORS, SensorModel
from lie_rigid_body.simulation import SampleClock, Segment

FASTEST: Final = 1e7
"""Readings per second beyond which the nearest to a stamp is not surely the right one, if the clock errs."""
_ROUNDING_NS: Final = 20
"""Largest error of the time at which a clock that errs shows a stamp, ns."""
_FAR: Final = np.iinfo(np.int64).max


@dataclass(frozen=True)
class PlacedReadings:
    """Messages that belong to one segment.

    Parameters
    ----------
    place : int
        That of the segment among those declared.
    rows : slice or ndarray
        Which of the messages they are.
    numbers : ndarray of int64, shape (N,)
        Of the nearest readings of the sensor there.
    times_ns : ndarray of int64, shape (N,)
        When these were measured, ns, plus what the stamps are off what the clock showed then.
    """

    place: int
    rows: slice | Integers | Booleans
    numbers: Integers
    times_ns: Integers


class SensorClocks:
    """The clocks of one sensor in the segments of a bag.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    name : str
        The sensor's.
    """

    def __init__(self, segments: Sequence[Segment], name: str) -> None:
        self._segments = segments
        self._models = [segment.scenario.sensors.on.get(name) for segment in segments]
        self._starts = np.array([segment.start_ns for segment in segments])
        self._previous_ns = int(self._starts[0])
        self.err = any(model is not None and errs(model) for model in self._models)
        shown = [self._shown_ns(place, self._starts[place : place + 2]) for place in range(len(segments))]
        self._from_ns = np.array([of_one[0] for of_one in shown]) - _ROUNDING_NS
        self.first_ns = int(self._from_ns.min())
        self._until_ns = np.array([*(of_one[-1] for of_one in shown[:-1]), _FAR - _ROUNDING_NS]) + _ROUNDING_NS

    def placed(self, stamps_ns: Integers, log_times_ns: Integers | None) -> list[PlacedReadings]:
        """The messages that come next by their segments; those that none of the clocks can have stamped are left out.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        log_times_ns : ndarray of int64, shape (N,), or None
            When the readings arrived, which tells the segments. None: of several clocks that show a stamp, the right
            one is that which shows it at the time nearest to the reading before.
        """
        if log_times_ns is None and self.err:
            return list(self._by_stamps(stamps_ns))
        told = stamps_ns if log_times_ns is None else log_times_ns
        return [
            PlacedReadings(place, rows, *self._read(place, stamps_ns[rows])[:2])
            for place, rows in segment_parts(self._segments, told)
        ]

    def _by_stamps(self, stamps_ns: Integers) -> Iterator[PlacedReadings]:
        near = (self._from_ns <= stamps_ns.max()) & (self._until_ns >= stamps_ns.min())
        found = [(place, *self._inside(place, stamps_ns)) for place in np.flatnonzero(near).tolist()]
        if not found:
            return
        places = np.concatenate([np.full(len(rows), place) for place, rows, *_ in found])
        rows, numbers, times, off = (np.concatenate([part[i] for part in found]) for i in (1, 2, 3, 4))
        least = np.full(len(stamps_ns), _FAR)
        np.minimum.at(least, rows, np.abs(off))
        best = np.flatnonzero(np.abs(off) == least[rows])
        best = best[np.argsort(rows[best], kind="stable")]
        _, chosen, counts = np.unique(rows[best], return_index=True, return_counts=True)
        for i in np.flatnonzero(counts > 1).tolist():
            options = times[best[chosen[i] : chosen[i] + counts[i]]]
            before = times[best[chosen[i - 1]]] if i else self._previous_ns
            chosen[i] += np.argmin(np.abs(options - before))
        if len(chosen):
            self._previous_ns = int(times[best[chosen[-1]]])
        for place in np.unique(places[best[chosen]]).tolist():
            own = best[chosen][places[best[chosen]] == place]
            yield PlacedReadings(place, rows[own], numbers[own], times[own])

    def _inside(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers, Integers, Integers]:
        """Stamps that the clock may have shown within a segment: which they are, and what `_read` gives of them."""
        numbers, times, off = self._read(place, stamps_ns)
        inside = np.flatnonzero(np.searchsorted(self._starts, times - off, side="right") - 1 == place)
        return inside, numbers[inside], times[inside], off[inside]

    def _read(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers, Integers]:
        """The readings of a segment that are nearest to stamps: numbers, times with what is off, and that alone, ns."""
        segment, model = self._segments[place], self._models[place]
        if model is None:
            return number_samples(segment.clock(), stamps_ns), stamps_ns, np.zeros_like(stamps_ns)
        clock, delivery = SampleClock(segment.scenario.epoch_ns, model.rate), model.delivery
        near = stamps_ns if delivery is None else delivery.measured_ns(stamps_ns, clock.epoch_ns)
        numbers = number_samples(clock, np.clip(near, 0, MAX_EPOCH_NS - int(clock.period_ns)))
        measured = grid(clock, numbers)
        off = stamps_ns - self._shown_ns(place, measured)
        return numbers, measured + off, off

    def _shown_ns(self, place: int, measured_ns: Integers) -> Integers:
        """What the clock shows at some times in a segment, ns."""
        delivery = getattr(self._models[place], "delivery", None)
        epoch_ns = self._segments[place].scenario.epoch_ns
        return measured_ns if delivery is None else measured_ns + delivery.error_ns(measured_ns, epoch_ns)


def errs(model: SensorModel) -> bool:
    """Whether the clock that stamps a sensor's readings errs."""
    return model.delivery is not None and model.delivery.is_off


def measured_ns(recording: Recording, name: str) -> Integers:
    """When the readings on a topic of a recorder's bag were measured, ns: their stamps, unless a clock errs."""
    messages = recording.readings[name]
    assert isinstance(messages, SensorMessages)
    segments = [*declared_segments(text for _, text in recording.scenario_texts).values()]
    sensor = next(key for key, entry in SENSORS.items() if name in {topic.name for topic in entry.topics})
    clocks, measured = SensorClocks(segments, sensor), np.full(len(messages), -1)
    if clocks.err:
        for part in clocks.placed(messages.stamps_ns, None):
            measured[part.rows] = part.times_ns
    return messages.stamps_ns if (measured < 0).any() else measured  # as good as any where no clock shows a stamp
