"""Triads: what a gyro and an accelerometer read, and what each error of theirs adds."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_noise import normal, words
from scipy.spatial.transform import Rotation
from sensor_models import BODY, MOTION, START, at_rest, imu, imu_model, magnetometer, readings_at_rest, times

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.sensors import Imu
from lie_rigid_body.sensors.noise import NoiseSource
from lie_rigid_body.sensors.sensor import Carrier
from lie_rigid_body.sensors.signal import Converter

COUNT = 50_000
FIVE_SIGMA = 5.0 / np.sqrt(COUNT)
SENSORS = ["gyro", "accelerometer"]
PERIOD_NS = 10_000_000


def gyro_reads(rates: object, **given: object) -> np.ndarray:
    rate = np.array(rates, dtype=float)
    t = np.arange(len(rate), dtype=np.int64) * PERIOD_NS
    states = State(np.tile([0.0, 0.0, 0.0, 1.0], (len(rate), 1)), rate)
    return Imu(imu_model(**given), Carrier(BODY)).measure(t, states)["gyro"]


def accelerometer_reads(up_in_body: object, **given: object) -> np.ndarray:
    """At rest on the pivot, tilted so that the world's z lies along a vector of the body."""
    up = np.array(up_in_body, dtype=float)
    tilt = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up / np.linalg.norm(up)])[0].as_quat()
    states = State(tilt[np.newaxis], np.zeros((1, 3)))
    model = imu_model(accelerometer_mode="pivot_gravity", gravity=float(np.linalg.norm(up)), **given)
    return Imu(model, Carrier(BODY)).measure(np.array([0]), states)["specific_force"][0]


def reading(sensor: str, truth: list[float], **given: object) -> np.ndarray:
    named = {f"{sensor}_{key}": value for key, value in given.items()}
    return gyro_reads([truth], **named)[0] if sensor == "gyro" else accelerometer_reads(truth, **named)


MOUNTING, SCALE = [0.1, -0.2, 0.3], np.array([1.1, 0.9, 1.2])


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize(
    ("truth", "errors", "read"),
    [
        ([0.3, -0.4, 0.5], {}, [0.3, -0.4, 0.5]),
        ([0.3, -0.4, 0.5], {"scale_factor": [2.0, 0.5, -1.0]}, [0.6, -0.2, -0.5]),
        # a sensor turned by +90° about z has its x along the body's y
        ([0.3, -0.4, 0.5], {"misalignment": [0.0, 0.0, np.pi / 2.0]}, [-0.4, -0.3, 0.5]),
        (  # the scale belongs to the turned axes
            [0.3, -0.4, 0.5],
            {"misalignment": MOUNTING, "scale_factor": SCALE.tolist()},
            SCALE * Rotation.from_rotvec(MOUNTING).inv().apply([0.3, -0.4, 0.5]),
        ),
        ([3.0, -4.0, 0.5], {"range": 1.0}, [1.0, -1.0, 0.5]),
        ([0.26, -0.24, 0.61], {"resolution": 0.25}, [0.25, -0.25, 0.5]),
    ],
)
def test_each_error_does_what_it_says(sensor: str, truth: list[float], errors: dict[str, object], read: object) -> None:
    assert reading(sensor, truth, **errors) == pytest.approx(read, rel=1e-14)


def test_rounding_of_halves_goes_to_the_even_step() -> None:
    assert gyro_reads([[0.125, 0.375, -0.125]], gyro_resolution=0.25)[0].tolist() == [0.0, 0.5, 0.0]


@given(st.floats(1e-6, 1e6), st.integers(1, 10**6), st.integers(0, 10**6))
def test_no_reading_leaves_the_range_and_the_last_step_within_it_is_read(limit: float, parts: int, more: int) -> None:
    """The range need be no multiple of the resolution."""
    converter = Converter(limit / (parts + more / (10**6 + 1)), limit)
    values = limit * np.array([0.0, 0.3, 0.499, 0.7, 0.95, 1.0, 1.3, 1e9])
    read = converter.read(values)
    assert np.all(np.abs(read) <= limit)
    assert converter.read(-values).tolist() == (-read).tolist()
    assert converter.read(read).tolist() == read.tolist()
    steps = np.minimum(np.rint(values / converter.resolution), np.floor(limit / converter.resolution * (1.0 + 1e-15)))
    assert read == pytest.approx(steps * converter.resolution, rel=1e-15)


@pytest.mark.parametrize(("limit", "step"), [(0.3, 0.1), (0.7, 0.1), (2000.0 * np.pi / 180.0, np.pi / 180.0 / 16.384)])
def test_the_range_is_read_where_it_is_a_multiple_but_for_round_off(limit: float, step: float) -> None:
    assert Converter(step, limit).read(np.array([9e9, -9e9])) == pytest.approx([limit, -limit], rel=1e-15)


def test_a_signal_of_any_size_saturates() -> None:
    """Also one with more steps than floating point has room for."""
    with np.errstate(all="raise"):
        assert Converter(1e-18, 10.0).read(np.array([1e300, -1e300])) == pytest.approx([10.0, -10.0])


def test_noise_comes_before_range() -> None:
    noisy = gyro_reads(np.full((2000, 3), 0.99), gyro_range=1.0, gyro_noise_density=0.1)
    assert noisy.max() == 1.0
    assert 0.4 < (noisy == 1.0).mean() < 0.6


def test_noise_comes_before_resolution() -> None:
    """A signal of a quarter step is the mean of its rounded readings, as noise carries it across the steps."""
    read = gyro_reads(np.full((COUNT, 3), 0.025), gyro_resolution=0.1, gyro_noise_density=0.01)
    assert np.all(np.abs(np.rint(read / 0.1) * 0.1 - read) < 1e-15)
    assert np.abs(read.mean(axis=0) - 0.025).max() < FIVE_SIGMA * np.hypot(0.1, 0.1 / np.sqrt(12.0))


@pytest.mark.parametrize("sensor", SENSORS)
def test_noise_is_not_scaled(sensor: str) -> None:
    plain = readings_at_rest(100, **{f"{sensor}_noise_density": 0.1})
    scaled = readings_at_rest(100, **{f"{sensor}_noise_density": 0.1, f"{sensor}_scale_factor": [2.0, 3.0, 4.0]})
    assert plain["gyro"].tolist() == scaled["gyro"].tolist()
    assert plain["specific_force"].tolist() == scaled["specific_force"].tolist()


@pytest.mark.parametrize("sensor", SENSORS)
def test_the_true_bias_is_what_the_reading_has_more_than_the_truth(sensor: str) -> None:
    read = readings_at_rest(1000, **{f"{sensor}_bias_random_walk": 0.1, f"{sensor}_turn_on_bias": 1.0})
    pairs = {
        "gyro": (read["gyro"], read["gyro_bias"]),
        "accelerometer": (read["specific_force"], read["accelerometer_bias"]),
    }
    values, bias = pairs.pop(sensor)
    assert values.tolist() == bias.tolist()
    assert np.abs(bias).min() > 0.0
    assert not np.any(pairs.popitem()[1])


def test_the_variance_that_is_told_is_that_of_the_readings() -> None:
    given = {"gyro_noise_density": 2e-3, "gyro_resolution": 0.04, "accelerometer_noise_density": 0.02}
    model = imu_model(**given)
    still = at_rest(COUNT)
    turning = State(still.attitude_xyzw, np.linspace(0.0, 100.0, 3 * COUNT).reshape(-1, 3))
    t = np.arange(COUNT, dtype=np.int64) * PERIOD_NS
    read = Imu(model, Carrier(RigidBody([1.0, 1.0, 1.0]))).measure(t, turning)
    errors = read["gyro"] - turning.body_rate
    assert np.abs(errors.var(axis=0) / model.gyro.variance(model.rate) - 1.0).max() < 2.0 * FIVE_SIGMA
    variances = read["specific_force"].var(axis=0)
    assert np.abs(variances / model.accelerometer.variance(model.rate) - 1.0).max() < 2.0 * FIVE_SIGMA
    assert imu_model().gyro.variance(100.0) == imu_model().accelerometer.variance(100.0) == 0.0  # not known


@pytest.mark.parametrize(
    ("parameter", "source"),
    [
        ("gyro_turn_on_bias", NoiseSource.GYRO_TURN_ON),
        ("gyro_bias_random_walk", NoiseSource.GYRO_WALK),
        ("gyro_noise_density", NoiseSource.GYRO_WHITE),
        ("accelerometer_turn_on_bias", NoiseSource.ACCELEROMETER_TURN_ON),
        ("accelerometer_bias_random_walk", NoiseSource.ACCELEROMETER_WALK),
        ("accelerometer_noise_density", NoiseSource.ACCELEROMETER_WHITE),
        ("magnetometer_noise_density", NoiseSource.MAGNETOMETER_WHITE),
    ],
)
def test_every_error_has_deviates_of_its_own(parameter: str, source: NoiseSource) -> None:
    given = {"sensor_seed": 11, parameter: 0.5}
    read = readings_at_rest(5, imu_rate=4.0, **given)
    read |= magnetometer(magnetometer_rate=4.0, magnetic_field=[0.0] * 3, **given).measure(times(5), at_rest(5))
    names = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
    values = read[names[parameter.partition("_")[0]]]
    drawn = np.array([float(normal(word)) for word in islice(words(11, source), 15)]).reshape(5, 3)
    if parameter.endswith("turn_on_bias"):
        expected = np.tile(0.5 * drawn[0], (5, 1))
    elif parameter.endswith("walk"):  # the walk times the root of the interval
        expected = np.concatenate([np.zeros((1, 3)), np.cumsum(0.25 * drawn[:-1], axis=0)])
    else:  # the density times the root of the rate
        expected = 1.0 * drawn
    assert np.abs(values - expected).max() < 1e-14


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
@pytest.mark.parametrize("inertia", [BODY.inertia, [2.0, 2.0, 2.0], [1.0, 1.0, 2.0], [3.0, 1.0, 2.0], [1.0, 2.0, 3.0]])
def test_it_is_the_acceleration_of_the_point(inertia: list[float], lever_arm: list[float]) -> None:
    body = RigidBody(inertia)
    motion = ClosedForm(body, START)
    sensor = Imu(imu_model(accelerometer_lever_arm=lever_arm), Carrier(body))
    read = sensor.measure(AT, motion.at(AT))["specific_force"]
    assert np.abs(read).max() > 0.02
    assert np.abs(read - acceleration_by_differences(motion, lever_arm)).max() < 1e-10


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
        sensor = Imu(imu_model(accelerometer_lever_arm=lever_arm.tolist()), Carrier(RigidBody([1.0, 2.0, 2.5])))
        force = sensor.measure(np.array([0]), state)["specific_force"][0]
        assert (force[axis], force[third]) == (0.0, 0.0)
        assert force[other] == pytest.approx(-9.0 * 0.5, rel=1e-15)
