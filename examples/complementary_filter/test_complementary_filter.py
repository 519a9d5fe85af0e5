"""The filter against exact truth: on sensors of each grade, on motions that nobody chose, and when it is misused."""

import numpy as np
import pytest
from complementary_filter import estimate
from hypothesis import given, settings

from lie_rigid_body import simulate
from lie_rigid_body.testing import assert_attitude
from lie_rigid_body.testing.strategies import scenarios

LIMITS_DEG = {"perfect": 1e-9, "navigation": 0.5, "tactical": 0.5, "mems": 5.0}
RATES = {"imu_rate": 25.0, "magnetometer_rate": 25.0}
BENCH = {"accelerometer_mode": "pivot_gravity", "gyro_rate": "integrated"}


def filtered(run):
    world_field = run.scenario.sensors.magnetometer.field
    return estimate(run.imu.t_ns, run.imu.gyro, run.imu.specific_force, run.magnetometer.field, world_field)


@pytest.mark.attitude_run(scenarios=["tumbling_cubesat", "prolate_top"], duration=40.0, **RATES)
def test_it_converges(attitude_run):
    limit = LIMITS_DEG[attitude_run.scenario.sensor_grade]
    assert_attitude(filtered(attitude_run), attitude_run, max_rms_deg=limit, after_s=30.0)


@given(scenarios(grades=["perfect"], **RATES, **BENCH))
@settings(max_examples=10, deadline=None)
def test_perfect_sensors_leave_no_error(scenario):
    run = simulate(scenario, duration=1.0)
    assert_attitude(filtered(run), run, max_after="0s:1e-6deg")


@pytest.mark.attitude_run(scenarios=["prolate_top"], grades=["tactical"], duration=10.0)
def test_a_mistaken_convention_is_told(attitude_run):
    scalar_first = np.roll(filtered(attitude_run), 1, axis=1)
    with pytest.raises(AssertionError, match="scalar_first: The quaternion comes scalar first"):
        assert_attitude(scalar_first, attitude_run, max_rms_deg=1.0)
