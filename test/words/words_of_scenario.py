"""What scenarios and their files say where they are refused."""
# mypy: ignore-errors

from __future__ import annotations

from pathlib import Path

import numpy as np

from lie_rigid_body import simulate
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather, parse_assignment, read_parameter_file, scenario_file

FILES = [
    "",
    "- 1\n- 2\n",
    "just words",
    "/**:\n  ros__parameters:\n    rate: [1.0\n",
    "/**:\n\tros__parameters:",
    "/**:\n  ros__parameters:\n    rate: 1.0\n    rate: 2.0\n",
    "/**:\n  ros__parameters:\n    rate:\n",
    "/**: {ros__parameters: {[1, 2]: 3}}",
    "rate: 1.0\n",
    "{}",
    "ros__parameters:\n  rate: 1.0\n",
    "/**:\n  ros__parameters: 3\n",
    "talker: {ros__parameters: {a: 1}}\n/x/*: {ros__parameters: {a: 1}}",
    "/**: {ros__parameters: {a: !!python/object:os.system 1}}",
    "/**: {ros__parameters: {a: *b}}",
    "--- 1\n--- 2\n",
    "\x07",
    "[" * 5000,
]
FAST = [1e12, 1e12, 0.0]
QUICK = {"method": "rkmk4", "max_step": 10.0, "rate": 0.1, "initial_body_rate": [3.0, 0.5, -0.9]}
SPIN = {"gyro_rate": "integrated", "initial_body_rate": [0.0, 0.0, 30.0], "imu_rate": 9.0}


KNOTS = [number for k in range(4) for number in (0.1 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)]
FAST_KNOTS = [number for k in range(4) for number in (0.01 * k, 0.0, 0.0, 0.0, 0.0, 0.0, np.sin(k), np.cos(k))]
MANY = 2e6
TRIADS = ("gyro", "accelerometer")
NO_SENSORS = [
    {"sun_sensor_rate": 1e5, "sun_sensor_latency_jitter": 1.1},
    *({name: rate} for name in ("imu_rate", "magnetometer_rate") for rate in (1e-7, 1e10)),
    *({"imu_frame": name} for name in ("/imu", "")),
    *({"sensor_seed": seed} for seed in (-1, 2**63, 1.5)),
    *({"sensor_grade": grade} for grade in ("cheap", 3, ["mems"])),
    {"gyro_rate": "mean"},
    {"accelerometer_mode": "pivot"},
    {"accelerometer_lever_arm": [0.0, -MANY, 1.0]},
    {"magnetic_field": [0.0, 0.0, 48.0e6]},
    {"magnetometer_hard_iron": [1e4, 0.0, 0.0]},
    {"magnetometer_soft_iron": [1e7] * 9},
    {"attitude_sensor_boresight": [0.0] * 3},
    {"gyro_stuck_interval": 0.5},
    {"imu_outage_interval": 1e-4},
    {"fault_begin": 3.0, "fault_end": 2.0},
    {"imu_clock_skew": 0.1},
    {"gyro_noise_densty": 1.0},
    *({f"{sensor}_resolution": 2.0, f"{sensor}_range": 1.0} for sensor in (*TRIADS, "magnetometer")),
    *({f"{sensor}_resolution": 1e-300} for sensor in (*TRIADS, "magnetometer")),
    *({f"{sensor}_scale_factor": [1.0, MANY, 1.0]} for sensor in TRIADS),
    *({f"{sensor}_misalignment": [2.0, 2.0, 2.0]} for sensor in TRIADS),
]


def file(content):
    """Read a parameter file of such a content."""
    path = Path("params.yaml")
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_parameter_file(path)


def loop():
    """Read a link to itself."""
    path = Path("loop")
    path.symlink_to("loop")
    return read_parameter_file(path)


def given(**parameters):
    return Scenario.from_parameters(parameters)


def assigned(text, option="-p"):
    return Scenario.from_parameters(dict([parse_assignment(text, option)]))


REFUSED = {
    InputError: [
        *(lambda text=text: file(text) for text in FILES),
        lambda: file(b"\xff\xfe\x00"),
        lambda: read_parameter_file(Path("none.yaml")),
        lambda: read_parameter_file(Path()),
        loop,
        lambda: read_parameter_file(Path("nul\0l")),
        lambda: Scenario.from_parameters(gather(None, [], ["other:rate:=40.0"])),
        lambda: Scenario.from_parameters(5),
        lambda: scenario_file("dzanibekov"),
        lambda: assigned("rate=3"),
        lambda: assigned("inertia:=[1.0"),
        lambda: assigned(f"rate:=0x{10**5 * 'F'}"),
        lambda: assigned("inertia = [" + "1.0, " * 200 + "]", "--set"),
        lambda: assigned("epoch_ns:=" + "9" * 30),
        lambda: given(initial_body_rate=FAST, rate=1e-6),
        lambda: given(**QUICK),
        lambda: given(**SPIN),
        *(lambda sensors=sensors: given(**sensors) for sensors in NO_SENSORS),
        lambda: given(motion="path"),
        lambda: given(motion="path", path_file="hand.tum"),
        lambda: given(motion="path", path_knots=KNOTS, kick_period=2.0),
        lambda: given(motion="path", path_knots=KNOTS, inertia=[1.0, 2.0, 2.5]),
        lambda: given(path_knots=[1.0]),
        lambda: given(motion="path", path_knots=KNOTS).require_until(10**9),
        lambda: given(motion="path", path_knots=FAST_KNOTS, imu_rate=9.0, gyro_rate="integrated"),
        lambda: simulate(duration=1.0, imu_rate=10.0, imu_clock_offset=-0.5),
        lambda: Scenario().resampled(rate=np.nan),
        lambda: Scenario().resampled(rate=np.zeros((0, 3))),
        lambda: Scenario().resampled(epoch_ns=1.5),
    ]
}
SAID = [
    lambda: given(gyro_spike_probability=0.1).without_effect,
    lambda: given(gyro_rate="integrated", gyro_range=9.0, imu_outage_duration=0.1, sun_sensor_noise=0.1).without_effect,
    lambda: given(path_file="hand.tum", path_interval=0.1).without_effect,
    lambda: given(imu_rate=9.0, imu_heading_noise=0.1, fault_end=5.0).without_effect,
]
