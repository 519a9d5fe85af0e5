"""The true motion as a bag or the topics of a running node give it: scenarios, poses, or both."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.evaluation import SampledTruth, Truth
from lie_rigid_body.evaluation.consistency import covariance_fault, unknown_covariances
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, shown
from lie_rigid_body.messages.definitions import IMU
from lie_rigid_body.recording.topic_messages import AttitudeTrack
from lie_rigid_body.runs.truth import ScenarioTruth
from lie_rigid_body.simulation import Segment

YEAR_NS: Final = 366 * 86_400 * 10**9
"""Longest time after the start of a scenario at which an estimate may begin, ns."""


@short_dataclass
class TrueMotion:
    """True motion as it is told: by scenarios, poses, or both.

    Parameters
    ----------
    segments : tuple of Segment
        In the order of their starts; empty if no scenario is known.
    poses : AttitudeTrack or None
    """

    segments: tuple[Segment, ...]
    poses: AttitudeTrack | None

    @property
    def frames(self) -> tuple[str, str] | None:
        """Names of the world's and the body's frame, if a scenario tells them."""
        scenarios = (segment.scenario for segment in self.segments)
        return next(((each.world_frame, each.body_frame) for each in scenarios), None)

    @property
    def source(self) -> str:
        """Names of the sources: poses, scenario, or both."""
        return " and ".join([*(["poses"] if self.poses is not None else []), *(["scenario"] if self.segments else [])])

    def until(self, last_ns: int) -> Truth:
        """The truth as a function of time; without poses it is asked until the given stamp at most."""
        if self.poses is None:
            start = self.segments[0].start_ns
            return ScenarioTruth(self.segments, start, max(last_ns, start))
        stamps, first = np.unique(self.poses.stamps_ns, return_index=True)
        attitude = self.poses.attitude_xyzw[first]
        if not self.segments:
            return SampledTruth(stamps, attitude)
        return ScenarioTruth.of_samples(self.segments, stamps, attitude)

    def require_same_clock(self, first_ns: int, last_ns: int | None = None) -> None:
        """Refuse estimates that begin where no run can be: a scenario alone determines the truth at any time.

        They are of another clock if they begin after all that the body's node published, or a year after its start.

        Parameters
        ----------
        first_ns : int
            The first stamp of the estimates, ns.
        last_ns : int, optional
            The last stamp of the node's messages, ns.
        """
        start_ns = self.segments[-1].start_ns
        if first_ns > (start_ns + YEAR_NS if last_ns is None else last_ns):
            raise InputError(
                f"estimate: it begins {(first_ns - start_ns) / 1e9:.9g} s after the scenario, which alone tells the "
                "truth: it is of another clock: set use_sim_time of the filter, or record the poses"
            )

    def notes_on(self, track: AttitudeTrack) -> Iterator[str]:
        """Notes for a reader of the score of some attitudes, one sentence each."""
        if self.poses is None:
            start = self.segments[0].start_ns
            first = int(track.stamps_ns[0])
            yield (
                f"The truth is that of the scenario alone, from {start / 1e9:.13g} s on; the estimate begins "
                f"{(first - start) / 1e9:.9g} s after that."
            )
        yield from self._events_of(track)
        # an Imu is stamped with the frame of the sensor (REP-145)
        own = self.poses if self.poses is not None and self.poses.message_type != IMU else None
        world = self.frames[0] if self.frames else own.frame if own is not None else track.frame
        ours = {world}
        if track.message_type == IMU and self.segments:
            parameters = self.segments[0].scenario.parameters()
            ours |= {self.segments[0].scenario.body_frame, str(parameters.get("imu_frame", "imu_link"))}
        if track.frame not in ours and not (track.message_type == IMU and not self.segments):
            yield (
                f"The frame of the estimate is {shown(track.frame)}, that of the truth {shown(world)}: they are taken "
                "for the same. Is it the right topic?"
            )
        if self.frames and track.child_frame and track.child_frame != self.frames[1]:
            yield (
                f"The body of the estimate is {shown(track.child_frame)}, that of the truth {shown(self.frames[1])}: "
                "they are taken for the same. Is it the right body?"
            )
        if track.covariance is not None:
            unknown = unknown_covariances(track.covariance)
            if fault := covariance_fault(track.covariance):
                yield f"There is no NEES: {fault}."
            elif unknown.any() and not unknown.all():
                yield f"There is no NEES: {unknown.sum()} of {len(unknown)} covariances are unknown: give all or none."

    def _events_of(self, track: AttitudeTrack) -> Iterator[str]:
        """Sentences about what scenarios declare, and no filter can help: resets, lost readings, an erring clock."""
        begin, end = track.stamps_ns[[0, -1]].tolist()
        resets = [segment.start_ns for segment in self.segments[1:] if begin < segment.start_ns <= end]
        if resets:
            yield f"The motion began anew at {resets[0] / 1e9:.13g} s, {counted(len(resets), 'reset')} in all."
        of_imu = [imu.delivery for segment in self.segments if (imu := segment.scenario.sensors.imu) and imu.delivery]
        if any(delivery.dropout_probability or delivery.outage for delivery in of_imu):
            yield "The scenario declares that readings of the IMU are lost: gaps of the estimate may be theirs."
        if any(delivery.has_clock_error for delivery in of_imu):
            yield "The scenario declares that the clock of the IMU errs: so do stamps that a filter takes from it."
