"""The truth and the sensors side by side, across torque-free resets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Imu, ImuModel, Magnetometer, MagnetometerModel
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import ImuSamples, MagnetometerSamples, Samples
from lie_rigid_body.simulation.segment import Segment
from lie_rigid_body.simulation.track import SlicedRows, Track

R = TypeVar("R", bound=SlicedRows)
Integers = NDArray[np.int64]

LOOK_AHEAD: Final = 64
"""Samples of the closed form computed at once when fewer are wanted: one costs almost as much as all of them."""


@dataclass(frozen=True)
class Taken:
    """What was taken at once from a simulation.

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


class Simulation:
    """Samples one after the other, across torque-free resets, on one rising sequence of stamps.

    Each sensor has a clock of its own, which shares the epoch, and a motion of its own: the truth is the same to the
    bit with sensors and without. A reset is felt by all from the stamp of the next sample on; the noise begins anew
    there, so that a segment's scenario determines every byte of it.

    Parameters
    ----------
    scenario : Scenario
    epoch_ns : int, optional
        Stamp of sample 0, in place of the scenario's, ns.
    """

    def __init__(self, scenario: Scenario, epoch_ns: int | None = None) -> None:
        self._imu: Track[ImuSamples] | None = None
        self._magnetometer: Track[MagnetometerSamples] | None = None
        epoch = scenario.epoch_ns if epoch_ns is None else epoch_ns
        self._begin(replace(scenario, epoch_ns=epoch), 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        clock = SampleClock(scenario.epoch_ns, scenario.rate)
        segment = Segment(scenario, first, int(clock.stamps_ns(first, 1)[0]))
        truth = _truth(segment, clock)
        imu, magnetometer = scenario.sensors.imu, scenario.sensors.magnetometer
        # only now: a scenario that is refused changes nothing
        rest, more = _taken(self._imu, segment.start_ns - 1), _taken(self._magnetometer, segment.start_ns - 1)
        self._imu = None if imu is None else _imu(segment, imu, rest)
        self._magnetometer = None if magnetometer is None else _magnetometer(segment, magnetometer, more)
        self._clock, self._segment, self._truth = clock, segment, truth

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
        return min(track.stamp_ns(0) for track in self._tracks)

    @property
    def _tracks(self) -> list[Track[Samples] | Track[ImuSamples] | Track[MagnetometerSamples]]:
        return [track for track in (self._truth, self._imu, self._magnetometer) if track is not None]

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
        for track in self._tracks:
            if track.count_until(stamp_ns) > at_most:
                stamp_ns = track.stamp_ns(at_most - 1)
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


def _taken(track: Track[R] | None, stamp_ns: int) -> R | None:
    """What a track has up to a stamp."""
    return None if track is None else track.take(track.count_until(stamp_ns))


def _look_ahead(scenario: Scenario) -> int:
    return LOOK_AHEAD if scenario.motion == "closed_form" else 0


def _truth(segment: Segment, clock: SampleClock) -> Track[Samples]:
    motion = segment.scenario.make_motion()
    return Track(
        clock,
        segment.first_sample,
        lambda stamps: Samples(stamps, motion.at(stamps - segment.start_ns)),
        _look_ahead(segment.scenario),
    )


def _imu(segment: Segment, model: ImuModel, rest: ImuSamples | None) -> Track[ImuSamples]:
    scenario, start_ns = segment.scenario, segment.start_ns
    clock = SampleClock(scenario.epoch_ns, model.rate)
    first = clock.count_until(start_ns - 1)
    motion, body = scenario.make_motion(), scenario.body()
    # the motion as it would have been before its start
    before_ns = clock.stamp_ns(first - 1) - start_ns
    imu = Imu(model, body, before_ns, ClosedForm(body, scenario.start()).at(before_ns))

    def compute(stamps: Integers) -> ImuSamples:
        times = stamps - start_ns
        return ImuSamples(stamps, imu.measure(times, motion.at(times)))

    return Track(clock, first, compute, _look_ahead(scenario), rest)


def _magnetometer(
    segment: Segment, model: MagnetometerModel, rest: MagnetometerSamples | None
) -> Track[MagnetometerSamples]:
    scenario, start_ns = segment.scenario, segment.start_ns
    clock = SampleClock(scenario.epoch_ns, model.rate)
    motion, magnetometer = scenario.make_motion(), Magnetometer(model)
    return Track(
        clock,
        clock.count_until(start_ns - 1),
        lambda stamps: MagnetometerSamples(stamps, magnetometer.measure(motion.at(stamps - start_ns))),
        _look_ahead(scenario),
        rest,
    )
