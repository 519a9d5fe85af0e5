"""Honest bags with sensors are certified: one table of what they read, how they fail, and what a reset changes."""

from __future__ import annotations

from pathlib import Path

import pytest
from sensor_bags import (
    ATTITUDE,
    AXES,
    BIAS,
    CLOCKS,
    COARSE,
    ERRING_CLOCKS,
    EVERY,
    FAULTS,
    FORCE,
    IMU,
    LATE,
    LATER,
    LOST,
    MAG,
    MOTIONS,
    NOISY,
    START,
    SUN,
    VALUES,
    certificate,
    laws,
    recorded,
    write,
)

from lie_rigid_body.certificate import certify, readings
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.sensors import GRADES
from sampled import sampled

Stages = list[tuple[dict[str, object], float]]
POINTING = ("IMU orientation", "attitude sensor", "attitude sensor covariance", "sun sensor")
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


PERFECT: dict[str, object] = {key: value for key, value in LATER.items() if not key.endswith("noise")}


def switched(start: dict[str, object], **changes: object) -> Stages:
    """A run, another with some changes, and the first again."""
    return [(start, 0.4), ({**start, **changes}, 0.3), (start, 0.3)]


HONEST: dict[str, Stages] = {
    **{name: [({**MOTIONS["closed form"], **given}, 0.6)] for name, given in SENSORS.items()},
    **{
        f"{name} by {motion}": [({**MOTIONS[motion], **SENSORS[name]}, 0.6)]
        for motion in ("dmv20", "rkmk4")
        for name in ("lever arm", "integrated", "all errors", "mems")
    },
    **{
        f"a reset to {name}": [(START, 0.4), ({**START, **given}, 0.3), ({**START, **given}, 0.001), (START, 0.3)]
        for name, given in RESETS.items()
    },
    **{f"{name} that fails": [({**START, **given}, 0.6)] for name, given in AXES.items()},
    **{
        f"all faults by {name}": switched(
            {**MOTIONS[name], **FORCE, **NOISY, **COARSE, **EVERY, "gyro_rate": "integrated"}, sensor_seed=3
        )
        for name in ("dmv20", "rkmk4")
    },
    "lost readings": [*switched({**START, **LATER, **LOST}, sensor_seed=3), ({**START, **LATER}, 0.2)],
    "late readings": [
        *switched({**START, **LATER, **LATE}, imu_frame="other", sensor_seed=3),
        ({**START, **LATER}, 0.2),
        ({**START, **LATER, **LATE}, 0.3),
    ],
    **{
        f"directions by {motion}, {name}": switched({**MOTIONS[motion], **given}, sun_sensor_rate=0.0)
        for motion in MOTIONS
        for name, given in (("noisy", LATER), ("perfect", PERFECT))
    },
    **{f"a clock {name}": [({**START, **given}, 0.6)] for name, given in ERRING_CLOCKS.items()},
    **{
        f"all together, {grade}": switched(
            {**MOTIONS[motion], **FORCE, **EVERY, **LATER, **LOST, **LATE, **CLOCKS, "sensor_grade": grade},
            sensor_seed=5,
        )
        for grade, motion in zip(GRADES, ("closed form", "dmv20", "dmv20", "closed form"), strict=True)
    },
    **{
        f"a magnetometer between two without, its clock off by {offset} s": switched(
            {**START, "magnetometer_rate": 0.0}, magnetometer_rate=70.0, magnetometer_clock_offset=offset
        )
        for offset in (0.15, -0.15)
    },
}


@pytest.mark.parametrize("name", sampled(HONEST, every=6))
def test_an_honest_bag_is_certified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """As it was written, and as a recorder has it that came late: values to the bit, or within half of the limits."""
    path = write(tmp_path / "a.mcap", *HONEST[name])
    whole = certify(Bag(path))
    given = [segment.segment.scenario.sensors for segment in whole.segments]
    topics = {"imu": (IMU, BIAS), "magnetometer": (MAG,), "attitude_sensor": (ATTITUDE,), "sun_sensor": (SUN,)}
    wanted = tuple(each for sensor in topics for each in topics[sensor] if any(getattr(one, sensor) for one in given))
    monkeypatch.setattr(readings, "REPLAY_BLOCK", 7)
    late = certificate(path, tmp_path, recorded(0.213, 0.06))
    for found in (whole, late):
        assert found.passed, found.messages
        held = [law for value in (*VALUES, *POINTING) for law in laws(found, value)]
        assert all(law.worst <= 0.5 * law.limit or law.worst == 0.0 for law in held)
        is_exact = all(stage.get("motion") == "closed_form" for stage, _ in HONEST[name])
        assert not is_exact or all(law.worst == 0.0 for law in held)
    assert whole.sensors == wanted
    assert late.sensors == wanted or (name == "slow" and set(late.sensors) < set(wanted))
    assert len(whole.segments) > 1 or all(law.checked for law in whole.laws if law.name in (*VALUES, *POINTING))
    assert "that fails" not in name or "faults" in {law.name for law in whole.whole}
    assert not any(FAULTS in text for text in whole.not_certified)
