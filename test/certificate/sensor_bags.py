"""Bags with sensors, as a node records them, a recorder that came late, and what certificates say of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tampering import Change, tamper

from foreign_bags import Message
from lie_rigid_body.certificate import Certificate, LawResult, certify
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

EPOCH = 1_792_000_000_123_456_789
BODY = {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "initial_body_rate": [0.7, -1.3, 0.4], "epoch_ns": EPOCH}
RATES = {"rate": 59.94, "imu_rate": 333.3, "magnetometer_rate": 70.0}
NOISY: dict[str, object] = {
    "sensor_seed": 11,
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-3,
    "gyro_turn_on_bias": 0.01,
    "accelerometer_noise_density": 2e-3,
    "accelerometer_bias_random_walk": 2e-3,
    "accelerometer_turn_on_bias": 0.05,
    "magnetometer_noise_density": 1e-8,
}
COARSE: dict[str, object] = {
    "gyro_resolution": 1e-3,
    "gyro_range": 1.2,
    "accelerometer_resolution": 0.02,
    "accelerometer_range": 9.0,
    "magnetometer_resolution": 1e-7,
    "magnetometer_range": 30e-6,
}
FORCE: dict[str, object] = {"accelerometer_mode": "pivot_gravity", "accelerometer_lever_arm": [0.1, -0.2, 0.05]}
MOTIONS: dict[str, dict[str, object]] = {
    "closed form": {"motion": "closed_form"},
    "dmv20": {"max_step": 0.01},
    "rkmk4": {"method": "rkmk4", "max_step": 0.002},
}


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
LATER: dict[str, object] = {
    "attitude_sensor_rate": 10.0,
    "attitude_sensor_cross_boresight_noise": 1e-4,
    "attitude_sensor_roll_noise": 1e-3,
    "sun_sensor_rate": 25.0,
    "sun_sensor_noise": 1e-3,
    "imu_orientation": True,
    "imu_inclination_noise": 0.003,
    "imu_heading_noise": 0.01,
}
"""Attitude sensor, sun sensor and AHRS."""
LOST: dict[str, object] = {
    "imu_dropout_probability": 0.2,
    "sun_sensor_dropout_probability": 1.0,
    "fault_begin": 0.05,
    **episodes("magnetometer_outage"),
    **episodes("attitude_sensor_outage", 0.3, 0.3),
}
LATE: dict[str, object] = {
    "imu_latency": 0.02,
    "imu_latency_jitter": 0.01,
    "imu_dropout_probability": 0.1,
    "magnetometer_latency": 0.05,
    "attitude_sensor_latency_jitter": 0.3,
}
CLOCKS: dict[str, object] = {
    "imu_clock_skew": 1e-3,
    "magnetometer_clock_offset": -0.2,
    "attitude_sensor_clock_skew": -0.01,
    "sun_sensor_clock_offset": 1.7,
}
ERRING_CLOCKS: dict[str, dict[str, object]] = {
    "ahead": {"magnetometer_clock_offset": 3.7, "imu_clock_offset": 0.001},
    "behind": {"magnetometer_clock_offset": -1.3, "imu_clock_offset": -1e-9},
    "from zero": {"imu_clock_offset": -EPOCH * 1e-9 + 10.0},
    "fast": {"imu_clock_skew": 0.01, "magnetometer_clock_skew": 1e-6},
    "slow": {"imu_clock_skew": -0.01, "magnetometer_clock_skew": -1e-9},
    "all": {
        "imu_clock_skew": -0.003,
        "imu_clock_offset": -0.5,
        "magnetometer_clock_offset": 0.3,
        "imu_latency": 0.02,
        "imu_latency_jitter": 0.01,
        "imu_dropout_probability": 0.1,
    },
}
START: dict[str, object] = {"motion": "closed_form", **FORCE, **NOISY}
VALUES = ("gyro", "accelerometer", "gyro bias", "accelerometer bias", "magnetometer")
IMU, BIAS, MAG = "/imu/data_raw", "/imu/bias", "/imu/mag"
ATTITUDE, SUN, FAULTS = "/attitude/pose", "/sun/direction", "/lie_rigid_body/faults"
ALL = (IMU, BIAS, MAG)
AT = 37


def write(path: Path, *stages: tuple[dict[str, object], float], chunk_size: int = 40_000, **options: Any) -> Path:
    """A bag as a node records it: a reset's scenario at once, readings left from before it later."""
    simulation = Simulation(Scenario.from_parameters({**BODY, **RATES, **stages[0][0]}))
    end = EPOCH
    stamped = simulation.segment.scenario.stamped_twist
    with BagWriter(path, stamped_twist=stamped, chunk_size=chunk_size, **options) as bag:
        for i, (parameters, seconds) in enumerate(stages):
            if i:
                simulation.reset(Scenario.from_parameters({**BODY, **RATES, **parameters}))
            bag.begin_segment(simulation.segment)
            encoder, end = BatchEncoder(simulation.segment.scenario), end + round(seconds * 1e9)
            while simulation.next_stamp_ns <= end:
                bag.write(encoder.encode(simulation.take_until(end, 40)))
    return path


def recorded(late: float, early: float = 0.0) -> Change:
    """What a recorder would have that came late, s, and on each topic ended a little differently before the end."""

    def change(messages: list[Message]) -> list[Message]:
        last = messages[-1].log_time - early * 1e9
        ends = {topic: last - 3e6 * i for i, topic in enumerate((IMU, "/pose", BIAS, "/twist", MAG))}
        return [
            m._replace(log_time=m.log_time + 12_345)
            for m in messages
            if m.topic not in ends or EPOCH + late * 1e9 <= m.log_time <= ends[m.topic]
        ]

    return change


def certificate(bag: Path, folder: Path, change: Change) -> Certificate:
    return certify(Bag(tamper(bag, folder / "tampered.mcap", change)))


def laws(found: Certificate, name: str) -> list[LawResult]:
    return [law for segment in found.segments for law in segment.laws if law.name == name]


def broken(found: Certificate) -> set[str]:
    return {law.name for part in (*(s.laws for s in found.segments), found.whole) for law in part if not law.holds}
