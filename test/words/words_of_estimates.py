"""What the notes of a score say of estimates that were left out, or that may be of another body."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np

from lie_rigid_body import Scenario
from lie_rigid_body.estimates.buffers import DISORDERED, OF_OTHERS, UNUSABLE, notes_on_left_out
from lie_rigid_body.messages.definitions import ODOMETRY, POSE_STAMPED
from lie_rigid_body.recording.topic_messages import AttitudeTrack
from lie_rigid_body.runs.true_motion import TrueMotion
from lie_rigid_body.simulation import Segment

NS = 10**9
STAMPS = np.array([2 * NS, 3 * NS])


def left_out(kind):
    return notes_on_left_out({kind: STAMPS}, 5, "estimates")[0]


def track(kind=POSE_STAMPED, frame="world", child="", variances=None):
    covariance = None if variances is None else np.array([np.diag(row) for row in variances])
    return AttitudeTrack("/x", kind, STAMPS, STAMPS, np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)), covariance, frame, child)


def odometry(child="base_link", variances=None):
    return track(ODOMETRY, child=child, variances=variances)


PLAIN = Segment(Scenario.from_parameters({}), 0, NS)
POSES = track()


def notes(estimate, poses=POSES, segments=(PLAIN,)):
    return "\n".join(TrueMotion(tuple(segments), poses).notes_on(estimate))


def notes_of(**scenario):
    return notes(track(), segments=[Segment(Scenario(**scenario, imu_rate=10.0), 0, NS)])


SAID = [
    *(lambda kind=kind: left_out(kind) for kind in (UNUSABLE, DISORDERED, OF_OTHERS)),
    lambda: notes(track(), poses=None),
    lambda: notes(track(frame="odom")),
    lambda: notes(odometry(child="lidar")),
    lambda: notes(odometry(variances=[[0.0, 0.0, 1e-4]] * 2)),
    lambda: notes(odometry(variances=[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])),
    lambda: notes(track(), segments=[Segment(Scenario(imu_rate=10.0), 0, NS), Segment(Scenario(), 0, 5 * NS // 2)]),
    lambda: notes_of(imu_dropout_probability=0.1),
    lambda: notes_of(imu_clock_offset=0.1),
]
