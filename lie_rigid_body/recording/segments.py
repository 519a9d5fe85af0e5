"""Segments of a bag, from one reset to the next, and by which of them a message was measured, as what number.

The clock of a sensor shows s = t + o + rint(σ (t − t₀)) at the time t; offset o, skew σ and epoch t₀ are those of the
segment's scenario. `TransportFaults.measured_ns` inverts this to 8 ns, so that the nearest reading of the sensor's grid
is the right one up to 60 million readings in a second. What the clock shows at that reading is compared with the stamp
to the nanosecond.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterable, Iterator, Sequence
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Booleans, Integers
from lie_rigid_body.foundation.errors import BagError, InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.topic_messages import TopicMessages
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.simulation.segment import Arrivals

MOST_SEGMENTS: Final = 10_000
"""Largest number of segments of a bag: each takes up to 1 ms."""
UNNAMED: Final = "the bag"
"""Name that errors give a bag without a name."""
_ROUNDING_NS: Final = 8
"""Largest rounding error, ns, of the time at which a sensor's erring clock shows a stamp."""
_FAR: Final = np.iinfo(np.int64).max


def declared_segments(scenario_texts: Iterable[str], bag: str = UNNAMED) -> dict[str, Segment]:
    """Segments by the texts that declare them, in the order of their starts, and of their texts where these are equal.

    A text that comes again counts once. It counts where it comes last if another of the same start came between, as of
    resets while the run is paused.

    Parameters
    ----------
    scenario_texts : iterable of str
    bag : str, optional
        Name of the bag, for errors.

    Raises
    ------
    BagError
        If a scenario message cannot be read.
    ParameterError
        If one declares what cannot be, such as an impossible inertia.
    """
    texts = list(scenario_texts)
    distinct = len({*texts})
    if distinct > MOST_SEGMENTS:
        raise BagError(f"{bag} declares {distinct} segments: at most {MOST_SEGMENTS} are read, record fewer resets")
    segments, latest = dict[str, Segment](), dict[int, str]()
    try:
        for text in texts:
            segment = segments.get(text) or Segment.from_json(text)
            if latest.get(segment.start_ns) != text:
                segments.pop(text, None)
                segments[text], latest[segment.start_ns] = segment, text
    except ParameterError:
        raise
    except InputError as error:
        raise BagError(f"{bag} does not explain itself: {error}: record it anew") from None
    return dict(sorted(segments.items(), key=lambda item: item[1].start_ns))


def segment_parts(segments: Sequence[Segment], stamps_ns: Integers) -> Iterator[tuple[int, slice | Booleans]]:
    """Places of the segments that stamps belong to, and which of the stamps are theirs.

    Stamps before the first segment are left out.
    """
    if not len(stamps_ns):
        return
    starts = np.array([segment.start_ns for segment in segments])
    lowest, highest = np.searchsorted(starts, [stamps_ns.min(), stamps_ns.max()], side="right") - 1
    if lowest == highest >= 0:
        yield int(lowest), slice(None)
        return
    at = np.searchsorted(starts, stamps_ns, side="right") - 1
    for i in np.unique(at[at >= 0]).tolist():
        yield i, at == i


def segments_with_samples(
    segments: Sequence[Segment], seen: Container[int], *, whole: bool
) -> Iterator[tuple[int, int | None]]:
    """Places of the segments that have samples or lack them, and where the next one starts, ns, if there is one.

    A segment without a sample lacks some if recording had begun before it, and no reset followed it at once.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    seen : container of int
        Places of those that have a pose or a twist.
    whole : bool
        Whether the bag is to be whole from its run's first sample on.
    """
    begun = whole
    for i, (segment, later) in enumerate(itertools.zip_longest(segments, segments[1:])):
        following = None if later is None else later.start_ns
        if i in seen or (begun and following is not None and following > segment.start_ns):
            yield i, following
            begun = True


def number_samples(clock: SampleClock, stamps_ns: Integers) -> Integers:
    """Numbers of the grid's samples nearest to the stamps.

    Parameters
    ----------
    clock : SampleClock
    stamps_ns : ndarray of int64, shape (N,)

    Returns
    -------
    ndarray of int64, shape (N,)
    """
    # in two parts, as the product of a long time and a rate exceeds 53 bits
    elapsed = stamps_ns - clock.epoch_ns
    whole = elapsed // NS  # half of the time of `divmod`
    in_rest = (elapsed - whole * NS) * (clock.rate * 1e-9)
    rate = int(clock.rate)
    return whole * rate + np.rint(whole * (clock.rate - rate) + in_rest).astype(np.int64)


def grid(clock: SampleClock, numbers: Integers) -> Integers:
    """The exact stamps of samples by their numbers, ns."""
    low, high = int(numbers.min()), int(numbers.max())
    if high - low > 4 * numbers.size + 1000:  # far-off stamps: no table of all between
        return np.array([clock.stamp_ns(int(k)) for k in numbers], dtype=np.int64)
    return clock.stamps_ns(low, high - low + 1)[numbers - low]


@short_dataclass(frozen=True)
class PlacedMessages:
    """Messages of a sensor's topic that belong to one segment.

    Parameters
    ----------
    place : int
        That of the segment among those declared.
    messages : TopicMessages
    numbers : ndarray of int64, shape (N,)
        Numbers of the nearest readings of the sensor there.
    times_ns : ndarray of int64, shape (N,)
        When these were measured, ns, plus what the stamps are off what the clock showed then.
    """

    place: int
    messages: TopicMessages
    numbers: Integers
    times_ns: Integers


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
        self._previous_ns = int(self._starts[0]) - 1
        deliveries = [model.delivery for model in self._models if model is not None]
        self.err = any(delivery is not None and delivery.has_clock_error for delivery in deliveries)
        shown = [self._shown_ns(place, self._starts[place : place + 2]) for place in range(len(segments))]
        self._from_ns = np.array([of_one[0] for of_one in shown]) - _ROUNDING_NS
        self._until_ns = np.array([*(of_one[-1] for of_one in shown[:-1]), _FAR - _ROUNDING_NS]) + _ROUNDING_NS
        self.early, self.unshown = 0, (0, 0)
        self._arriving = dict[int, tuple[int, int]]()  # by places, the first reading and that which arrives too late

    def placed(self, messages: TopicMessages, *, in_order: bool) -> Iterator[PlacedMessages]:
        """The messages that come next by their segments, in the order of these.

        Parameters
        ----------
        messages : TopicMessages
        in_order : bool
            Whether their log times are those at which the readings arrived, which tell the segments. Otherwise, of
            several clocks that show a stamp, the right one is that which shows it first after the reading before.
        """
        stamps, left = messages.stamps_ns, np.ones(len(messages), dtype=np.bool_)
        for place, rows, numbers, times_ns in self.parts(messages.log_times_ns, stamps, in_order=in_order):
            left[rows] = False
            yield PlacedMessages(place, messages[rows], numbers, times_ns)
        early = left & (stamps < self._from_ns.min()) if self.err and not in_order else left
        self.early += int(np.count_nonzero(early))
        unshown = stamps[left & ~early]
        if len(unshown):
            self.unshown = self.unshown[0] + len(unshown), self.unshown[1] or int(unshown[0])

    def parts(self, times_ns: Integers, stamps_ns: Integers, *, in_order: bool) -> Iterator[_Part]:
        """The segments that messages belong to, by their log times and stamps; see `placed`."""
        if self.err and not in_order:
            yield from self._by_stamps(stamps_ns)
            return
        for place, rows in segment_parts(self._segments, times_ns if in_order else stamps_ns):
            yield place, rows, *self._read(place, stamps_ns[rows])[:2]

    def _by_stamps(self, stamps_ns: Integers) -> Iterator[_Part]:
        near = np.flatnonzero((self._from_ns <= stamps_ns.max()) & (self._until_ns >= stamps_ns.min()))
        shown = (self._inside(place, stamps_ns) for place in near.tolist())
        found = np.concatenate([np.empty((5, 0), dtype=np.int64), *shown], axis=1)
        least = np.full(len(stamps_ns), _FAR)
        np.minimum.at(least, found[0], np.abs(found[1]))
        best = found[:, np.abs(found[1]) == least[found[0]]]
        rows, _, places, numbers, times = best[:, np.argsort(best[0], kind="stable")]
        _, chosen, counts = np.unique(rows, return_index=True, return_counts=True)
        for i in np.flatnonzero(counts > 1).tolist():
            before = times[chosen[i - 1]] if i else self._previous_ns
            since = times[chosen[i] : chosen[i] + counts[i]] - before  # readings arrive in the order of their times
            chosen[i] += np.argmin(np.where(since > 0, since, _FAR + since))
        if len(chosen):
            self._previous_ns = int(times[chosen[-1]])
        for place in np.unique(places[chosen]).tolist():
            own = chosen[places[chosen] == place]
            yield place, rows[own], numbers[own], times[own]

    def _inside(self, place: int, stamps_ns: Integers) -> Integers:
        """Rows of the stamps that the clock may have shown within a segment: which, how far off, and what `_Part` has.

        Shape (5, K).
        """
        numbers, times, off = self._read(place, stamps_ns)
        is_early = times < self._starts[0] - _ROUNDING_NS  # near a reading, but of an untold scenario
        rows = np.flatnonzero((np.searchsorted(self._starts, times - off, side="right") - 1 == place) & ~is_early)
        # where there is no sensor, or none arrives, any clock of another shows a stamp rather
        off = np.where(self._arrives(place, numbers[rows], (times - off)[rows]), off[rows], _FAR)
        return np.stack([rows, off, np.full(len(rows), place), numbers[rows], times[rows]])

    def _arrives(self, place: int, numbers: Integers, measured_ns: Integers) -> Booleans:
        """Whether readings within a segment arrive: its sensor is on, loses none of them, and no reset comes before."""
        segment, model = self._segments[place], self._models[place]
        if model is None or model.delivery is None or not len(numbers):
            return np.full(len(numbers), model is not None)
        if place not in self._arriving:
            clock = SampleClock(segment.scenario.epoch_ns, model.rate)
            first = clock.count_until(segment.start_ns - 1)
            end_ns = int(self._starts[place + 1]) - 1 if place + 1 < len(self._starts) else MAX_EPOCH_NS + 1
            arrivals = Arrivals(clock, first, segment.start_ns, model.delivery)
            self._arriving[place] = first, arrivals.count_until(end_ns)
        first, end = self._arriving[place]
        return (numbers < end) & ~model.delivery.lost(numbers - first, measured_ns - segment.start_ns)

    def _read(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers, Integers]:
        """The readings of a segment that are nearest to stamps: numbers, times with what is off, and that alone, ns."""
        segment, model = self._segments[place], self._models[place]
        if model is None:
            return number_samples(segment.clock(), stamps_ns), stamps_ns, np.zeros_like(stamps_ns)
        clock, delivery = SampleClock(segment.scenario.epoch_ns, model.rate), model.delivery
        near = stamps_ns if delivery is None else delivery.measured_ns(stamps_ns, clock.epoch_ns)
        last = clock.count_until(MAX_EPOCH_NS) - 1
        numbers = np.minimum(number_samples(clock, np.clip(near, 0, MAX_EPOCH_NS)), last)
        measured = grid(clock, numbers)
        off = stamps_ns - self._shown_ns(place, measured)
        return numbers, measured + off, off

    def _shown_ns(self, place: int, measured_ns: Integers) -> Integers:
        """What the clock shows at some times in a segment, ns."""
        delivery = getattr(self._models[place], "delivery", None)
        epoch_ns = self._segments[place].scenario.epoch_ns
        return measured_ns if delivery is None else measured_ns + delivery.error_ns(measured_ns, epoch_ns)


def measured_ns(segments: Sequence[Segment], sensor: str, stamps_ns: Integers) -> Integers:
    """When the readings of a sensor in a recorder's bag were measured, ns: their stamps, unless a clock errs.

    Parameters
    ----------
    segments : sequence of Segment
        All that the bag declares.
    sensor : str
        Its name.
    stamps_ns : ndarray of int64, shape (N,)
    """
    clocks, measured = SensorClocks(segments, sensor), np.empty_like(stamps_ns)
    parts = list(clocks.parts(stamps_ns, stamps_ns, in_order=False)) if clocks.err and len(stamps_ns) else []
    for _, rows, _, times_ns in parts:
        measured[rows] = times_ns
    is_told = sum(len(numbers) for _, _, numbers, _ in parts) == len(stamps_ns)
    return measured if is_told else stamps_ns  # as good as any where no clock shows a stamp
