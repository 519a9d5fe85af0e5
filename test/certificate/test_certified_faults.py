"""Bags whose sensors have faults, or that no law reads: honest ones pass, and the topics are listed."""

from __future__ import annotations

import pytest
from test_certified_sensors import BIAS, FORCE, IMU, MAG, NOISY, write

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag

ATTITUDE, SUN, FAULTS = "/attitude/pose", "/sun/direction", "/lie_rigid_body/faults"


def episodes(name: str, interval: float = 0.2, duration: float = 0.05) -> dict[str, object]:
    return {f"{name}_interval": interval, f"{name}_duration": duration}


FAULTY: dict[str, tuple[dict[str, object], tuple[str, ...]]] = {
    "spikes": ({"gyro_spike_probability": 0.05, "magnetometer_spike_probability": 0.05}, (IMU, BIAS, MAG)),
    "bursts": (episodes("gyro_noise_burst") | episodes("accelerometer_noise_burst"), (IMU, BIAS)),
    "stuck": (episodes("accelerometer_stuck") | episodes("magnetometer_stuck"), (IMU, BIAS, MAG)),
    "saturation": (episodes("gyro_saturation") | episodes("magnetometer_saturation"), (IMU, BIAS, MAG)),
    "drift": ({"gyro_temperature_drift": 0.1, "magnetometer_temperature_drift": 1e-6}, (IMU, BIAS, MAG)),
    "disturbance": (episodes("magnetic_disturbance"), (MAG,)),
    "dropouts": ({"imu_dropout_probability": 0.2}, (IMU, BIAS)),
    "outages": (episodes("magnetometer_outage"), (MAG,)),
    "latency": ({"imu_latency": 0.02, "imu_latency_jitter": 0.01}, (IMU, BIAS)),
    "clock offset": ({"magnetometer_clock_offset": -1.3}, (MAG,)),
    "clock skew": ({"imu_clock_skew": 0.01}, (IMU, BIAS)),
}
"""Parameters, and the topics whose sensors then have faults."""
SENSORS: dict[str, tuple[dict[str, object], str]] = {
    "attitude": ({"attitude_sensor_rate": 10.0, "attitude_sensor_roll_noise": 1e-3}, ATTITUDE),
    "sun": ({"sun_sensor_rate": 5.0, "sun_sensor_noise": 1e-3}, SUN),
    "orientation": ({"imu_orientation": True, "imu_heading_noise": 0.01}, IMU),
}
ALL = (IMU, BIAS, MAG)
START: dict[str, object] = {"motion": "closed_form", **FORCE, **NOISY}


@pytest.mark.parametrize("name", FAULTY)
def test_sensors_with_faults_are_listed_and_break_no_law(tmp_path, name):
    parameters, topics = FAULTY[name]
    found = certify(Bag(write(tmp_path / "a.mcap", ({**START, **parameters}, 1.0))))
    assert found.passed, found.messages
    assert found.sensors == tuple(topic for topic in ALL if topic not in topics)
    for topic in topics:
        [said] = [text for text in found.not_certified if text.startswith(f"topic {topic} ")]
        assert said.endswith("messages): its sensor has faults")
    assert any(text.startswith(f"topic {FAULTS} ") and text.endswith("no law reads it") for text in found.not_certified)


@pytest.mark.parametrize("name", SENSORS)
def test_sensors_that_no_law_reads_are_listed_and_break_none(tmp_path, name):
    parameters, topic = SENSORS[name]
    found = certify(Bag(write(tmp_path / "a.mcap", ({**START, **parameters}, 1.0))))
    assert found.passed, found.messages
    assert found.sensors == tuple(own for own in ALL if own != topic)
    assert any(text.startswith(f"topic {topic} ") and "no law reads" in text for text in found.not_certified)


def test_a_fault_of_one_segment_takes_its_topic_from_all(tmp_path):
    faulty = {**START, "magnetometer_clock_offset": 3.0}
    found = certify(Bag(write(tmp_path / "a.mcap", (START, 0.3), (faulty, 0.3), (START, 0.3))))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS)
