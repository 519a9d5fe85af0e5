"""What certificates say: one sentence for each thing that may be wrong with the readings of sensors."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_bags import AT, BIAS, IMU, MAG, certificate, recorded
from tampering import Change, Message, at, declared, on, with_numbers


def scaled(message: Message) -> Message:
    return with_numbers(message, 24, lambda x: np.append(1.5 * x[:3], x[3:]))


SAID: dict[str, tuple[Change, str]] = {
    "value": (
        on(IMU, at(AT, scaled)),
        "/imu/data_raw: gyro is 0.353 rad/s off what the scenario determines (limit 1.1e-14) at reading 37, "
        "0.111011101 s after the start",
    ),
    "frame": (
        on(MAG, at(AT, lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lunk")))),
        "/imu/mag: frame or covariances are not as declared, at reading 37, 0.528571429 s after the start",
    ),
    "gap": (on(MAG, lambda ms: [*ms[:AT], *ms[AT + 1 :]]), "/imu/mag: gap, reading 37 is missing"),
    "gaps": (on(MAG, lambda ms: [*ms[:AT], *ms[AT + 4 :]]), "/imu/mag: gap, 4 readings from 37 to 40 are missing"),
    "double": (on(BIAS, lambda ms: [*ms[: AT + 1], *ms[AT:]]), "/imu/bias: duplicate of reading 37"),
    "disorder": (
        on(BIAS, lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]]),
        "/imu/bias: out of order, reading 38 stands before 37",
    ),
    "no sensor": (
        declared(magnetometer_rate=0.0),
        "topic /imu/mag (70 messages), a sensor that no scenario has",
    ),
    "foreign": (
        lambda ms: on(IMU, at(AT, scaled))(declared(software="lie_rigid_body 0.0.9")(ms)),
        "readings of sensors: the scenario is of 'lie_rigid_body 0.0.9', this is lie_rigid_body",
    ),
    "a topic away": (
        lambda ms: recorded(0.1)([m for m in ms if m.topic != BIAS]),
        "imu/bias, which the scenario has: not in the bag",
    ),
}


@pytest.mark.parametrize("what", SAID)
def test_what_is_wrong_is_said_in_one_sentence(bag, tmp_path, what):
    change, sentence = SAID[what]
    found = certificate(bag, tmp_path, change)
    said = [*found.messages, *found.not_certified]
    assert [text for text in said if text.startswith(sentence)], said
