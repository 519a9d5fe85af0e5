"""The words of notes: what the reader of a score is told of estimates that were left out, or that may be of another.

All other tests of this folder assert on numbers, names and kinds.
"""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import Scenario
from lie_rigid_body.estimates.kept import DISORDERED, OF_OTHERS, STRAY, UNUSABLE_ATTITUDES, KeptAttitudes
from lie_rigid_body.messages.definitions import ODOMETRY, POSE_STAMPED
from lie_rigid_body.recording.topic_messages import AttitudeTrack
from lie_rigid_body.runs.truth import TrueMotion
from lie_rigid_body.simulation import Segment

NS = 10**9
STAMPS = np.array([2 * NS, 3 * NS])
LEFT_OUT = {
    STRAY: "are left out, whose stamps leap from those beside them, the first to 2 s: find out what stamped them",
    DISORDERED: "were stamped before one that had come, the first 2 s, and are left out: let one node publish them, "
    "whose time never jumps back",
    UNUSABLE_ATTITUDES: "are not finite, or zero, the first stamped 2 s: they are left out; find out why they "
    "were given",
    OF_OTHERS: "are of other frames, the first stamped 2 s, and are left out: let one node publish one body",
}
"""Kinds of estimates that are left out, and what is said of them."""


@pytest.mark.parametrize("kind", LEFT_OUT)
def test_what_is_left_out_is_counted_with_the_reason(kind: str) -> None:
    kept = KeptAttitudes()
    kept.leave_out(kind, STAMPS)
    assert kept.notes("estimates") == {kind: f"2 of 2 estimates {LEFT_OUT[kind]}"}


def track(kind: str, frame: str = "world", child: str = "", covariance: np.ndarray | None = None) -> AttitudeTrack:
    return AttitudeTrack("/x", kind, STAMPS, np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)), covariance, frame, child)


POSES = track(POSE_STAMPED)
TAKEN = "they are taken for the same. Is it the right "
NOTES: dict[str, tuple[AttitudeTrack | None, AttitudeTrack]] = {
    "The truth is that of the scenario alone, from 1 s on; the estimate begins 1 s after that.": (None, POSES),
    f"The frame of the estimate is 'odom', that of the truth 'world': {TAKEN}topic?": (
        POSES,
        track(POSE_STAMPED, "odom"),
    ),
    f"The body of the estimate is 'lidar', that of the truth 'base_link': {TAKEN}body?": (
        POSES,
        track(ODOMETRY, child="lidar"),
    ),
    "There is no NEES: covariance: 0 on its diagonal: give positive variances, 1e-200 at least.": (
        POSES,
        track(ODOMETRY, child="base_link", covariance=np.tile(np.diag([0.0, 0.0, 1e-4]), (2, 1, 1))),
    ),
    "There is no NEES: 1 of 2 covariances are unknown: give all or none.": (
        POSES,
        track(ODOMETRY, child="base_link", covariance=np.stack([np.zeros((3, 3)), np.eye(3)])),
    ),
}
"""Notes, each with the poses of the truth and the estimate."""


@pytest.mark.parametrize("note", NOTES)
def test_what_may_be_of_another_is_said(note: str) -> None:
    poses, estimate = NOTES[note]
    motion = TrueMotion((Segment(Scenario.from_parameters({}), 0, NS),), poses)
    assert [*motion.notes_on(estimate)] == [note]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "The motion began anew at 2.5 s, 1 reset in all."),
        (
            {"imu_dropout_probability": 0.1},
            "The scenario declares that readings of the IMU are lost: gaps of the estimate may be theirs.",
        ),
        (
            {"imu_clock_offset": 0.1},
            "The scenario declares that the clock of the IMU errs: so do stamps that a filter takes from it.",
        ),
    ],
)
def test_what_the_scenarios_declare_and_no_filter_can_help_is_said(given: dict[str, object], said: str) -> None:
    declared = Segment(Scenario(**given, imu_rate=10.0), 0, NS)
    segments = (declared,) if given else (declared, Segment(Scenario(), 0, 5 * NS // 2))
    assert [*TrueMotion(segments, POSES).notes_on(POSES)] == [said]
