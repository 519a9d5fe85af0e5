"""What certificates say: one sentence for each thing that may be wrong with a bag, or that is not certified of it.

What other tests of this folder ask for is in `phrases`.
"""

from __future__ import annotations

import numpy as np
import pytest
from phrases import PHRASES
from sensor_bags import AT, BIAS, IMU, MAG, certificate, recorded
from tampering import Change, at, declared, flipped, on, with_numbers
from test_certified_clocks import moved

from foreign_bags import Message
from lie_rigid_body.foundation.errors import BagError


def scaled(message: Message) -> Message:
    return with_numbers(message, 24, lambda x: np.append(1.5 * x[:3], x[3:]))


SAID: dict[str, tuple[Change, str]] = {
    "value": (
        on(IMU, at(AT, scaled)),
        "/imu/data_raw: gyro is 0.353 rad/s off what the scenario determines (limit 1.6e-12) at reading 37, "
        "0.111011101 s after the start",
    ),
    "log times": (
        on("/pose", lambda ms: [m._replace(log_time=m.log_time + 1000) for m in ms]),
        "60 messages are not logged, or not published, at their stamps",
    ),
    "sign": (
        on("/pose", at(AT, flipped)),
        "the quaternion has not the sign with which it goes on, at sample 37 (1 of 60)",
    ),
    "declaration": (
        declared(inertia=[1.0, 2.0, 30.0]),
        "the bag declares an impossible scenario: inertia: principal moments 1.0, 2.0, 30.0 break the triangle",
    ),
    "first sample": (declared(first_sample=5), "with sample 5, which its epoch_ns and rate stamp "),
    "stamp": (moved(1), "/imu/mag: 1 stamps off the grid, reading 37 stamped "),
    "late recorder": (recorded(0.1), "the recording begins at sample 6, 0.1001 s after the segment's start"),
    "lost messages": (
        lambda ms: recorded(0.1)(on("/pose", lambda own: [*own[:30], *own[35:]])(ms)),
        "messages missing: 5 (samples on one topic only: 5)",
    ),
    "frame": (
        on(MAG, at(AT, lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lunk")))),
        "/imu/mag: frame or covariances are not as declared, at reading 37, 0.528571429 s after the start",
    ),
    "gap of a sample": (on("/pose", lambda ms: [*ms[:AT], *ms[AT + 1 :]]), "pose: gap, sample 37 is missing"),
    "double of a sample": (on("/pose", lambda ms: [*ms[: AT + 1], *ms[AT:]]), "pose: duplicate of sample 37"),
    "disorder of samples": (
        on("/twist", lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]]),
        "twist: out of order, sample 38 stands before 37",
    ),
    "gap": (on(MAG, lambda ms: [*ms[:AT], *ms[AT + 1 :]]), "/imu/mag: gap, reading 37 is missing"),
    "gaps": (on(MAG, lambda ms: [*ms[:AT], *ms[AT + 4 :]]), "/imu/mag: gap, 4 readings from 37 to 40 are missing"),
    "double": (on(BIAS, lambda ms: [*ms[: AT + 1], *ms[AT:]]), "/imu/bias: duplicate of reading 37"),
    "disorder": (
        on(BIAS, lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]]),
        "/imu/bias: out of order, reading 38 stands before 37",
    ),
    "no sensor": (declared(magnetometer_rate=0.0), "topic /imu/mag (70 messages), a sensor that no scenario has"),
    "foreign": (
        lambda ms: on(IMU, at(AT, scaled))(declared(software="lie_rigid_body 0.0.9")(ms)),
        f"readings of sensors: {PHRASES['another version'].format(software='lie_rigid_body 0.0.9')}, this is ",
    ),
    "a topic away": (
        lambda ms: recorded(0.1)([m for m in ms if m.topic != BIAS]),
        "imu/bias, which the scenario has: not in the bag",
    ),
}


@pytest.mark.parametrize("what", SAID)
def test_what_is_wrong_is_said_in_one_sentence(bag, tmp_path, what):
    change, sentence = SAID[what]
    try:
        found = certificate(bag, tmp_path, change)
        notes = [note for segment in found.segments for note in segment.notes]
        said = [*found.messages, *found.not_certified, *notes]
    except BagError as error:
        said = [str(error)]
    assert [text for text in said if sentence in text], said
