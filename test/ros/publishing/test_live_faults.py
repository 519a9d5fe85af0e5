"""Faults live: the node sends and records the bytes of a headless run, and who comes late hears of them too."""

from __future__ import annotations

import signal
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from simulator_process import SimulatorProcess, assignments, eventually

from lie_rigid_body import Run, simulate
from lie_rigid_body.sensors import Fault

if find_spec("rclpy"):
    from peer import Peer
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

pytestmark = pytest.mark.ros

EPOCH = 1_234_567_890_000_000_000
GIVEN: dict[str, Any] = {
    "epoch_ns": EPOCH,
    "rate": 20.0,
    "imu_rate": 100.0,
    "imu_latency": 0.03,
    "imu_latency_jitter": 0.03,
    "imu_clock_offset": -0.01,
    "imu_dropout_probability": 0.1,
    "gyro_noise_density": 1e-3,
    "gyro_stuck_interval": 0.5,
    "gyro_stuck_duration": 0.2,
    "magnetometer_rate": 10.0,
    "magnetic_disturbance_interval": 1.0,
    "magnetic_disturbance_duration": 0.5,
    "attitude_sensor_rate": 5.0,
    "attitude_sensor_roll_noise": 1e-3,
    "attitude_sensor_outage_interval": 1.5,
    "sun_sensor_rate": 5.0,
}


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Topic, log time and bytes of each message, in file order."""
    with path.open("rb") as stream:
        found = make_reader(stream).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in found]


@pytest.mark.slow
def test_a_live_run_with_faults_has_the_bytes_of_a_headless_one(peer: Peer, tmp_path: Path) -> None:
    live, headless = tmp_path / "live.mcap", tmp_path / "headless.mcap"
    arguments = assignments(**GIVEN, real_time_factor=10.0, record_path=live)
    with SimulatorProcess(*arguments) as simulator:
        poses = live.stat().st_size
        eventually(lambda: live.stat().st_size > poses + 30_000, "some seconds of samples")
        late = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        told = peer.listen(String, "/lie_rigid_body/faults", late)
        peer.spin_until(lambda: len(told) > 20, "faults that began before there was a listener")
        assert simulator.end(signal.SIGINT) == 0
    run = simulate(**GIVEN, duration=len(Run.from_bag(live).t_ns) / 20.0)
    run.to_bag(headless)
    sent, computed = messages(live), messages(headless)
    count = min(len(sent), len(computed))
    assert count > 200
    assert {topic for topic, *_ in sent} >= {"/imu/data_raw", "/imu/bias", "/attitude/pose", "/sun/direction"}
    assert sent[:count] == computed[:count]
    assert len(computed) - count < 200  # the live run ended before the last of what was under way
    faults = [Fault.from_json(message.data) for message in told]
    assert faults[0].begin_ns == EPOCH
    assert faults == list(run.faults)[: len(faults)] or faults[: len(run.faults)] == list(run.faults)
