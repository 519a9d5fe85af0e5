"""The specific force, against differences of where the moving point is in the world."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_models import BODY, MOTION, START, imu, imu_model, times

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.sensors import Imu

H_NS = 20_000_000
# second derivative, order 8
STENCIL = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
AT = np.arange(0, 40, dtype=np.int64) * 170_000_000 + 1_000_000_000
LEVER_ARMS = [[0.3, 0.0, 0.0], [0.0, -0.2, 0.0], [0.0, 0.0, 1.0], [0.1, -0.2, 0.05]]
UP = np.array([0.0, 0.0, 1.0])


def in_body(states: State, world: np.ndarray) -> np.ndarray:
    return Rotation.from_quat(states.attitude_xyzw).inv().apply(world)


def acceleration_by_differences(motion: ClosedForm, lever_arm: list[float]) -> np.ndarray:
    """Of the point at the lever arm, in the body frame at the times ``AT``."""
    world = np.zeros((len(AT), 3))
    for k, weight in zip(range(-4, 5), STENCIL, strict=True):
        world += weight * Rotation.from_quat(motion.at(AT + k * H_NS).attitude_xyzw).apply(lever_arm)
    return in_body(motion.at(AT), world / (H_NS * 1e-9) ** 2)


@pytest.mark.parametrize("lever_arm", LEVER_ARMS)
def test_it_is_the_acceleration_of_the_point(lever_arm: list[float]) -> None:
    read = imu(accelerometer_lever_arm=lever_arm).measure(AT, MOTION.at(AT))["specific_force"]
    assert np.abs(read).max() > 0.05
    assert np.abs(read - acceleration_by_differences(MOTION, lever_arm)).max() < 1e-10


@pytest.mark.parametrize("inertia", [[2.0, 2.0, 2.0], [1.0, 1.0, 2.0], [3.0, 1.0, 2.0], [1.0, 2.0, 3.0]])
def test_it_holds_for_every_kind_of_body(inertia: list[float]) -> None:

    body = RigidBody(inertia)
    motion = ClosedForm(body, START)
    sensor = Imu(imu_model(accelerometer_lever_arm=LEVER_ARMS[-1]), body)
    read = sensor.measure(AT, motion.at(AT))["specific_force"]
    assert np.abs(read - acceleration_by_differences(motion, LEVER_ARMS[-1])).max() < 1e-10


@pytest.mark.parametrize("lever_arm", [[0.0, 0.0, 0.0], LEVER_ARMS[-1]])
@pytest.mark.parametrize("gravity", [9.80665, 1.62])
def test_a_pivot_adds_the_weight_upwards(lever_arm: list[float], gravity: float) -> None:
    states = MOTION.at(AT)
    read = imu(accelerometer_lever_arm=lever_arm, accelerometer_mode="pivot_gravity", gravity=gravity)
    force = read.measure(AT, states)["specific_force"]
    expected = acceleration_by_differences(MOTION, lever_arm) + in_body(states, np.tile(gravity * UP, (len(AT), 1)))
    assert np.abs(force - expected).max() < 1e-10


def test_free_fall_at_the_mass_centre_reads_exactly_nothing() -> None:
    t = times(50)
    assert not imu(accelerometer_misalignment=[0.1, -0.2, 0.3]).measure(t, MOTION.at(t))["specific_force"].any()


def test_a_steady_spin_reads_the_centripetal_acceleration() -> None:
    """−Ω²r outside of the axis and nothing on it, about each principal axis."""
    for axis, other, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        rate, lever_arm = np.zeros((1, 3)), np.zeros(3)
        rate[0, axis], lever_arm[axis], lever_arm[other] = 3.0, 0.7, 0.5

        state = State([[0.0, 0.0, 0.0, 1.0]], rate)
        sensor = Imu(imu_model(accelerometer_lever_arm=lever_arm.tolist()), RigidBody([1.0, 2.0, 2.5]))
        force = sensor.measure(np.array([0]), state)["specific_force"][0]
        assert (force[axis], force[third]) == (0.0, 0.0)
        assert force[other] == pytest.approx(-9.0 * 0.5, rel=1e-15)


def test_the_body_of_these_tests_is_a_general_one() -> None:
    assert np.ptp(BODY.principal_moments) > 0.5
    assert np.abs(BODY.inertia - np.diag(np.diag(BODY.inertia))).max() > 0.1
