"""The loop from a scenario to samples: the truth and the sensors, across torque-free resets."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.motion import Motion
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation.fault_log import FaultLog
from lie_rigid_body.simulation.measurement import Measurement
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.sample_queue import SampleQueue, SensorQueue
from lie_rigid_body.simulation.samples import Samples, SensorSamples
from lie_rigid_body.simulation.segment import Segment
from lie_rigid_body.simulation.shared_motion import Latest, SharedMotion
from lie_rigid_body.wording import call_repr, short_repr

Motions: TypeAlias = Callable[[Scenario], Callable[[], Motion]]
"""A function that makes the motions of a scenario; see `motions_of`."""

LOOK_AHEAD: Final = 64
"""Samples computed at once when fewer are wanted: the closed form takes as long for one as for all of them."""
STEPS_AHEAD: Final = 64
"""Largest number of integrator steps for samples that are not wanted yet, about 1 ms."""


@dataclass(frozen=True)
class Taken:
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

    __repr__ = short_repr


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
        self._sensors: dict[str, SensorQueue[SensorSamples]] = {}
        self._faults: FaultLog | None = None
        self._ended: list[tuple[Scenario, int]] = []
        self._begin(scenario if epoch_ns in (None, scenario.epoch_ns) else replace(scenario, epoch_ns=epoch_ns), 0)

    def start_at(self, epoch_ns: int) -> None:
        """Begin anew with another stamp of sample 0, ns, before anything was taken."""
        self._sensors, self._faults = {}, None
        self._begin(replace(self._segment.scenario, epoch_ns=epoch_ns), 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        clock = SampleClock(scenario.epoch_ns, scenario.rate)
        segment = Segment(scenario, first, int(clock.stamps_ns(first, 1)[0]))
        motion = self._motions(scenario)
        truth = _truth(segment, clock, motion())
        queues = {name: _sensor(segment, name, motion()) for name in scenario.sensors.on}
        # only now: a scenario that is refused changes nothing
        self._sensors = {name: _followed(self._sensors.get(name), queue, segment) for name, queue in queues.items()}
        if self._faults is None:
            self._faults = FaultLog(segment)
        else:
            self._faults.follow(segment)
        self._clock, self._segment, self._truth = clock, segment, truth

    __copy__ = copy.deepcopy  # it goes on by itself

    def __repr__(self) -> str:
        return call_repr(self, {"segment": self.segment, "next_sample": self.next_sample})

    @property
    def segment(self) -> Segment:
        """The present segment."""
        return self._segment

    @property
    def next_sample(self) -> int:
        """Number of the sample of the truth that comes next."""
        return self._truth.next_sample

    @property
    def clock(self) -> SampleClock:
        """The clock of the truth in the present segment."""
        return self._clock

    @property
    def next_stamp_ns(self) -> int:
        """Time at which the next sample is due, ns; a reading, also a lost one, is due when it arrives."""
        return min(queue.stamp_ns(0) for queue in self._queues)

    @property
    def _queues(self) -> list[SampleQueue[Samples] | SensorQueue[SensorSamples]]:
        return [self._truth, *self._sensors.values()]

    def take(self, count: int) -> Samples:
        """The next ``count`` samples of the truth alone."""
        return self._truth.take(count)

    def take_until(self, stamp_ns: int, at_most: int) -> Taken:
        """Take what comes next up to a time, from the truth and from every sensor, in one segment.

        Readings left over from before a reset come alone, and first: messages tell the frame and the noise of the
        sensor that made them.

        Parameters
        ----------
        stamp_ns : int
            The last stamp wanted, ns, and the last time at which a reading may arrive.
        at_most : int
            Most samples of the truth, and of each sensor, lost readings included. All end where one reaches it.

        Returns
        -------
        Taken
        """
        scenario, stamp_ns = self._oldest(stamp_ns)
        for queue in self._queues:
            if queue.count_until(stamp_ns) > at_most:
                stamp_ns = queue.stamp_ns(at_most - 1)
        truth = self._truth.take(self._truth.count_until(stamp_ns))
        taken = {name: queue.take(queue.count_until(stamp_ns)) for name, queue in self._sensors.items()}
        times = [rows.times_ns for rows in taken.values()]
        # those up to the last sample and no further: however a run is cut into batches, each is in the same place
        last_ns = max((int(of_one[-1]) for of_one in (truth.times_ns, *times) if len(of_one)), default=-1)
        assert self._faults is not None
        received = {name: rows.received() for name, rows in taken.items()}
        return Taken(truth, received, self._faults.take(last_ns), scenario)

    def _oldest(self, until_ns: int) -> tuple[Scenario, int]:
        """The scenario of the next samples, and the last time up to ``until_ns`` at which it is in force, ns."""
        while self._ended:
            scenario, end_ns = self._ended[0]
            if any(queue.count_until(end_ns) for queue in self._sensors.values()):
                return scenario, min(until_ns, end_ns)
            self._ended.pop(0)
        return self._segment.scenario, until_ns

    def require_stamps(self, last_ns: int) -> None:
        """Refuse a time, ns, up to which some sample or reading would have a stamp that ROS cannot tell.

        Raises
        ------
        ParameterError
        """
        scenario, start_ns = self._segment.scenario, self._segment.start_ns
        self._clock.stamps_ns(self._clock.count_until(last_ns) - 1, 1)
        for model in scenario.sensors.on.values():
            if model.delivery is not None:
                model.delivery.stamps_ns(np.array([start_ns, last_ns]), scenario.epoch_ns)

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample, which carries the initial state of ``scenario``.

        Stamps go on rising: the epoch stays, unless the rate changes; then the next stamp becomes the new epoch.

        Returns
        -------
        Segment
            The new one.
        """
        present = self._segment.scenario
        if scenario.rate == present.rate:
            self._begin(replace(scenario, epoch_ns=present.epoch_ns), self.next_sample)
        else:
            epoch = int(self._clock.stamps_ns(self.next_sample, 1)[0])
            self._begin(replace(scenario, epoch_ns=epoch), 0)
        self._ended.append((present, self._segment.start_ns - 1))
        return self._segment


def _followed(
    sensor: SensorQueue[SensorSamples] | None, queue: SampleQueue[SensorSamples], segment: Segment
) -> SensorQueue[SensorSamples]:
    """Continue the queue of a sensor with a new segment, or begin it where there was none."""
    if sensor is None:
        return SensorQueue(queue)
    sensor.follow(queue, segment.start_ns)
    return sensor


def motions_of(scenario: Scenario) -> Callable[[], Motion]:
    """Motions from the start of a scenario: each call gives one, first that of the truth, then that of each sensor.

    A moving chart takes steps from one sample to the next, so samples of another clock in between would change its
    bits. Each clock has a motion of its own, and sensors of one rate share it.
    """
    rates = [scenario.rate, *(model.rate for model in scenario.sensors.on.values())]
    clocks, start, turns = {rate: Latest() for rate in rates}, scenario.make_motion(), iter(rates)
    return lambda: SharedMotion(start, clocks[next(turns)])


def _truth(segment: Segment, clock: SampleClock, motion: Motion) -> SampleQueue[Samples]:
    return SampleQueue(
        clock,
        segment.first_sample,
        partial(_states, motion, segment.start_ns),
        segment.scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, clock.rate),
    )


def _sensor(segment: Segment, name: str, motion: Motion) -> SampleQueue[SensorSamples]:
    measurement = Measurement(segment, name, motion)
    ahead = segment.scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, measurement.model.rate)
    return SampleQueue(measurement.clock, measurement.first, measurement.samples, ahead, measurement.arrivals)


# A function of a module, no closure: a simulation is copied, and sent to other processes, with its queues.


def _states(motion: Motion, start_ns: int, stamps: Integers) -> Samples:
    return Samples(stamps, motion.at(stamps - start_ns))
