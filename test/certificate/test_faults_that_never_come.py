"""What is declared and never happens widens no limit: readings that are off beside it are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sensor_bags import ATTITUDE, BIAS, EVERY, FORCE, IMU, LATER, MAG, MOTIONS, NOISY, RATES, SUN, broken, laws, write
from tampering import Change, at, on, tamper, with_numbers

from lie_rigid_body.certificate import Certificate, certify
from lie_rigid_body.recording.bag_reader import Bag
from sampled import sampled

LARGEST = 1e9
NEVER = 1e9
GYRO, FORCES = 24, 12
"""Where the angular velocity and the specific force begin, in numbers from the end of a message."""


def never(name: str) -> dict[str, object]:
    """Episodes of which one comes in thirty years, and not in the first second."""
    return {f"{name}_interval": NEVER, f"{name}_duration": 1e-3}


def of_axes(sensor: str) -> dict[str, dict[str, object]]:
    return {
        "bursts": {**never(f"{sensor}_noise_burst"), f"{sensor}_noise_burst_density": LARGEST},
        "spikes": {f"{sensor}_spike_probability": 1e-300, f"{sensor}_spike_size": LARGEST},
        "drift": {f"{sensor}_temperature_drift": LARGEST, "fault_begin": 1e6},
        "stuck": never(f"{sensor}_stuck"),
        "saturation": {**never(f"{sensor}_saturation"), f"{sensor}_saturation_level": LARGEST},
        "all": {
            **never(f"{sensor}_noise_burst"),
            f"{sensor}_noise_burst_density": LARGEST,
            f"{sensor}_spike_probability": 1e-300,
            f"{sensor}_spike_size": LARGEST,
            f"{sensor}_temperature_drift": LARGEST,
            **never(f"{sensor}_stuck"),
            "fault_begin": 1e6,
        },
    }


def moved(numbers_from_end: int, by: float) -> Change:
    return lambda ms: [with_numbers(m, numbers_from_end, lambda x: np.concatenate([[x[0] + by], x[1:]])) for m in ms]


def honest(folder: Path, parameters: dict[str, object]) -> Path:
    path = write(folder / "a.mcap", (parameters, 0.3))
    found = certify(Bag(path))
    assert found.passed, found.messages
    return path


def verdict(path: Path, change: Change) -> Certificate:
    return certify(Bag(tamper(path, path.with_name("b.mcap"), change)))


@pytest.mark.parametrize("motion", ["closed form", "dmv20"])
@pytest.mark.parametrize("fault", sampled(of_axes("gyro"), every=3))
def test_a_gyro_that_is_off_is_refused(tmp_path, fault, motion):
    parameters = {**MOTIONS[motion], **NOISY, **of_axes("gyro")[fault]}
    path = honest(tmp_path, parameters)
    for by in (1e-7, 1e-11):
        assert broken(verdict(path, on(IMU, moved(GYRO, by)))) == {"gyro"}


@pytest.mark.parametrize("fault", sampled(of_axes("accelerometer"), every=3))
def test_an_accelerometer_that_is_off_is_refused(tmp_path, fault):
    parameters = {**MOTIONS["dmv20"], **FORCE, **NOISY, **of_axes("accelerometer")[fault]}
    assert broken(verdict(honest(tmp_path, parameters), on(IMU, moved(FORCES, 1e-10)))) == {"accelerometer"}


@pytest.mark.parametrize("topic", [GYRO, FORCES])
def test_a_bias_that_is_off_is_refused(tmp_path, topic):
    parameters = {**MOTIONS["dmv20"], **NOISY, **of_axes("gyro")["drift"], **of_axes("accelerometer")["drift"]}
    name = "gyro bias" if topic == GYRO else "accelerometer bias"
    assert broken(verdict(honest(tmp_path, parameters), on(BIAS, moved(topic, 1e-10)))) == {name}


@pytest.mark.parametrize("fault", sampled(["disturbance", *of_axes("magnetometer")], every=3))
def test_a_magnetometer_of_zeros_is_refused_and_one_that_is_off(tmp_path, fault):
    disturbance = {**never("magnetic_disturbance"), "magnetic_disturbance_size": 1e6}
    parameters = {**MOTIONS["dmv20"], **NOISY, **{**of_axes("magnetometer"), "disturbance": disturbance}[fault]}
    zeros: Change = lambda ms: [with_numbers(m, 12, lambda x: np.concatenate([0.0 * x[:3], x[3:]])) for m in ms]  # noqa: E731
    path = honest(tmp_path, parameters)
    for change in (zeros, moved(12, 1e-9), moved(12, 1e-14)):
        assert broken(verdict(path, on(MAG, change))) == {"magnetometer"}


@pytest.mark.parametrize(("topic", "end", "law"), [(ATTITUDE, 40, "attitude sensor"), (SUN, 3, "sun sensor")])
def test_directions_beside_all_faults_are_refused(tmp_path, topic, end, law):
    parameters = {**MOTIONS["dmv20"], **NOISY, **EVERY, **LATER, **of_axes("gyro")["all"]}
    assert broken(verdict(honest(tmp_path, parameters), on(topic, moved(end, 3e-12)))) == {law}


STEPS: dict[str, tuple[str, int, dict[str, object]]] = {
    "gyro": (IMU, GYRO, {"gyro_resolution": 1e-3}),
    "accelerometer": (IMU, FORCES, {"accelerometer_resolution": 1e-2, **FORCE}),
    "magnetometer": (MAG, 12, {"magnetometer_resolution": 1e-7}),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", STEPS)
def test_a_reading_moved_by_one_step_of_its_converter_is_refused(tmp_path, name, motion):
    topic, end, given = STEPS[name]
    step = next(value for key, value in given.items() if key.endswith("resolution"))
    assert isinstance(step, float)
    parameters = {**MOTIONS[motion], **NOISY, **given, **of_axes(name)["all"]}
    found = verdict(honest(tmp_path, parameters), on(topic, at(20, lambda m: moved(end, step)([m])[0])))
    assert broken(found) == {name}
    [law] = laws(found, name)
    assert (law.sample, law.broken, law.limit) == (20, 1, 0.0)


BODIES = {"rod": [1.0, 1.0, 1e-12], "needle": [1.0, 1.0, 1e-30], "wire": [1.0, 1.0, 1e-6], "across": [1e-12, 1.0, 1.0]}


@pytest.mark.parametrize("motion", ["closed form", "dmv20"])
@pytest.mark.parametrize("body", BODIES)
def test_the_rates_of_slender_bodies_are_held(tmp_path, body, motion):
    axis = BODIES[body].index(min(BODIES[body]))
    parameters = {**MOTIONS[motion], **RATES, "inertia": BODIES[body]}
    off = lambda m: with_numbers(m, 3, lambda x: x + 1e-9 * np.eye(3)[axis])  # noqa: E731
    path = honest(tmp_path, parameters)
    assert "body rate" in broken(verdict(path, on("/twist", lambda ms: list(map(off, ms)))))
    assert broken(verdict(path, on(IMU, moved(GYRO - axis, 1e-9)))) == {"gyro"}
