"""What a live run records is certified with its sensors, however it is paused, stepped, slowed down and reset."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_time import NS, ScriptedRun

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.ros.publishing.recorder import Recorder
from lie_rigid_body.scenario import Scenario
from sampled import sampled

GIVEN: dict[str, Any] = {
    "rate": 30.0,
    "imu_rate": 111.1,
    "magnetometer_rate": 37.0,
    "sensor_grade": "mems",
    "accelerometer_mode": "pivot_gravity",
}
FAULTS: dict[str, Any] = {
    "imu_dropout_probability": 0.1,
    "imu_latency": 0.03,
    "imu_latency_jitter": 0.02,
    "imu_clock_skew": 0.004,
    "magnetometer_clock_offset": -0.7,
    "magnetometer_outage_interval": 0.4,
    "magnetometer_outage_duration": 0.2,
    "gyro_spike_probability": 0.05,
    "accelerometer_stuck_interval": 0.3,
    "accelerometer_stuck_duration": 0.1,
}
CHANGES: list[dict[str, Any]] = [
    {},
    FAULTS,
    {**FAULTS, "imu_orientation": True},
    {"gyro_rate": "integrated", "gyro_bias_random_walk": 1e-3},
    {"imu_rate": 200.0, "imu_frame": "elsewhere"},
    {"rate": 47.0, "initial_body_rate": [0.4, -0.3, 0.9]},
    {"imu_rate": 0.0},
    {"magnetometer_rate": 0.0, "accelerometer_noise_density": 0.1},
    {"sensor_seed": 5, "motion": "moving_chart", "magnetometer_rate": 90.0},
]


def actions(run: ScriptedRun, random: np.random.Generator) -> list[Callable[[], object]]:
    change = CHANGES[random.integers(len(CHANGES))]
    return [
        lambda: run.live.reset(Scenario.from_parameters({"motion": "closed_form", **GIVEN, **change})),
        run.live.pause,
        run.live.resume,
        lambda: run.live.step(3),
        lambda: run.live.change_factor(3.0),
        lambda: run.live.change_factor(0.5),
    ]


@pytest.mark.parametrize("seed", sampled(range(6), every=3))
def test_whatever_is_done_to_a_live_run_its_sensors_are_certified(tmp_path: Path, seed: int) -> None:
    """Also where faults and clocks that err are switched on and off by resets."""
    random, begin = np.random.default_rng(seed), FAULTS if seed % 2 else {}
    with BagWriter(tmp_path / "a.mcap", stamped_twist=True) as writer:
        run = ScriptedRun(sinks=[Recorder(writer, pytest.fail)], **GIVEN, **begin)
        times = np.sort(random.integers(0, 4 * NS, 14)).tolist()
        script = [(at, random.choice(np.array(actions(run, random), dtype=object))) for at in times]
        run.play(*script, (5 * NS, lambda: None))
    found = certify(Bag(tmp_path / "a.mcap"))
    assert found.passed, found.messages
    assert len(found.sensors) == 3
    assert any(law.name == "gyro" and law.checked for segment in found.segments for law in segment.laws)
    if begin:
        assert [law.checked > 0 for law in found.whole if law.name == "faults"] == [True]
    assert not any("faults" in text for text in found.not_certified)
