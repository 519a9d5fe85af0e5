"""Bags with sensors, as a node records them, a recorder that came late, and what certificates say of them."""

from __future__ import annotations

from pathlib import Path

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
VALUES = ("gyro", "accelerometer", "gyro bias", "accelerometer bias", "magnetometer")
IMU, BIAS, MAG = "/imu/data_raw", "/imu/bias", "/imu/mag"
TOPICS = [IMU, BIAS, MAG]
AT = 37


def write(path: Path, *stages: tuple[dict[str, object], float], chunk_size: int = 10_000) -> Path:
    """A bag as a node records it: a reset's scenario at once, readings left from before it later."""
    simulation = Simulation(Scenario.from_parameters({**BODY, **RATES, **stages[0][0]}))
    end = EPOCH
    with BagWriter(path, stamped_twist=True, chunk_size=chunk_size) as bag:
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
