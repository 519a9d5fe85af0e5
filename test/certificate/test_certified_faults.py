"""Bags whose sensors have faults, or that no law reads: honest ones pass, and the topics are listed."""

from __future__ import annotations

import numpy as np
import pytest
from tampering import Message, on, tamper, with_numbers
from test_certified_sensors import (
    BIAS,
    COARSE,
    FORCE,
    IMU,
    MAG,
    MOTIONS,
    NOISY,
    VALUES,
    broken,
    declared,
    laws,
    recorded,
    write,
)

from lie_rigid_body.certificate import certify, readings, sensor_topics
from lie_rigid_body.recording.bag_reader import Bag

ATTITUDE, SUN, FAULTS = "/attitude/pose", "/sun/direction", "/lie_rigid_body/faults"


def episodes(name: str, interval: float = 0.2, duration: float = 0.05) -> dict[str, object]:
    return {f"{name}_interval": interval, f"{name}_duration": duration}


AXES: dict[str, dict[str, object]] = {
    "spikes": {"gyro_spike_probability": 0.05, "magnetometer_spike_probability": 0.05},
    "bursts": episodes("gyro_noise_burst") | episodes("accelerometer_noise_burst"),
    "stuck": episodes("accelerometer_stuck") | episodes("magnetometer_stuck") | episodes("gyro_stuck"),
    "stuck again": episodes("accelerometer_stuck", 0.1, 0.1) | episodes("magnetometer_stuck", 0.1, 0.1),
    "saturation": episodes("gyro_saturation") | episodes("magnetometer_saturation"),
    "drift": {"gyro_temperature_drift": 0.1, "magnetometer_temperature_drift": 1e-6},
    "disturbance": episodes("magnetic_disturbance"),
}
EVERY: dict[str, object] = {key: value for one in AXES.values() for key, value in one.items()}
DELIVERY: dict[str, tuple[dict[str, object], tuple[str, ...]]] = {
    "dropouts": ({"imu_dropout_probability": 0.2}, (IMU, BIAS)),
    "outages": (episodes("magnetometer_outage"), (MAG,)),
    "latency": ({"imu_latency": 0.02, "imu_latency_jitter": 0.01}, (IMU, BIAS)),
    "clock offset": ({"magnetometer_clock_offset": -1.3}, (MAG,)),
    "clock skew": ({"imu_clock_skew": 0.01}, (IMU, BIAS)),
}
"""Parameters, and the topics that no law reads then."""
SENSORS: dict[str, tuple[dict[str, object], str]] = {
    "attitude": ({"attitude_sensor_rate": 10.0, "attitude_sensor_roll_noise": 1e-3}, ATTITUDE),
    "sun": ({"sun_sensor_rate": 5.0, "sun_sensor_noise": 1e-3}, SUN),
    "orientation": ({"imu_orientation": True, "imu_heading_noise": 0.01}, IMU),
}
ALL = (IMU, BIAS, MAG)
START: dict[str, object] = {"motion": "closed_form", **FORCE, **NOISY}


@pytest.mark.parametrize("name", AXES)
def test_faults_of_axes_are_computed_anew(tmp_path, name):
    found = certify(Bag(write(tmp_path / "a.mcap", ({**START, **AXES[name]}, 1.0))))
    assert found.passed, found.messages
    assert found.sensors == ALL
    assert all(law.worst == 0.0 for value in VALUES for law in laws(found, value))
    assert any(text.startswith(f"topic {FAULTS} ") and text.endswith("no law reads it") for text in found.not_certified)


@pytest.mark.parametrize("motion", ["dmv20", "rkmk4"])
def test_faults_of_axes_after_steps_and_a_converter(tmp_path, motion):
    parameters = {**MOTIONS[motion], **FORCE, **NOISY, **COARSE, **EVERY, "gyro_rate": "integrated"}
    stages = [(parameters, 0.6), ({**parameters, "sensor_seed": 3}, 0.4)]
    found = certify(Bag(write(tmp_path / "a.mcap", *stages)))
    assert found.passed, found.messages
    assert found.sensors == ALL


@pytest.mark.parametrize("name", AXES)
def test_faults_of_axes_that_began_before_a_recorder_did(tmp_path, monkeypatch, name):
    monkeypatch.setattr(readings, "BLOCK", 7)
    path = write(tmp_path / "a.mcap", ({**START, **AXES[name]}, 1.0))
    found = certify(Bag(tamper(path, tmp_path / "b.mcap", recorded(0.213))))
    assert found.passed, found.messages
    assert found.sensors == ALL
    assert all(law.worst == 0.0 for value in VALUES for law in laws(found, value))


def test_a_stuck_axis_that_would_mostly_be_computed_in_vain_is_not(tmp_path, monkeypatch):
    monkeypatch.setattr(sensor_topics, "_MOST_IN_VAIN", 50)
    path = write(tmp_path / "a.mcap", ({**START, **AXES["stuck"]}, 0.5))
    found = certify(Bag(tamper(path, tmp_path / "b.mcap", recorded(0.3))))
    assert found.passed, found.messages
    assert found.sensors == (BIAS, MAG)


@pytest.mark.parametrize("name", AXES)
def test_faults_of_axes_that_are_declared_away_are_missed(tmp_path, name):
    path = write(tmp_path / "a.mcap", ({**START, **AXES[name]}, 0.5))
    none = dict.fromkeys((key for key in AXES[name] if not key.endswith("duration")), 0.0)
    found = certify(Bag(tamper(path, tmp_path / "b.mcap", declared(**none))))
    assert broken(found) & set(VALUES)


def test_a_spike_that_is_smoothed_away_is_named(tmp_path):
    path = write(tmp_path / "a.mcap", ({**START, "gyro_spike_probability": 0.01, "gyro_spike_size": 50.0}, 0.5))

    def smoothed(numbers: np.ndarray) -> np.ndarray:
        return np.where(np.abs(numbers) > 20.0, numbers - np.sign(numbers) * (50.0 - 1e-9), numbers)

    change = on(IMU, lambda ms: [with_numbers(m, 24, smoothed) if largest(m) > 20.0 else m for m in ms])
    found = certify(Bag(tamper(path, tmp_path / "b.mcap", change)))
    assert broken(found) == {"gyro"}
    assert "rad/s off what the scenario determines" in found.messages[0]


def largest(message: Message) -> float:
    """Size of the largest component of an angular velocity."""
    return float(np.abs(np.frombuffer(message.data[-192:-168])).max())


@pytest.mark.parametrize("name", DELIVERY)
def test_sensors_whose_readings_do_not_all_arrive_in_time_are_listed_and_break_no_law(tmp_path, name):
    parameters, topics = DELIVERY[name]
    found = certify(Bag(write(tmp_path / "a.mcap", ({**START, **parameters}, 1.0))))
    assert found.passed, found.messages
    assert found.sensors == tuple(topic for topic in ALL if topic not in topics)
    for topic in topics:
        [said] = [text for text in found.not_certified if text.startswith(f"topic {topic} ")]
        assert said.endswith("its readings are lost, late or stamped by a clock that errs")
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
