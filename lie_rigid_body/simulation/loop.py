"""The loop from a scenario to samples: the truth and the sensors, across torque-free resets."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, TypeAlias, TypeVar

from lie_rigid_body.arrays import Integers
from lie_rigid_body.motion import ClosedForm, Motion
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Imu, ImuModel, Magnetometer, MagnetometerModel
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.sample_queue import Rows, SampleQueue, SensorQueue
from lie_rigid_body.simulation.samples import ImuSamples, MagnetometerSamples, Samples
from lie_rigid_body.simulation.segment import Segment
from lie_rigid_body.wording import call_repr, short_repr

R = TypeVar("R", bound=Rows)
Motions: TypeAlias = Callable[[Scenario], Callable[[], Motion]]
"""Makes the motions of a start; see `motions_of`."""

LOOK_AHEAD: Final = 64
"""Samples computed at once when fewer are wanted: the closed form takes almost as long for one as for all of them."""
STEPS_AHEAD: Final = 64
"""Largest number of integrator steps spent on looking ahead, about 1 ms."""


@dataclass(frozen=True)
class Taken:
    """Samples of the truth and readings of the sensors that were taken from a simulation at once.

    Parameters
    ----------
    samples : Samples
        The truth.
    imu : ImuSamples or None
    magnetometer : MagnetometerSamples or None
        None: there is no such sensor.
    """

    samples: Samples
    imu: ImuSamples | None
    magnetometer: MagnetometerSamples | None

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
        self._imu: SensorQueue[ImuSamples] | None = None
        self._magnetometer: SensorQueue[MagnetometerSamples] | None = None
        epoch = scenario.epoch_ns if epoch_ns is None else epoch_ns
        self._begin(replace(scenario, epoch_ns=epoch), 0)

    def start_at(self, epoch_ns: int) -> None:
        """Begin anew with another stamp of sample 0, ns, before anything was taken."""
        self._imu = self._magnetometer = None
        self._begin(replace(self._segment.scenario, epoch_ns=epoch_ns), 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        clock = SampleClock(scenario.epoch_ns, scenario.rate)
        segment = Segment(scenario, first, int(clock.stamps_ns(first, 1)[0]))
        motion = self._motions(scenario)
        truth = _truth(segment, clock, motion())
        imu, magnetometer = scenario.sensors.imu, scenario.sensors.magnetometer
        new_imu = None if imu is None else _imu(segment, imu, motion())
        new_magnetometer = None if magnetometer is None else _magnetometer(segment, magnetometer, motion())
        # only now: a scenario that is refused changes nothing
        self._imu = _followed(self._imu, new_imu, segment.start_ns)
        self._magnetometer = _followed(self._magnetometer, new_magnetometer, segment.start_ns)
        self._clock, self._segment, self._truth = clock, segment, truth

    def __copy__(self) -> Simulation:
        """A simulation that goes on by itself from here."""
        return copy.deepcopy(self)

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
        """Stamp of what comes next, the truth or a sensor, ns."""
        return min(queue.stamp_ns(0) for queue in self._queues)

    @property
    def _queues(self) -> list[SampleQueue[Samples] | SensorQueue[ImuSamples] | SensorQueue[MagnetometerSamples]]:
        return [queue for queue in (self._truth, self._imu, self._magnetometer) if queue is not None]

    def take(self, count: int) -> Samples:
        """The next ``count`` samples of the truth alone."""
        return self._truth.take(count)

    def take_until(self, stamp_ns: int, at_most: int) -> Taken:
        """What comes next up to a stamp, of the truth and of every sensor.

        Parameters
        ----------
        stamp_ns : int
            The last stamp wanted, ns.
        at_most : int
            The most samples wanted of each: all end with the one that reaches it first.

        Returns
        -------
        Taken
        """
        for queue in self._queues:
            if queue.count_until(stamp_ns) > at_most:
                stamp_ns = queue.stamp_ns(at_most - 1)
        return Taken(
            self._truth.take(self._truth.count_until(stamp_ns)),
            _taken(self._imu, stamp_ns),
            _taken(self._magnetometer, stamp_ns),
        )

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
        return self._segment


def _taken(sensor: SensorQueue[R] | None, stamp_ns: int) -> R | None:
    """The readings of a sensor up to a stamp, ns."""
    return None if sensor is None else sensor.take(sensor.count_until(stamp_ns))


def _followed(sensor: SensorQueue[R] | None, queue: SampleQueue[R] | None, start_ns: int) -> SensorQueue[R] | None:
    """Queue of a sensor that continues with the new segment at ``start_ns``; None if that segment lacks the sensor."""
    if sensor is None or queue is None:
        return None if queue is None else SensorQueue(queue)
    sensor.follow(queue, start_ns)
    return sensor


def motions_of(scenario: Scenario) -> Callable[[], Motion]:
    """The motions of one start: first of the truth, then, where they are, of the IMU and of the magnetometer.

    A closed form serves them all. A moving chart divides the time between the samples asked of it into steps, so that
    those of another clock in between would change its bits: the truth and each sensor have one of their own.
    """
    if scenario.motion == "closed_form":
        motion = scenario.make_motion()
        return lambda: motion
    return scenario.make_motion


def _truth(segment: Segment, clock: SampleClock, motion: Motion) -> SampleQueue[Samples]:
    return SampleQueue(
        clock,
        segment.first_sample,
        partial(_states, motion, segment.start_ns),
        segment.scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, clock.rate),
    )


def _imu(segment: Segment, model: ImuModel, motion: Motion) -> SampleQueue[ImuSamples]:
    scenario, start_ns = segment.scenario, segment.start_ns
    clock = SampleClock(scenario.epoch_ns, model.rate)
    first = clock.count_until(start_ns - 1)
    before_ns = clock.stamp_ns(first - 1) - start_ns
    # an instantaneous rate does not look at the state before
    before = _extended(scenario, motion).at(before_ns) if model.gyro_rate == "integrated" else scenario.start()
    compute = partial(_inertial_readings, Imu(model, scenario.body(), before_ns, before), motion, start_ns)
    return SampleQueue(clock, first, compute, scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, model.rate))


# Functions of a module, not closures: a simulation is copied, and sent to other processes, with its queues.


def _states(motion: Motion, start_ns: int, stamps: Integers) -> Samples:
    return Samples(stamps, motion.at(stamps - start_ns))


def _inertial_readings(imu: Imu, motion: Motion, start_ns: int, stamps: Integers) -> ImuSamples:
    times = stamps - start_ns
    return ImuSamples(stamps, imu.measure(times, motion.at(times)))


def _magnetic_readings(
    magnetometer: Magnetometer, motion: Motion, start_ns: int, stamps: Integers
) -> MagnetometerSamples:
    return MagnetometerSamples(stamps, magnetometer.measure(motion.at(stamps - start_ns)))


def _extended(scenario: Scenario, motion: Motion) -> ClosedForm:
    """Exact motion extended to times before the start; the integrator only goes forward."""
    return motion if isinstance(motion, ClosedForm) else ClosedForm(scenario.body(), scenario.start())


def _magnetometer(segment: Segment, model: MagnetometerModel, motion: Motion) -> SampleQueue[MagnetometerSamples]:
    scenario, start_ns = segment.scenario, segment.start_ns
    clock = SampleClock(scenario.epoch_ns, model.rate)
    return SampleQueue(
        clock,
        clock.count_until(start_ns - 1),
        partial(_magnetic_readings, Magnetometer(model), motion, start_ns),
        scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, model.rate),
    )
