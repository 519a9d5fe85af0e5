"""The loop from a scenario to samples: the truth, the sensors and their faults, across torque-free resets."""

from __future__ import annotations

import copy
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from typing import Any, Final, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import Motion
from lie_rigid_body.motion.translation import Translation
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Fault, SensorModel
from lie_rigid_body.simulation.samples import Measurement, SampleQueue, Samples, SensorSamples
from lie_rigid_body.simulation.segment import SampleClock, Segment

Motions: TypeAlias = Callable[[Scenario], Callable[[], Motion]]
"""A function that makes the motions of a scenario; see `motions_of`."""

LOOK_AHEAD: Final = 64
"""Samples computed at once when fewer are wanted: the closed form takes as long for one as for all of them."""
STEPS_AHEAD: Final = 64
"""Largest number of integrator steps for samples that are not wanted yet, about 1 ms."""
_READINGS_AHEAD: Final = 64
"""Number of readings of the fastest sensor whose faults are sought at once, within a second: one alone takes as
long."""
_BEGIN: Final = attrgetter("begin_ns")


@short_dataclass
class SimulationStep:
    """Samples of the truth and readings of the sensors that were taken from a simulation at once, all of one segment.

    Parameters
    ----------
    samples : Samples
        The truth.
    sensors : mapping of str to SensorSamples
        The readings that arrived, by the names of the sensors that there are.
    faults : tuple of Fault
        The faults that began.
    scenario : Scenario or None
        The scenario of the segment, where it is known.
    """

    samples: Samples
    sensors: Mapping[str, SensorSamples] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()
    scenario: Scenario | None = None


class FaultLog:
    """The faults of the segments of a simulation, each told once."""

    def __init__(self) -> None:
        self._segments: list[_SegmentFaults] = []
        self._taken_ns = 0

    def follow(self, segment: Segment) -> None:
        """Begin with a segment, or continue with the next one."""
        for earlier in self._segments[-1:]:
            earlier.end_ns = segment.start_ns - 1
        self._segments.append(_SegmentFaults(segment))

    def end_ns(self, most: int) -> int:
        """Time, ns, up to which at most about so many faults of a kind can begin that were not taken yet."""
        rate = max(segment.most_per_second for segment in self._segments)
        return max(self._taken_ns, self._segments[0].start_ns) + int(most * NS / rate) if rate else 2 * MAX_EPOCH_NS

    def take(self, until_ns: int) -> tuple[Fault, ...]:
        """Faults that begin up to a time, ns, and were not taken yet."""
        self._taken_ns = max(self._taken_ns, until_ns)
        found = tuple(fault for faults in self._segments for fault in faults.take(min(until_ns, faults.end_ns)))
        self._segments = [faults for faults in self._segments if faults.end_ns > until_ns]
        return found


class _SegmentFaults:
    """The faults of one segment, found some time before they are taken."""

    def __init__(self, segment: Segment) -> None:
        self.start_ns = segment.start_ns
        self.end_ns = 2 * MAX_EPOCH_NS
        self._segment = segment
        self._known_ns = segment.start_ns
        self._ready = list[Fault]()
        self._faulty = [sensor for sensor in segment.scenario.sensors.on.values() if sensor.fault_models]
        fastest = max((sensor.rate for sensor in self._faulty), default=1.0)
        self.most_per_second = max((rate for sensor in self._faulty for rate in _rates(sensor)), default=0.0)
        self._ahead_ns = min(int(_READINGS_AHEAD * NS / fastest), NS)  # of slow ones no sea of episodes

    def take(self, until_ns: int) -> list[Fault]:
        if self._faulty and until_ns >= self._known_ns:
            end_ns = min(until_ns + 1 + self._ahead_ns, MAX_EPOCH_NS + 1)
            self._ready += sorted((fault for sensor in self._faulty for fault in self._of(sensor, end_ns)), key=_BEGIN)
            self._known_ns = end_ns
        count = bisect_right(self._ready, until_ns, key=_BEGIN)
        taken = self._ready[:count]
        self._ready = self._ready[count:]
        return taken

    def _of(self, sensor: SensorModel, end_ns: int) -> Iterator[Fault]:
        """Faults of a sensor from the time until which all are known to another, ns."""
        start_ns = self._segment.start_ns
        begin_ns = self._known_ns
        clock = SampleClock(self._segment.scenario.epoch_ns, sensor.rate)
        first = clock.count_until(begin_ns - 1)
        times = clock.stamps_ns(first, clock.count_until(end_ns - 1) - first) - start_ns
        first -= clock.count_until(start_ns - 1)
        for faulty in sensor.fault_models:
            for fault in faulty.faults(begin_ns - start_ns, end_ns - start_ns, first, times):
                yield fault.later(start_ns)


def _rates(sensor: SensorModel) -> Iterator[float]:
    """The most faults a second of each kind that a sensor has."""
    yield sensor.rate
    for faulty in sensor.fault_models:
        kinds = (getattr(faulty, kind) for kind in faulty.intermittent_kinds)
        yield from (NS / episodes.interval_ns for episodes in kinds if episodes is not None)


class _RunningSegment:
    """The truth and the sensors of one segment: a queue of samples for each clock.

    Parameters
    ----------
    segment : Segment
    motion : callable
        Makes the motion of each clock in turn, first of the truth.

    Attributes
    ----------
    end_ns : int
        Last time at which its samples are sent, ns. Readings that were to arrive later are lost.
    """

    def __init__(self, segment: Segment, motion: Callable[[], Motion]) -> None:
        scenario = segment.scenario
        self.segment = segment
        self.end_ns = 2 * MAX_EPOCH_NS
        ahead = partial(scenario.batch_size, LOOK_AHEAD, STEPS_AHEAD)
        self.clock = segment.clock()
        centre = scenario.mass_centre() if scenario.moves else None
        states = partial(_samples, motion(), centre, segment.start_ns)
        self.truth = SampleQueue(self.clock, segment.first_sample, states, ahead(scenario.rate))
        self.sensors: dict[str, SampleQueue[SensorSamples]] = {}
        for name in scenario.sensors.on:
            of = Measurement(segment, name, motion())
            self.sensors[name] = SampleQueue(of.clock, of.first, of.samples, ahead(of.model.rate), of.arrivals)

    @property
    def queues(self) -> list[SampleQueue[Samples] | SampleQueue[SensorSamples]]:
        """The queue of the truth, and that of each sensor."""
        return [self.truth, *self.sensors.values()]

    def end_before(self, later: _RunningSegment) -> None:
        """Let a later segment follow. Readings that are left are sent before it, unless it has no such sensor."""
        self.end_ns = min(self.end_ns, later.segment.start_ns - 1)
        self.sensors = {name: queue for name, queue in self.sensors.items() if name in later.sensors}


class Simulation:
    """A simulated body and its sensors: samples in order, on one rising sequence of stamps, across torque-free resets.

    Each sensor has a clock of its own, which shares the epoch. The truth is the same to the bit with sensors and
    without. A reset acts on all from the stamp of the next sample on; the noise begins anew there, so that a segment's
    scenario determines every byte of it.

    Parameters
    ----------
    scenario : Scenario
    epoch_ns : int, optional
        Stamp of sample 0, in place of the scenario's, ns.
    motions : callable, optional
        In place of `motions_of`.
    """

    def __init__(self, scenario: Scenario, epoch_ns: int | None = None, motions: Motions | None = None) -> None:
        self._motions = motions or motions_of
        self._begin_anew(scenario if epoch_ns in (None, scenario.epoch_ns) else scenario.resampled(epoch_ns=epoch_ns))

    def start_at(self, epoch_ns: int) -> None:
        """Begin anew with another stamp of sample 0, ns, before anything was taken.

        Raises
        ------
        ParameterError
            If the clock of a sensor would show then what ROS cannot tell.
        """
        scenario = self.segment.scenario.resampled(epoch_ns=epoch_ns)
        _require_stamps_of_readings(scenario, epoch_ns)
        self._begin_anew(scenario)

    def _begin_anew(self, scenario: Scenario) -> None:
        self._faults = FaultLog()
        self._running: list[_RunningSegment] = []
        self._begin(scenario, 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        start_ns = int(SampleClock(scenario.epoch_ns, scenario.rate).stamps_ns(first, 1)[0])
        if self._running:
            _require_stamps_of_readings(scenario, start_ns)
        new = _RunningSegment(Segment(scenario, first, start_ns), self._motions(scenario))
        # only now: a scenario that is refused changes nothing
        for earlier in self._running:
            earlier.end_before(new)
        self._running.append(new)
        self._faults.follow(new.segment)

    __copy__ = copy.deepcopy  # it goes on by itself

    def __repr__(self) -> str:
        return call_repr(self, {"segment": self.segment, "next_sample": self.next_sample})

    @property
    def segment(self) -> Segment:
        """The present segment."""
        return self._running[-1].segment

    @property
    def next_sample(self) -> int:
        """Number of the sample of the truth that comes next."""
        return self._running[-1].truth.next_sample

    @property
    def clock(self) -> SampleClock:
        """The clock of the truth in the present segment."""
        return self._running[-1].clock

    @property
    def next_stamp_ns(self) -> int:
        """Time at which the next sample is due, ns; a reading, also a lost one, is due when it arrives."""
        return min(queue.stamp_ns(0) for queue in self._oldest().queues)

    def take(self, count: int) -> Samples:
        """The next ``count`` samples of the truth alone."""
        return self._running[-1].truth.take(count)

    def take_until(self, stamp_ns: int, at_most: int) -> SimulationStep:
        """Take what comes next up to a time, from the truth and from every sensor, in one segment.

        Readings left over from before a reset come alone, and first: messages tell the frame and the noise of the
        sensor that made them.

        Parameters
        ----------
        stamp_ns : int
            The last stamp wanted, ns, and the last time at which a reading may arrive.
        at_most : int
            Most samples of the truth, and of each sensor, lost readings included, and about the most faults of a kind.
            All end where one reaches it, also before the next sample.

        Returns
        -------
        SimulationStep

        Raises
        ------
        ParameterError
            If the next ones have no stamp in ROS. Then nothing is taken.
        """
        running = self._oldest()
        fault_end_ns = self._faults.end_ns(at_most)
        stamp_ns = min(stamp_ns, running.end_ns, fault_end_ns, max(self.next_stamp_ns, MAX_EPOCH_NS))
        for queue in running.queues:
            if queue.count_until(stamp_ns) > at_most:
                stamp_ns = queue.stamp_ns(at_most - 1)
        count, *counts = (queue.count_until(stamp_ns) for queue in running.queues)
        for queue, wanted in zip(running.queues, (count, *counts), strict=True):
            queue.prepare(wanted)
        truth = running.truth.take(count)
        taken = {
            name: queue.take(wanted) for (name, queue), wanted in zip(running.sensors.items(), counts, strict=True)
        }
        # those up to the last sample and no further: however a run is cut into batches, each is in the same place
        times = (truth.times_ns, *(rows.times_ns for rows in taken.values()))
        last_ns = max((int(of_one[-1]) for of_one in times if len(of_one)), default=-1)
        if last_ns < 0 and stamp_ns == fault_end_ns:
            last_ns = fault_end_ns
        sensors = {name: rows.received() for name, rows in taken.items()}
        return SimulationStep(truth, sensors, self._faults.take(last_ns), running.segment.scenario)

    def _oldest(self) -> _RunningSegment:
        """The first segment of which something is left."""
        while len(self._running) > 1:
            oldest = self._running[0]
            if any(queue.count_until(oldest.end_ns) for queue in oldest.queues):
                return oldest
            self._running.pop(0)
        return self._running[0]

    def require_stamps(self, last_ns: int) -> None:
        """Refuse a time, ns, up to which the motion does not last, or some stamp would be none that ROS can tell.

        Raises
        ------
        ParameterError
        """
        self.segment.scenario.require_until(last_ns - self.segment.start_ns)
        self.clock.stamps_ns(self.clock.count_until(last_ns) - 1, 1)
        _require_stamps_of_readings(self.segment.scenario, self.segment.start_ns, last_ns)

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample, which carries the initial state of ``scenario``.

        Stamps go on rising: the epoch stays, unless the rate changes; then the next stamp becomes the new epoch.

        Returns
        -------
        Segment
            The new one.
        """
        first = self.next_sample
        epoch_ns = self.segment.scenario.epoch_ns
        if scenario.rate != self.segment.scenario.rate:
            epoch_ns = int(self.clock.stamps_ns(first, 1)[0])
            first = 0
        self._begin(scenario.resampled(epoch_ns=epoch_ns), first)
        return self.segment


def _require_stamps_of_readings(scenario: Scenario, *times_ns: int) -> None:
    """Refuse times, ns, at which the clock of a sensor shows what ROS cannot tell."""
    for model in scenario.sensors.on.values():
        if model.delivery is not None:
            model.delivery.stamps_ns(np.array(times_ns), scenario.epoch_ns)


@dataclass
class LastCall:
    """Last call of the users in step: its number from 1 on, its times and states, and the motion after it."""

    number: int = 0
    t_ns: Any = None
    states: Any = None
    motion: Any = None


class MemoizedMotion:
    """A motion for one of several users, each of whom gets the bits of a motion of their own.

    As long as they ask for the same times in the same order, each answer is computed for the first of them. It is kept
    for the others until the next one. A user who asks for other times goes on alone.

    Parameters
    ----------
    motion : Motion
        The motion at the start, which is copied.
    latest : LastCall
        What all users share.
    """

    def __init__(self, motion: Motion, latest: LastCall) -> None:
        self._motion = copy.copy(motion)
        self._latest = latest
        self._calls = 0
        self._in_step = True

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times, ns."""
        latest = self._latest
        self._calls += 1
        is_known = self._calls == latest.number and np.array_equal(latest.t_ns, t_ns)
        self._in_step &= is_known or self._calls == latest.number + 1
        if is_known and self._in_step:
            self._motion = copy.copy(latest.motion)
            return cast(State, latest.states)
        states = self._motion.at(t_ns)
        if self._in_step:
            latest.number = self._calls
            latest.t_ns = np.array(t_ns)
            latest.states = states
            latest.motion = copy.copy(self._motion)
        return states


def motions_of(scenario: Scenario, clocks: Mapping[float, LastCall] | None = None) -> Callable[[], Motion]:
    """Motions from the start of a scenario: each call gives one, first that of the truth, then that of each sensor.

    A moving chart takes steps from one sample to the next, so samples of another clock in between would change its
    bits. Each clock has a motion of its own, and sensors of one rate share it.

    Parameters
    ----------
    scenario : Scenario
    clocks : mapping of float to LastCall, optional
        By their rates, those that several simulations of one motion share. All are made before anything is taken.
    """
    rates = scenario.rates
    shared = {rate: LastCall() for rate in rates} if clocks is None else clocks
    start = scenario.make_motion()
    turns = iter(rates)
    return lambda: MemoizedMotion(start, shared[next(turns)])


# A function of a module, no closure: a simulation is copied, and sent to other processes, with its queues.


def _samples(motion: Motion, centre: Translation | None, start_ns: int, stamps: Integers) -> Samples:
    times = stamps - start_ns
    return Samples(stamps, motion.at(times), None if centre is None else centre.at(times))
