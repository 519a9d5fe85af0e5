"""Segments of a bag, from one reset to the next, and to which of them a message belongs, as which reading.

The clock of a sensor shows s = t + o + rint(σ (t − t₀)) at the time t; offset o, skew σ and epoch t₀ are those of the
segment's scenario. `TransportFaults.measured_ns` inverts this to 8 ns, so that the nearest reading of the sensor's grid
is the right one up to 60 million readings in a second. What the clock shows at that reading is compared with the stamp
to the nanosecond.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Booleans, Integers
from lie_rigid_body.foundation.errors import BagError, InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.topic_messages import TopicMessages
from lie_rigid_body.sensors.fault import nanoseconds
from lie_rigid_body.simulation import SampleClock, Segment

MAX_SEGMENTS: Final = 10_000
"""Largest number of segments of a live estimate: each takes up to 1 ms."""
UNNAMED: Final = "the bag"
"""Name that errors give a bag without a name."""


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
    segments = dict[str, Segment]()
    latest = dict[int, str]()
    try:
        for text in scenario_texts:
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
    yield from parts_between(np.array([segment.start_ns for segment in segments]), stamps_ns)


def parts_between(starts: Integers, stamps_ns: Integers) -> Iterator[tuple[int, slice | Booleans]]:
    """Places of the starts, ns, after which stamps come, and which of the stamps; earlier ones are left out."""
    if not len(stamps_ns):
        return
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
    low = int(numbers.min())
    high = int(numbers.max())
    if high - low > 4 * numbers.size + 1000:  # far-off stamps: no table of all between
        return np.array([clock.stamp_ns(int(k)) for k in numbers], dtype=np.int64)
    return clock.stamps_ns(low, high - low + 1)[numbers - low]


@short_dataclass
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
    differ : bool
        Whether a reset changes a clock that errs: stamps alone do not tell then by which a message was stamped.
    early : int
        Messages before the first segment.
    """

    def __init__(self, segments: Sequence[Segment], name: str) -> None:
        self._segments = segments
        self._models = [segment.scenario.sensors.on.get(name) for segment in segments]
        errors = {_clock_error(segment, name) for segment in segments if name in segment.scenario.sensors.on}
        self.err = any(error is not None for error in errors)
        self.differ = self.err and len(errors) > 1
        deliveries = [model.delivery for model in self._models if model is not None]
        # without the sensor a segment has no clock of its own
        self._deliveries = [next(iter(deliveries), None) if model is None else model.delivery for model in self._models]
        shown = [int(self._shown_ns(i, np.array([each.start_ns]))[0]) for i, each in enumerate(segments)]
        self._shown_starts = np.maximum.accumulate(shown)
        self._starts = np.array([segment.start_ns for segment in segments])
        self.early = 0

    def placed(self, messages: TopicMessages, *, in_order: bool) -> Iterator[PlacedMessages]:
        """The messages that come next by their segments, in the order of these.

        Parameters
        ----------
        messages : TopicMessages
        in_order : bool
            Whether their log times are those at which the readings arrived, which tell the segments; otherwise their
            stamps do.
        """
        times_ns = messages.log_times_ns if in_order else messages.stamps_ns
        starts = self._starts if in_order else self._shown_starts
        self.early += int(np.count_nonzero(times_ns < starts[0]))
        for place, rows in parts_between(starts, times_ns):
            own = messages[rows]
            yield PlacedMessages(place, own, *self._read(place, own.stamps_ns))

    def _read(self, place: int, stamps_ns: Integers) -> tuple[Integers, Integers]:
        """Numbers of the readings of a segment that are nearest to stamps, and times with what is off, ns."""
        segment = self._segments[place]
        model = self._models[place]
        clock = segment.clock() if model is None else SampleClock(segment.scenario.epoch_ns, model.rate)
        delivery = self._deliveries[place]
        near = stamps_ns if delivery is None else delivery.measured_ns(stamps_ns, clock.epoch_ns)
        last = clock.count_until(MAX_EPOCH_NS) - 1
        numbers = np.minimum(number_samples(clock, np.clip(near, 0, MAX_EPOCH_NS)), last)
        measured = grid(clock, numbers)
        return numbers, measured + stamps_ns - self._shown_ns(place, measured)

    def _shown_ns(self, place: int, measured_ns: Integers) -> Integers:
        """Times that the sensor's clock shows at some times in a segment, ns."""
        delivery = self._deliveries[place]
        epoch_ns = self._segments[place].scenario.epoch_ns
        return measured_ns if delivery is None else measured_ns + delivery.error_ns(measured_ns, epoch_ns)

    def measured_ns(self, stamps_ns: Integers) -> Integers:
        """When the readings of a recorder's bag were measured, ns: their stamps, unless the clock errs.

        Where a reset changes the clock, each stamp is read by that of the last segment whose start it shows.
        """
        measured = stamps_ns.copy()
        if self.err:
            for place, rows in parts_between(self._shown_starts, stamps_ns):
                measured[rows] = self._read(place, stamps_ns[rows])[1]
        return measured


def _clock_error(segment: Segment, name: str) -> tuple[int, float, int] | None:
    """Offset, skew and epoch of the clock of a sensor in a segment; None if it does not err."""
    delivery = segment.scenario.sensors.on[name].delivery
    if delivery is None or not delivery.has_clock_error:
        return None
    return (
        nanoseconds(delivery.clock_offset),
        delivery.clock_skew,
        bool(delivery.clock_skew) * segment.scenario.epoch_ns,
    )
