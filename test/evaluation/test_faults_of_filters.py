"""Mistakes in a filter, or about it, are told by their names from its attitudes alone, and by no other name."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import pytest

from lie_rigid_body import simulate
from lie_rigid_body.evaluation import SampledTruth, evaluate
from lie_rigid_body.evaluation.findings import Finding
from lie_rigid_body.lie import quaternion

NED = [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0]
FRD = [1.0, 0.0, 0.0, 0.0]
UP = np.array([0.0, 0.0, 1.0])

OF_THE_OUTPUT: dict[str, tuple[Callable[[np.ndarray], np.ndarray], set[str]]] = {
    "honest": (lambda q: q, set()),
    "conjugate": (quaternion.conjugate, {"inverted"}),
    "scalar first": (lambda q: np.roll(q, 1, axis=-1), {"scalar_first"}),
    "NED": (lambda q: quaternion.multiply(NED, q), {"ned_world"}),
    "NED and FRD": (lambda q: quaternion.multiply(quaternion.multiply(NED, q), FRD), {"ned_world"}),
    "heading": (lambda q: quaternion.multiply(quaternion.exp(np.pi / 2.0 * UP), q), {"heading_offset"}),
    "mounting": (lambda q: quaternion.multiply(q, quaternion.exp([0.1, 0.0, 0.14])), {"body_mounting"}),
    "FRD": (lambda q: quaternion.multiply(q, FRD), {"body_mounting"}),
    "stuck at identity": (lambda q: np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1)), {"stuck"}),
    "stuck at its last": (lambda q: np.tile(q[-1], (len(q), 1)), {"stuck"}),
}
"""What becomes of the right attitudes, and the names of that; a filter stuck may be told only so."""
OF_THE_GYRO: dict[str, tuple[np.ndarray, set[str]]] = {
    "swapped": (np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), {"turn_axes"}),
    "negated": (-np.eye(3), {"turn_axes"}),
    "deg/s": (np.degrees(np.eye(3)), {"turn_rate"}),
}
"""What the gyro's readings are multiplied by."""
OF_THE_SENSORS = {"heading_offset", "body_mounting"}
"""What hard iron, biases and misalignments of the sensors make of the attitudes of an honest filter that uses them."""


class Recorded(NamedTuple):
    """Readings of a gyro, directions that others tell, and samples of the truth, which cost less than a motion."""

    stamps_ns: np.ndarray
    gyro: np.ndarray
    directions: list[np.ndarray]
    known: list[np.ndarray]
    truth: SampledTruth


@cache
def recorded(scenario: str, grade: str) -> Recorded:
    run = simulate(
        scenario,
        sensor_grade=grade,
        duration=30.0,
        imu_rate=20.0,
        magnetometer_rate=20.0,
        accelerometer_mode="pivot_gravity",
        gyro_rate="integrated",
    )
    assert run.imu is not None
    assert run.magnetometer is not None
    assert run.scenario.sensors.magnetometer is not None
    field, fine = np.array(run.scenario.sensors.magnetometer.field), np.arange(3001) * 10_000_000
    directions = [
        v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (run.imu.specific_force, run.magnetometer.field)
    ]
    known = [UP, field / np.linalg.norm(field)]
    return Recorded(run.imu.t_ns, run.imu.gyro, directions, known, SampledTruth(fine, run.attitude().at(fine)))


def integrated(run: Recorded, gyro: np.ndarray) -> np.ndarray:
    """The product of the turns that a gyro reads, from the true attitude."""
    turns = quaternion.exp(gyro[1:] * np.diff(run.stamps_ns)[:, np.newaxis] / 1e9)
    return np.array(list(accumulate(turns, quaternion.multiply, initial=run.truth.at(run.stamps_ns[:1])[0])))


def corrected(run: Recorded, gyro: np.ndarray) -> np.ndarray:
    """As Mahony's filter, without an estimate of the bias."""
    found = [run.truth.at(run.stamps_ns[:1])[0]]
    for k, step_s in enumerate(np.diff(run.stamps_ns) / 1e9, 1):
        back = quaternion.conjugate(found[-1])
        error = np.zeros(3)
        for read, known in zip(run.directions, run.known, strict=True):
            error += np.cross(read[k], quaternion.rotate(back, known))
        turned = quaternion.multiply(found[-1], quaternion.exp((gyro[k] + error) * step_s))
        found.append(quaternion.normalize(turned))
    return np.array(found)


FILTERS = {"gyro": integrated, "Mahony": corrected}


def told(run: Recorded, estimate: np.ndarray) -> tuple[Finding, ...]:
    return evaluate(run.stamps_ns, estimate, run.truth).findings


def wrong(fault: str, run: Recorded, way: str) -> tuple[np.ndarray, set[str]]:
    """An estimate with a fault, and what it may be told as."""
    if fault in OF_THE_GYRO:
        matrix, names = OF_THE_GYRO[fault]
        return FILTERS[way](run, run.gyro @ matrix.T), names
    change, names = OF_THE_OUTPUT[fault]
    return change(FILTERS[way](run, run.gyro)), names


@pytest.mark.parametrize(
    ("scenario", "fault"),
    [
        ("tumbling_cubesat", "swapped"),
        ("tumbling_cubesat", "stuck at identity"),
        ("tumbling_cubesat", "NED"),
        ("tumbling_cubesat", "NED and FRD"),
        ("dzhanibekov", "negated"),
    ],
)
def test_a_fault_beside_the_errors_of_tactical_sensors_has_its_name_alone(scenario, fault):
    run = recorded(scenario, "tactical")
    estimate, names = wrong(fault, run, "gyro")
    [finding] = told(run, estimate)
    assert finding.code in names
    if finding.code == "ned_world":
        assert ("its body forward-right-down" in finding.message) == (fault == "NED and FRD")


@pytest.mark.slow
@pytest.mark.parametrize("way", FILTERS)
@pytest.mark.parametrize("grade", ["perfect", "tactical", "mems"])
@pytest.mark.parametrize("scenario", ["tumbling_cubesat", "dzhanibekov", "tossed_phone", "symmetric_top"])
@pytest.mark.parametrize("fault", [*OF_THE_OUTPUT, *OF_THE_GYRO])
def test_no_fault_has_a_false_name(fault, scenario, grade, way):
    """Nothing may be told where other errors are as large: a gyro of MEMS drifts, and corrections hide the gyro."""
    run = recorded(scenario, grade)
    estimate, names = wrong(fault, run, way)
    of_sensors = OF_THE_SENSORS if grade != "perfect" else set()
    assert {finding.code for finding in told(run, estimate)} <= names | of_sensors
