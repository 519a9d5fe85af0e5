"""No parameter widens a limit unless it changes a message: each is set to its extremes where it has no effect."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.certificate import certify
from lie_rigid_body.certificate.law_result import Watch
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.simulation import Simulation

SECONDS = 0.4
SENSORS: dict[str, object] = {
    "imu_rate": 30.0,
    "magnetometer_rate": 20.0,
    "attitude_sensor_rate": 10.0,
    "sun_sensor_rate": 10.0,
    "epoch_ns": 10**18,
    "rate": 10.0,
    "motion": "closed_form",
}
LATE: dict[str, object] = {
    **{
        f"{fault}_interval": 8.0
        for fault in (
            *(f"{sensor}_outage" for sensor in ("imu", "magnetometer", "attitude_sensor", "sun_sensor")),
            *(
                f"{sensor}_{kind}"
                for sensor in ("gyro", "accelerometer", "magnetometer")
                for kind in ("noise_burst", "stuck", "saturation")
            ),
            "magnetic_disturbance",
        )
    },
    **{f"{sensor}_spike_probability": 0.5 for sensor in ("gyro", "accelerometer", "magnetometer")},
    **{f"{sensor}_temperature_drift": 1.0 for sensor in ("gyro", "accelerometer", "magnetometer")},
    "fault_begin": 1e6,
}
"""Every fault that comes and goes, eleven days after the start."""
BASES: dict[str, dict[str, object]] = {
    "all sensors and late faults": {
        **SENSORS,
        **{key: value for key, value in LATE.items() if not key.endswith("_temperature_drift")},
        "sensor_grade": "mems",
        "imu_orientation": True,
        "imu_heading_noise": 0.1,
        "attitude_sensor_roll_noise": 1e-3,
        "sun_sensor_noise": 1e-3,
        "accelerometer_mode": "pivot_gravity",
    },
    "at rest without noise": {**SENSORS, **LATE, "initial_body_rate": [0.0, 0.0, 0.0], "magnetic_field": [0.0] * 3},
    "no sensors": {"epoch_ns": 10**18, "motion": "closed_form", "rate": 10.0},
}
ALWAYS_SEEN = {
    *("initial_attitude_xyzw", "initial_body_rate", "rate", "world_frame", "body_frame", "stamped_twist", "epoch_ns"),
}
"""Parameters without which no message of the truth can be."""


QUICK = ("_burst_density", "gyro_temperature_drift", "_lever_arm", "gravity", "_orientation")
"""How the names end of those that are tried in every run: sizes that widened limits once."""
DIFFERENCE = ("gyro_rate", "integrated")
"""An integrated rate has the round-off of two attitudes in its limit, also of a body at rest, where it reads 0."""


def extremes(name: str) -> Iterator[Any]:
    """The smallest and the largest values, of an unlimited one far ones, that are not the default."""
    parameter = BY_NAME[name]
    if parameter.kind == "bool":
        yield not parameter.default
    elif parameter.kind == "string":
        yield from parameter.choices or ("elsewhere",)
    elif parameter.kind == "string_array":
        yield ["/elsewhere"]
    elif parameter.kind == "double_array":
        sizes = (0.0, 1.0, -1.0, 3.0, 1e3, 1e6)
        assert isinstance(parameter.default, tuple)
        yield from ([size] * length for size in sizes for length in parameter.lengths or (len(parameter.default),))
    else:
        for number in (max(parameter.minimum, -1e9), min(parameter.maximum, 1e9), 1e-3, 1.0):
            yield int(number) if parameter.kind == "int" else number


def simulated(parameters: dict[str, object], path: Path | None = None) -> str:
    """A digest of every message but the scenario's, which are written to a bag where there is a path."""
    simulation = Simulation(Scenario.from_parameters(parameters))
    batch = BatchEncoder(simulation.segment.scenario).encode(
        simulation.take_until(simulation.segment.start_ns + round(SECONDS * 1e9), 1000)
    )
    if path is not None:
        with BagWriter(path, stamped_twist=simulation.segment.scenario.stamped_twist) as bag:
            bag.begin_segment(simulation.segment)
            bag.write(batch)
    digest = hashlib.sha256()
    for time, topic, payload in batch.in_order():
        digest.update(f"{time} {topic}".encode() + bytes(payload))
    return digest.hexdigest()


def limits(parameters: dict[str, object], folder: Path) -> dict[str, list[float]]:
    """Every limit of every law that its certificate held against a number, sorted."""
    found: dict[str, list[float]] = {}

    class Limits(Watch):
        def __call__(self, name: str, unit: str, residuals: Array, limits: Any, stamps_ns: Integers) -> None:
            """Keep the limits."""
            found.setdefault(name, []).extend([limits] if isinstance(limits, float) else limits.tolist())

    path = folder / f"{len(list(folder.iterdir()))}.mcap"
    simulated(parameters, path)
    certificate = certify(Bag(path), watch=Limits())
    assert certificate.passed, certificate.messages
    return {**found, **{law.name: [law.limit] for law in certificate.whole}}


@pytest.fixture(scope="module")
def honest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    return cache(lambda base: (simulated(BASES[base]), limits(BASES[base], folder)))


@pytest.mark.parametrize(
    "name",
    [
        name if name.endswith(QUICK) else pytest.param(name, marks=pytest.mark.slow)
        for name in BY_NAME
        if name not in ALWAYS_SEEN
    ],
)
def test_a_parameter_without_effect_moves_no_limit(honest, tmp_path, name):
    idle = 0
    for base, parameters in BASES.items():
        digest, wanted = honest(base)
        for value in extremes(name):
            try:
                is_idle = value != parameters.get(name) and simulated({**parameters, name: value}) == digest
            except ParameterError:
                continue
            if is_idle and (name, value) != DIFFERENCE:
                idle += 1
                assert limits({**parameters, name: value}, tmp_path) == wanted, (base, value)
    assert idle
