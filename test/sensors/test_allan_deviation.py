"""Noise has the densities that were asked for, as the Allan deviation of another library sees it."""

from __future__ import annotations

import allantools
import numpy as np
import pytest
from sensor_models import readings_at_rest

from lie_rigid_body.sensors.allan import Allan, allan, density

COUNT = 2**18
RATE = 200.0
STRIDES = np.array([20, 60, 200, 600, 2000])
TAUS = STRIDES / RATE
# of an overlapping deviation, three axes together, with about COUNT/stride independent pairs each
FIVE_SIGMA = 5.0 / np.sqrt(2.0 * 3.0 * COUNT / STRIDES)
RNG = np.random.default_rng(5)
READINGS = {"gyro": "gyro", "accelerometer": "specific_force"}


def allan_deviation(values: np.ndarray) -> np.ndarray:
    """Over all three axes, at the times of this file."""
    deviations = [allantools.oadev(axis, rate=RATE, data_type="freq", taus=TAUS)[1] for axis in values.T]
    return np.sqrt(np.mean(np.square(deviations), axis=0))


def readings(sensor: str, **given: object) -> np.ndarray:
    return readings_at_rest(COUNT, imu_rate=RATE, sensor_seed=5, **given)[READINGS[sensor]]


@pytest.mark.parametrize("sensor", READINGS)
def test_both_together_add_as_variances(sensor: str) -> None:
    density, walk = 1e-3, 2e-3
    given = {f"{sensor}_noise_density": density, f"{sensor}_bias_random_walk": walk, f"{sensor}_turn_on_bias": 1.0}
    found = allan_deviation(readings(sensor, **given))
    assert np.all(np.abs(found / np.sqrt(density**2 / TAUS + walk**2 * TAUS / 3.0) - 1.0) < FIVE_SIGMA)


def test_the_allan_variance_is_that_of_allantools() -> None:
    readings = RNG.normal(size=(4000, 1)) + np.cumsum(RNG.normal(size=(4000, 1)), axis=0) * 0.01
    found = allan(readings, 0.01)
    tau, deviation, *_ = allantools.oadev(readings[:, 0], rate=100.0, data_type="freq", taus=found.tau_s)
    assert np.allclose(tau, found.tau_s)
    assert np.allclose(np.sqrt(found.variance), deviation, rtol=1e-9)


def test_densities_are_those_put_in_within_their_standard_errors() -> None:
    """At most a tenth of sixty logs is off by more than two standard errors; a twentieth would be normal."""
    white, walk = 0.02, 0.004
    off = []
    for _ in range(60):
        steps = RNG.normal(size=(6000, 3))
        readings = white * 10.0 * RNG.normal(size=(6000, 3)) + np.cumsum(walk * 0.1 * steps, axis=0)
        found = density(allan(readings, 0.01))
        off.append(abs(found.white - white) > 2.0 * found.white_sigma)
    assert np.mean(off) <= 0.1


def test_a_variance_that_falls_faster_than_white_noise_tells_no_walk() -> None:
    """A log in which the least squares has no smallest walk; white noise by weighted least squares alone."""
    tau_s = np.ldexp(0.16, np.arange(6))
    variance = np.array([2.1985e-08, 1.1292e-08, 5.9577e-09, 2.7320e-09, 1.1389e-09, 7.7541e-10])
    freedom = np.array([1119.0, 556.5, 275.25, 134.625, 64.3125, 29.15625])
    found = density(Allan(tau_s, variance, freedom))
    alone = np.exp(0.5 * np.average(np.log(variance * tau_s), weights=freedom))
    assert (found.walk, found.walk_sigma) == (0.0, 0.0)
    assert found.white == pytest.approx(alone, abs=found.white_sigma)
    assert 0.01 < found.white_sigma / found.white < 0.05
