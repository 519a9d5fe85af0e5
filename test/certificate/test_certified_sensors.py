"""Honest readings of sensors are certified, against limits as narrow as the motion allows."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.special
from sensor_bags import BIAS, COARSE, FORCE, IMU, MAG, MOTIONS, NOISY, VALUES, laws, recorded, write
from tampering import tamper

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag
from sampled import sampled

SKEWED: dict[str, object] = {
    "gyro_scale_factor": [1.01, -0.98, 1.02],
    "gyro_misalignment": [0.01, -0.02, 0.03],
    "accelerometer_scale_factor": [1.01, 0.98, -1.02],
    "accelerometer_misalignment": [0.3, -0.02, 0.03],
    "magnetometer_hard_iron": [1e-6, 2e-6, -3e-6],
    "magnetometer_soft_iron": [1.1, 0.02, 0.01, -0.03, 0.95, 0.04, 0.05, 0.02, 1.05],
}
SENSORS: dict[str, dict[str, object]] = {
    "perfect": {},
    "lever arm": {"accelerometer_lever_arm": [0.1, -0.2, 0.05]},
    "pivot": {"accelerometer_mode": "pivot_gravity", "gravity": 1.62},
    "integrated": {"gyro_rate": "integrated"},
    "noisy": NOISY,
    "skewed": {**FORCE, **SKEWED},
    "coarse": {**FORCE, **COARSE},
    "all errors": {**FORCE, **NOISY, **SKEWED, **COARSE, "gyro_rate": "integrated"},
    "mems": {**FORCE, "sensor_grade": "mems"},
    "tactical": {**FORCE, "sensor_grade": "tactical", "gyro_noise_density": 0.0},
    "another field": {"magnetic_field": [2e-5, -1e-5, 3e-5], "imu_frame": "sénsor"},
    "magnetometer alone": {"imu_rate": 0.0},
    "IMU alone": {"magnetometer_rate": 0.0},
    "slow": {"imu_rate": 3.0, "magnetometer_rate": 0.7},
}
WITH_STEPS = ("lever arm", "integrated", "all errors", "mems")


@pytest.mark.parametrize(
    ("motion", "sensors"),
    sampled(
        [("closed form", name) for name in SENSORS]
        + [(name, some) for name in ("dmv20", "rkmk4") for some in WITH_STEPS],
        every=3,
    ),
)
def test_honest_readings_are_certified(tmp_path, motion, sensors):
    parameters = {**MOTIONS[motion], **SENSORS[sensors]}
    found = certify(Bag(write(tmp_path / "a.mcap", (parameters, 0.6))))
    assert found.passed, found.messages
    scenario = found.segments[0].segment.scenario.sensors
    wanted = [IMU, BIAS] * (scenario.imu is not None) + [MAG] * (scenario.magnetometer is not None)
    assert list(found.sensors) == wanted
    held = [law for name in VALUES for law in laws(found, name)]
    assert len(held) == 4 * (scenario.imu is not None) + (scenario.magnetometer is not None)
    assert not any("imu/" in text for text in found.not_certified)
    if motion == "closed form":
        assert all(law.worst == 0.0 for law in held)  # the same numbers, to the bit
    for law in held:
        assert law.checked > 0
        assert law.worst <= 0.5 * law.limit or law.worst == 0.0


RESETS: dict[str, dict[str, object]] = {
    "the same": {},
    "another start": {"initial_body_rate": [0.3, 0.3, -1.0]},
    "another rate": {"imu_rate": 111.1, "rate": 80.0},
    "another frame": {"imu_frame": "other_link"},
    "another noise": {"gyro_noise_density": 0.5, "sensor_seed": 3, "magnetometer_resolution": 1e-6},
    "no magnetometer": {"magnetometer_rate": 0.0},
    "no IMU": {"imu_rate": 0.0},
    "no sensor": {"imu_rate": 0.0, "magnetometer_rate": 0.0},
}


@pytest.mark.parametrize("change", sampled(RESETS, every=3))
def test_resets_begin_the_noise_anew(tmp_path, change):
    first: dict[str, object] = {"motion": "closed_form", **FORCE, **NOISY}
    stages = [(first, 0.5), ({**first, **RESETS[change]}, 0.4), ({**first, **RESETS[change]}, 0.001), (first, 0.3)]
    path = write(tmp_path / "a.mcap", *stages)
    found = certify(Bag(path))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
    assert all(law.worst == 0.0 for name in VALUES for law in laws(found, name))
    late = tamper(path, tmp_path / "b.mcap", recorded(0.213, 0.06))
    found = certify(Bag(late))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)


def test_last_bits_of_another_library_are_certified(tmp_path, monkeypatch):
    """Of the closed form too: a bag is checked on other machines than the one that made it."""
    ndtri = scipy.special.ndtri
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(scipy.special, "ndtri", lambda x, out: np.nextafter(ndtri(x), np.inf, out=out))
        path = write(tmp_path / "a.mcap", ({**MOTIONS["closed form"], **NOISY}, 1.0))
    found = certify(Bag(path))
    assert found.passed, found.messages
    assert all(law.worst > 0.0 for name in VALUES for law in laws(found, name))
