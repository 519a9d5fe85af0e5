"""The truth and the sensors side by side, across torque-free resets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Imu, ImuModel, Magnetometer, MagnetometerModel
from lie_rigid_body.simulation.relay import Relay
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import ImuSamples, MagnetometerSamples, Samples
from lie_rigid_body.simulation.segment import Segment
from lie_rigid_body.simulation.track import SlicedRows, Track

R = TypeVar("R", bound=SlicedRows)
Integers = NDArray[np.int64]

LOOK_AHEAD: Final = 64
"""Samples computed at once when fewer are wanted: of the closed form one costs almost as much as all of them."""
STEPS_AHEAD: Final = 64
"""The most steps of the moving chart taken for that, about a millisecond of work."""


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
        self._imu: Relay[ImuSamples] | None = None
        self._magnetometer: Relay[MagnetometerSamples] | None = None
        epoch = scenario.epoch_ns if epoch_ns is None else epoch_ns
        self._begin(replace(scenario, epoch_ns=epoch), 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        clock = SampleClock(scenario.epoch_ns, scenario.rate)
        segment = Segment(scenario, first, int(clock.stamps_ns(first, 1)[0]))
        truth = _truth(segment, clock)
        imu, magnetometer = scenario.sensors.imu, scenario.sensors.magnetometer
        # only now: a scenario that is refused changes nothing
        new_imu = None if imu is None else _imu(segment, imu)
        new_magnetometer = None if magnetometer is None else _magnetometer(segment, magnetometer)
        self._imu = _followed(self._imu, new_imu, segment.start_ns)
        self._magnetometer = _followed(self._magnetometer, new_magnetometer, segment.start_ns)
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
    def _tracks(self) -> list[Track[Samples] | Relay[ImuSamples] | Relay[MagnetometerSamples]]:
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


def _taken(relay: Relay[R] | None, stamp_ns: int) -> R | None:
    """What a sensor has up to a stamp."""
    return None if relay is None else relay.take(relay.count_until(stamp_ns))


def _followed(relay: Relay[R] | None, track: Track[R] | None, start_ns: int) -> Relay[R] | None:
    """A sensor's readings, which a new track carries on from a stamp; None if there are no more."""
    if relay is None or track is None:
        return None if track is None else Relay(track)
    relay.hand_over(track, start_ns)
    return relay


def _truth(segment: Segment, clock: SampleClock) -> Track[Samples]:
    motion = segment.scenario.make_motion()
    return Track(
        clock,
        segment.first_sample,
        lambda stamps: Samples(stamps, motion.at(stamps - segment.start_ns)),
        segment.scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD),
    )


def _imu(segment: Segment, model: ImuModel) -> Track[ImuSamples]:
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

    return Track(clock, first, compute, scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, model.rate))


def _magnetometer(segment: Segment, model: MagnetometerModel) -> Track[MagnetometerSamples]:
    scenario, start_ns = segment.scenario, segment.start_ns
    clock = SampleClock(scenario.epoch_ns, model.rate)
    motion, magnetometer = scenario.make_motion(), Magnetometer(model)
    return Track(
        clock,
        clock.count_until(start_ns - 1),
        lambda stamps: MagnetometerSamples(stamps, magnetometer.measure(motion.at(stamps - start_ns))),
        scenario.batch_size(LOOK_AHEAD, STEPS_AHEAD, model.rate),
    )
