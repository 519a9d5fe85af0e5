"""The messages of one sensor's topic in one segment, held against what the scenario determines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.certificate.erring_clocks import shown_ns
from lie_rigid_body.certificate.imu_readings import BiasReadings, ImuReadings
from lie_rigid_body.certificate.law_result import Judgement, LawResult
from lie_rigid_body.certificate.pointing_readings import AttitudeReadings, SunReadings
from lie_rigid_body.certificate.readings import (
    BLOCK,
    FieldReadings,
    Readings,
    sensor_clock,
)
from lie_rigid_body.certificate.residuals_over_time import Watch
from lie_rigid_body.certificate.stamps import NONE_LOST, Lost, StampTally
from lie_rigid_body.certificate.surveyed_segment import SurveyedSegment
from lie_rigid_body.certificate.tolerance import ATTITUDE_CAP
from lie_rigid_body.messages import ReadingEncoder
from lie_rigid_body.messages.encoding import told_fields
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.segments import number_samples
from lie_rigid_body.recording.sensor_reader import SensorMessages, value_columns, varying_fields
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Sensor, SensorModel, Topic
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.simulation.arrivals import Arrivals

MOST_LEFT_OUT: Final = 200_000_000
"""Readings before the first of a bag whose biases are computed all the same, as they walk. They take a minute."""
_MOST_IN_VAIN: Final = 1_000_000
"""Missing readings that are computed with their neighbours, beyond one for each that is not missing."""
MOST_LOST: Final = 100
"""Readings that a sensor may have lost for each that a recorder has, where it has no truth beside them."""
_HELD_BACK: Final = 1024
"""Readings that wait for others which stand behind them in the file, though they come first."""
_READINGS: Final[Mapping[str, Callable[[Segment, float], Readings]]] = {
    "imu/data_raw": ImuReadings,
    "imu/bias": BiasReadings,
    "imu/mag": FieldReadings,
    "attitude/pose": AttitudeReadings,
    "sun/direction": SunReadings,
}
_OFF: Final = "{field} is {{worst}}{unit} off what the scenario determines (limit {{limit}}) at {{where}}"
VALUES: Final = frozenset(f.quantity for sensor in SENSORS.values() for topic in sensor.topics for f in topic.fields)
"""The laws of readings, which depend on how this software computes noise."""


class Work:
    """How many readings may still be computed that the bag lacks."""

    def __init__(self) -> None:
        self._walked = self._in_vain = 0

    def allows(self, walked: int, in_vain: int, recorded: int) -> bool:
        """Take so many more, unless they are too many.

        Parameters
        ----------
        walked : int
            Left out, but for what a bias walks in them.
        in_vain : int
            Computed because recorded ones stand before and after them.
        recorded : int
            Computed, and held against recorded ones.
        """
        if self._walked + walked > MOST_LEFT_OUT or self._in_vain + in_vain > _MOST_IN_VAIN:
            return False
        self._walked += walked
        self._in_vain = max(0, self._in_vain + in_vain - recorded)
        return True


class TopicLaws:
    """One topic's readings of a segment as they come.

    Parameters
    ----------
    found : SurveyedSegment
    successors : sequence of Segment
        Those that begin where this one ends.
    name, topic : str
        The topic's relative and full name.
    work : Work
    watch : Watch, optional
        It is told of the residuals of all readings that are compared.

    Attributes
    ----------
    clock : SampleClock or None
        Of the sensor; None if the scenario has no such sensor.
    first : int
        Number of the first reading of the segment.
    tally : StampTally
    strays : int
        Readings of a sensor that the scenario has not.
    is_too_far : bool
        Whether the readings were not compared, as too many are missing.
    """

    def __init__(
        self,
        found: SurveyedSegment,
        successors: Sequence[Segment],
        name: str,
        topic: str,
        work: Work,
        watch: Watch | None = None,
    ) -> None:
        self.found, self.name, self.topic, self._work = found, name, topic, work
        self._successors, segment = successors, found.segment
        self.end_ns = successors[0].start_ns - 1 if successors else None
        self.strays, self.is_too_far, self._is_finished, self._motion_error = 0, False, False, 0.0
        model = model_of(segment.scenario, name)
        self.clock: SampleClock | None = None
        self._arrivals: Arrivals | None = None
        self._is_late, self.first = model is not None and model.delivery is not None, 0
        if model is not None:
            self.clock, self.first = sensor_clock(segment, model.rate)
            self._arrivals = Arrivals(self.clock, self.first, segment.start_ns, model.delivery)
        self.tally = StampTally(self.clock or segment.clock(), "reading", partial(shown_ns, segment, model))
        self.sensor, self._table_topic = entry_of(name)
        self._alike = Judgement(
            self._table_topic.title, "", "frame or covariances are not as declared, at {where}", "reading"
        )
        model = model or self.sensor.model.from_values(dict(segment.scenario.sensor_parameters))
        fields = told_fields(self._table_topic, model)
        self._columns = [value_columns(self._table_topic, field) for field in fields]
        self._values = [
            Judgement(
                f.quantity,
                f.unit,
                _OFF.format(field=f.place.rpartition(".")[2].replace("_", " "), unit=f" {f.unit}" if f.unit else ""),
                "reading",
                watch,
            )
            for f in fields
        ]
        self._readings: Readings | None = None
        none, width = np.empty(0, dtype=np.int64), int(varying_fields(self._table_topic.message_type).sum())
        self._fixed = np.full(width, fill_value=True)
        for columns in self._columns:
            self._fixed[columns] = False
        self._waiting = _Recorded(none, none, np.empty((0, width)))

    @property
    def goes_on(self) -> bool:
        """Whether the sensor is there after the segment as well."""
        return all(model_of(later.scenario, self.name) is not None for later in self._successors)

    @property
    def last_sample_ns(self) -> int:
        """Stamp of the truth's last sample before the segment ends, ns."""
        assert self.end_ns is not None
        clock = self.found.segment.clock()
        return clock.stamp_ns(clock.count_until(self.end_ns) - 1)

    def arrived_until(self, time_ns: int) -> int:
        """How many readings of the clock, from number 0 on, arrive at or before a time."""
        assert self._arrivals is not None
        return self._arrivals.count_until(time_ns)

    def logged_otherwise(self, messages: SensorMessages) -> int:
        """How many of some messages are not logged when they arrive."""
        if self.clock is None or self._arrivals is None or not self._is_late or not len(messages):
            return int(np.count_nonzero(messages.log_times_ns != messages.stamps_ns))
        numbers = number_samples(self.clock, messages.stamps_ns)
        off = 0
        for some in np.unique(numbers // BLOCK):
            rows = np.flatnonzero(numbers // BLOCK == some)
            low, high = int(numbers[rows].min()), int(numbers[rows].max())
            if low < self.first:
                off += len(rows)
                continue
            times, _, _ = self._arrivals.of(self.clock.stamps_ns(low, high - low + 1))
            off += int(np.count_nonzero(times[numbers[rows] - low] != messages.log_times_ns[rows]))
        return off

    def lost(self, last: int) -> Lost:
        """The readings of the segment that never arrived, up to a number; none far behind all messages."""
        segment, clock, first = self.found.segment, self.clock, self.first
        model = model_of(segment.scenario, self.name)
        delivery = None if model is None else model.delivery
        if clock is None or delivery is None:
            return NONE_LOST
        # a forged stamp may lie years ahead
        truth_ns = (self.found.last_ns or segment.start_ns) + round(2 * NS / segment.scenario.rate) + NS
        most = max(clock.count_until(truth_ns), first + MOST_LOST * self.tally.count)
        return Lost(
            first,
            min(last + 1, most),
            lambda k, n: delivery.lost(k - first, clock.stamps_ns(k, n) - segment.start_ns),
        )

    def add(self, messages: SensorMessages) -> None:
        """Take the messages that come next."""
        if self.clock is None:
            self.strays += len(messages)
            return
        numbers = number_samples(self.clock, messages.stamps_ns)
        self.tally.add(messages.stamps_ns)
        self._alike.add(np.where(self._is_unlike(messages), 1.0, 0.0), 0.0, numbers, messages.stamps_ns)
        if not self._is_finished:
            self._waiting = self._waiting.followed_by(_Recorded(numbers, messages.stamps_ns, messages.values))
            self._compare(max(0, len(self._waiting.numbers) - _HELD_BACK))

    def finish(self) -> None:
        """Compare those that wait; later ones are compared no more."""
        if not self._is_finished:
            self._compare(len(self._waiting.numbers))
            self._is_finished, self._readings = True, None
            self._waiting = self._waiting[:0].followed_by(self._waiting[:0])  # a view would keep all that waited

    def results(self) -> Iterator[LawResult]:
        """How near the laws of the messages' content came to their limits."""
        for law in [*([] if self.is_too_far else self._values), self._alike]:
            yield self._named(law.result())

    def _named(self, law: LawResult) -> LawResult:
        """A law whose message, if it is broken, tells topic, time, and whether the stepper is to blame."""
        if law.holds or law.stamp_ns is None:
            return law
        time_s = (law.stamp_ns - self.found.segment.start_ns) / 1e9
        message = f"{self.topic:.60}: {law.message}, {time_s:.9g} s after the start"
        if law.name in VALUES and self._motion_error > ATTITUDE_CAP:
            message += (
                f": between these readings the declared stepper errs by up to {self._motion_error:.2g} rad, "
                f"a ground truth by {ATTITUDE_CAP:g} at most"
            )
        return replace(law, message=message)

    def _is_unlike(self, messages: SensorMessages) -> Booleans:
        """Which messages have another frame or other fixed fields than the scenario makes them have."""
        frame, rest, values = _fixed_fields(self.found.segment.scenario)[self.name]
        own = [name == frame and np.array_equal(np.frombuffer(numbers), rest) for name, numbers in messages.kinds]
        unlike = ~np.array(own, dtype=bool)[messages.kind]
        return np.asarray(unlike | (messages.values[:, self._fixed] != values[self._fixed]).any(axis=1))

    def _compare(self, count: int) -> None:
        """Compare the first of those that wait."""
        ready, self._waiting = self._waiting[:count], self._waiting[count:]
        if self.is_too_far or not count:
            return
        readings = self._readings = self._readings or _READINGS[self.name](self.found.segment, self.found.duration)
        self._motion_error = readings.motion_error
        ready = ready[int(np.searchsorted(ready.numbers, readings.next)) :]
        while len(ready.numbers):
            first = int(ready.numbers[0])
            end = int(np.searchsorted(ready.numbers, first + BLOCK))
            block, ready = ready[:end], ready[end:]
            count = int(block.numbers[-1]) - first + 1
            left_out, between = first - readings.next, max(0, count - end)
            in_vain = between + left_out if readings.repeats else between
            if not self._work.allows(left_out if readings.walks else 0, in_vain, end):
                self.is_too_far = True
                return
            for law, columns, expected in zip(self._values, self._columns, readings.take(first, count), strict=True):
                own = expected if count == end else expected[block.numbers - first]
                law.add(*own.residuals(block.values[:, columns]), block.numbers, block.stamps_ns)


@dataclass(frozen=True)
class _Recorded:
    """Recorded readings by their numbers, rising."""

    numbers: Integers
    stamps_ns: Integers
    values: Array

    def followed_by(self, later: _Recorded) -> _Recorded:
        """These and later ones, in order."""
        both = _Recorded(
            np.concatenate([self.numbers, later.numbers]),
            np.concatenate([self.stamps_ns, later.stamps_ns]),
            np.concatenate([self.values, later.values]),
        )
        return both if (np.diff(both.numbers) >= 0).all() else both[np.argsort(both.numbers, kind="stable")]

    def __getitem__(self, rows: slice | Integers) -> _Recorded:
        return _Recorded(self.numbers[rows], self.stamps_ns[rows], self.values[rows])


def entry_of(name: str) -> tuple[Sensor, Topic]:
    """The sensor of a topic, and the topic, in the table."""
    return next((sensor, topic) for sensor in SENSORS.values() for topic in sensor.topics if topic.name == name)


def model_of(scenario: Scenario, name: str) -> SensorModel | None:
    """The sensor of a topic, if the scenario has it."""
    return scenario.sensors.on.get(entry_of(name)[0].name)


@lru_cache(maxsize=4)
def _fixed_fields(scenario: Scenario) -> Mapping[str, tuple[str, Array, Array]]:
    """Of each sensor's topic the frame, the numbers beside the values, and values of a reading, as they are encoded."""
    found = {}
    for name, model in scenario.sensors.on.items():
        for topic in SENSORS[name].topics:
            encoder, varying = ReadingEncoder(topic, model, scenario), varying_fields(topic.message_type)
            numbers = np.array(encoder.numbers)
            found[topic.name] = encoder.frame, numbers[~varying], numbers[varying]
    return found
