"""The segments that readings of a sensor belong to, and their numbers, by the clocks that stamp them.

The clock of a sensor shows s = t + o + rint(σ (t − t₀)) at the time t; offset o, skew σ and epoch t₀ are those of the
segment's scenario. `Delivery.measured_ns` inverts this to 8 ns, so that the nearest reading of the sensor's grid is the
right one up to 60 million readings in a second, and what the clock shows at that reading is compared with the stamp
to the nanosecond.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.recording.segments import declared_segments, grid, number_samples, segment_parts
from lie_rigid_body.recording.sensor_reader import SensorMessages
from lie_rigid_body.recording.tracks import Recording
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.wording import short_repr

_ROUNDING_NS: Final = 8
"""Largest error of the time at which a clock that errs shows a stamp, ns."""
_FAR: Final = np.iinfo(np.int64).max


@dataclass(frozen=True)
class PlacedMessages:
    """Messages of a sensor's topic that belong to one segment.

    Parameters
    ----------
    place : int
        That of the segment among those declared.
    messages : SensorMessages
    numbers : ndarray of int64, shape (N,)
        Numbers of the nearest readings of the sensor there.
    times_ns : ndarray of int64, shape (N,)
        When these were measured, ns, plus what the stamps are off what the clock showed then.
    """

    place: int
    messages: SensorMessages
    numbers: Integers
    times_ns: Integers

    __repr__ = short_repr


_Part: TypeAlias = tuple[int, slice | Integers | Booleans, Integers, Integers]
"""Place of a segment, which messages are of it, the numbers of their readings, and when these were measured, ns."""


class SensorClocks:
    """The clocks of one sensor in the segments of a bag.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    name : str
        The sensor's.

    Attributes
    ----------
    err : bool
        Whether any of them errs.
    early : int
        Messages before the first segment.
    unshown : (int, int)
        Messages whose stamp no clock shows within its segment: how many, and the first stamp, ns.
    """

    def __init__(self, segments: Sequence[Segment], name: str) -> None:
        self._segments = segments
        self._models = [segment.scenario.sensors.on.get(name) for segment in segments]
        self._starts = np.array([segment.start_ns for segment in segments])
        self._previous_ns = int(self._starts[0])
        deliveries = [model.delivery for model in self._models if model is not None]
        self.err = any(delivery is not None and delivery.is_off for delivery in deliveries)
        shown = [self._shown_ns(place, self._starts[place : place + 2]) for place in range(len(segments))]
        self._from_ns = np.array([of_one[0] for of_one in shown]) - _ROUNDING_NS
        self._until_ns = np.array([*(of_one[-1] for of_one in shown[:-1]), _FAR - _ROUNDING_NS]) + _ROUNDING_NS
        self.early, self.unshown = 0, (0, 0)

    def placed(self, messages: SensorMessages, *, in_order: bool) -> Iterator[PlacedMessages]:
        """The messages that come next by their segments, in the order of these.

        Parameters
        ----------
        messages : SensorMessages
        in_order : bool
            Whether their log times are those at which the readings arrived, which tell the segments. Otherwise, of
            several clocks that show a stamp, the right one is that which shows it at the time nearest to the reading
            before.
        """
        stamps, left = messages.stamps_ns, np.ones(len(messages), dtype=np.bool_)
        told = messages.log_times_ns if in_order else stamps
        by_stamps = self.err and not in_order
        for place, rows, numbers, times_ns in self._by_stamps(stamps) if by_stamps else self._by_times(told, stamps):
            left[rows] = False
            yield PlacedMessages(place, messages[rows], numbers, times_ns)
        early = left & (stamps < self._from_ns.min()) if by_stamps else left
        self.early += int(np.count_nonzero(early))
        unshown = stamps[left & ~early]
        if len(unshown):
            self.unshown = self.unshown[0] + len(unshown), self.unshown[1] or int(unshown[0])

    def _by_times(self, times_ns: Integers, stamps_ns: Integers) -> Iterator[_Part]:
        for place, rows in segment_parts(self._segments, times_ns):
            yield place, rows, *self._read(place, stamps_ns[rows])[:2]

    def _by_stamps(self, stamps_ns: Integers) -> Iterator[_Part]:
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
            yield place, rows[own], numbers[own], times[own]

    def _inside(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers, Integers, Integers]:
        """Stamps that the clock may have shown within a segment: which they are, and what `_read` gives of them."""
        numbers, times, off = self._read(place, stamps_ns)
        inside = np.flatnonzero(np.searchsorted(self._starts, times - off, side="right") - 1 == place)
        if self._models[place] is None:
            off = np.full_like(off, _FAR)  # where there is no sensor, any clock of one shows a stamp rather
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


def measured_ns(recording: Recording, name: str) -> Integers:
    """When the readings on a topic of a recorder's bag were measured, ns: their stamps, unless a clock errs."""
    messages = recording.readings[name]
    assert isinstance(messages, SensorMessages)
    segments = [*declared_segments(text for _, text in recording.scenario_texts).values()]
    sensor = next(key for key, entry in SENSORS.items() if name in {topic.name for topic in entry.topics})
    clocks = SensorClocks(segments, sensor)
    rows = replace(messages, values=np.arange(len(messages), dtype=np.float64)[:, np.newaxis])
    parts = list(clocks.placed(rows, in_order=False)) if clocks.err else []
    if sum(len(part.numbers) for part in parts) < len(messages):
        return messages.stamps_ns  # as good as any where no clock shows a stamp
    measured = np.empty_like(messages.stamps_ns)
    for part in parts:
        measured[part.messages.values[:, 0].astype(np.int64)] = part.times_ns
    return measured
