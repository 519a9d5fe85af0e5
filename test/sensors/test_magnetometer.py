"""The magnetometer reads the world's field on the body's axes, through soft iron, hard iron, noise, range and steps."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from reference_noise import normal, words
from scipy.spatial.transform import Rotation
from sensor_models import MOTION, at_rest, magnetometer, magnetometer_model, times

from lie_rigid_body.sensors.noise import NoiseSource

FIELD = [2e-5, -1e-5, 4e-5]
SOFT_IRON = [1.1, 0.02, 0.01, -0.03, 0.95, 0.04, 0.05, 0.02, 1.05]
HARD_IRON = [1e-6, 2e-6, -3e-6]
STATES = MOTION.at(times(100))
COUNT = 50_000


def on_body_axes(field: list[float]) -> np.ndarray:
    return Rotation.from_quat(STATES.attitude_xyzw).inv().apply(field)


def test_it_reads_the_world_field_on_body_axes() -> None:
    read = magnetometer(magnetic_field=FIELD).measure(times(100), STATES)["field"]
    assert np.abs(read - on_body_axes(FIELD)).max() < 1e-15 * np.linalg.norm(FIELD) * 10


def test_iron_distorts_first_and_adds_then() -> None:
    sensor = magnetometer(magnetic_field=FIELD, magnetometer_soft_iron=SOFT_IRON, magnetometer_hard_iron=HARD_IRON)
    expected = on_body_axes(FIELD) @ np.reshape(SOFT_IRON, (3, 3)).T + HARD_IRON
    assert np.abs(sensor.measure(times(100), STATES)["field"] - expected).max() < 1e-18


def test_the_default_field_is_that_of_the_north() -> None:
    """East, north, up: to the north, and steeply down, of some 50 µT."""
    east, north, up = magnetometer().measure(times(1), at_rest(1))["field"][0]
    assert abs(east) < north < -up
    assert 4e-5 < np.linalg.norm([east, north, up]) < 6e-5


def test_range_and_resolution_come_last() -> None:
    sensor = magnetometer(magnetic_field=FIELD, magnetometer_range=2.5e-5, magnetometer_resolution=1e-5)
    assert sensor.measure(times(1), at_rest(1))["field"][0] == pytest.approx([2e-5, -1e-5, 2e-5])


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_noise_is_the_density_times_the_root_of_the_rate(rate: float) -> None:
    settings = {"magnetometer_rate": rate, "magnetometer_noise_density": 2e-8, "magnetometer_resolution": 5e-8}
    errors = (
        magnetometer(**settings).measure(times(COUNT), at_rest(COUNT))["field"]
        - magnetometer().measure(times(1), at_rest(1))["field"]
    )
    assert np.abs(errors.var(axis=0) / (4e-16 * rate + 25e-16 / 12.0) - 1.0).max() < 10.0 / np.sqrt(COUNT)
    assert magnetometer_model(**settings).variance == pytest.approx(4e-16 * rate + 25e-16 / 12.0)
    assert magnetometer_model().variance == 0.0


def test_its_noise_has_deviates_of_its_own() -> None:
    settings = {"magnetic_field": [0.0, 0.0, 0.0], "magnetometer_noise_density": 0.1, "sensor_seed": 11}
    read = magnetometer(**settings).measure(times(5), at_rest(5))["field"]
    drawn = [float(normal(word)) for word in islice(words(11, NoiseSource.MAGNETOMETER_WHITE), 15)]
    assert read.ravel() == pytest.approx(drawn, rel=1e-14)
