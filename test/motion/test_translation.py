"""Motion of the mass centre against sums of harmonics in 50 digits, and the specific force that follows from it."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest

from lie_rigid_body import simulate
from lie_rigid_body.lie import quaternion
from lie_rigid_body.scenario import Scenario

DAY_NS = 86_400 * 10**9
BAND = (0.3, 2.0)
RESTS = [1.0, 0.0, 0.0, 0.0, 1.3, 0.0, 2.0, 0.0, 1.35, 0.0, 0.0, 0.0, 3.0, 1.0, 0.5, 0.0, 4.0, 0.0, 0.0, 0.0]
CARRIED: dict[str, Any] = {
    "translation": "carried",
    "sway_acceleration": [1.0, 2.0, 0.5],
    "sway_band": BAND,
    "initial_position": [1.0, -2.0, 0.5],
    "initial_velocity": [0.1, 0.0, -0.2],
}


def own_time(scenario: Scenario, t_ns: int) -> tuple[Any, Any, Any]:
    """θ, θ′ and θ″ of the sway by the sum over all changes between rest and motion, in 50 digits."""
    t = mp.mpf(t_ns) / 10**9
    ramp = 1 / (mp.pi * mp.sqrt(mp.mpf(BAND[0]) * mp.mpf(BAND[1])))
    moves = any(scenario.initial_body_rate)
    time, pace, change = (t, mp.mpf(1), mp.mpf(0)) if moves else (mp.mpf(0), mp.mpf(0), mp.mpf(0))
    times, rates = scenario.kick_schedule().until(t_ns)
    for kick_ns, rate in zip(times.tolist(), rates, strict=True):
        if bool(rate.any()) != moves:
            moves = not moves
            x = (t - mp.mpf(kick_ns) / 10**9) / ramp
            sign = 1 if moves else -1
            y = min(x, mp.mpf(1))
            time += sign * ramp * (y**4 * (mp.mpf(5) / 2 - 3 * y + y * y) + max(x - 1, mp.mpf(0)))
            pace += sign * y**3 * (10 - 15 * y + 6 * y * y)
            change += sign * (30 * y * y * (1 - y) ** 2 / ramp if x < 1 else 0)
    return time, pace, change


def carried(scenario: Scenario, t_ns: int) -> np.ndarray:
    """Position, velocity and acceleration in 50 digits, rounded; shape (3, 3)."""
    sway = scenario.sway()
    assert sway is not None
    time, pace, change = own_time(scenario, t_ns)
    found = np.empty((3, 3))
    for axis in range(3):
        position, velocity, acceleration = mp.mpf(0), mp.mpf(0), mp.mpf(0)
        for f, a, p in np.stack([sway.frequency_hz[axis], sway.amplitude[axis], sway.phase[axis]], axis=1).tolist():
            omega = 2 * mp.pi * mp.mpf(f)
            position += a / omega**2 * (mp.cos(p) - mp.cos(omega * time + p))
            velocity += a / omega * mp.sin(omega * time + p)
            acceleration += a * mp.cos(omega * time + p)
        x0, v0 = scenario.initial_position[axis], scenario.initial_velocity[axis]
        found[:, axis] = (
            x0 + mp.mpf(v0) * t_ns / 10**9 + position,
            v0 + velocity * pace,
            acceleration * pace**2 + velocity * change,
        )
    return found


@pytest.mark.parametrize("at_rest", [False, True])
@pytest.mark.parametrize("kicks", [[], RESTS])
def test_a_carried_mass_centre_is_that_of_its_harmonics(kicks: list[float], at_rest: bool) -> None:
    start = [0.0, 0.0, 0.0] if at_rest else [0.1, 0.2, 0.3]
    scenario = Scenario(**CARRIED, kicks=kicks, kick_period=6.0, initial_body_rate=start)
    t_ns = np.array([0, 1_100_000_000, 1_320_000_000, 1_360_000_000, 2_500_000_000, 3_200_000_000, 9_100_000_001])
    found = scenario.mass_centre().at(t_ns)
    with mp.workdps(50):
        true = np.array([carried(scenario, t) for t in t_ns.tolist()])
    for given, expected in zip((found.position, found.velocity, found.acceleration), true.swapaxes(0, 1), strict=True):
        np.testing.assert_allclose(given, expected, rtol=0, atol=2e-15)


def test_accelerations_are_right_after_ten_days() -> None:
    scenario = Scenario(**CARRIED)
    t_ns = np.array([10 * DAY_NS + 123_456_789, 200 * 365 * DAY_NS])
    found = scenario.mass_centre().at(t_ns)
    with mp.workdps(50):
        true = np.array([carried(scenario, t) for t in t_ns.tolist()])
    np.testing.assert_allclose(found.acceleration, true[:, 2], rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.position, true[:, 0], rtol=1e-15)


def test_rests_do_not_move() -> None:
    scenario = Scenario(**{**CARRIED, "initial_velocity": [0.0] * 3}, kicks=[1.0, 0.0, 0.0, 0.0, 60.0, 1.0, 0.0, 0.0])
    resting = scenario.mass_centre().at(np.arange(2 * 10**9, 60 * 10**9, 10**8))
    assert (resting.position == resting.position[0]).all()
    assert not resting.velocity.any()
    assert not resting.acceleration.any()


def test_harmonics_are_those_that_are_asked_for() -> None:
    sway = Scenario(**CARRIED, sway_seed=3).sway()
    assert sway is not None
    assert sway.frequency_hz.shape == (3, 16)
    assert sway.frequency_hz.min() >= BAND[0]
    assert sway.frequency_hz.max() <= BAND[1]
    assert (sway.frequency_hz * 2**20 % 1 == 0).all()
    np.testing.assert_allclose(np.sqrt(0.5 * (sway.amplitude**2).sum(axis=1)), [1.0, 2.0, 0.5], rtol=1e-15)
    other = Scenario(**CARRIED, sway_seed=4).sway()
    assert other is not None
    assert (sway.frequency_hz != other.frequency_hz).all()
    mass_centre = Scenario(**CARRIED, sway_seed=3).mass_centre()
    rms = np.sqrt((mass_centre.at(np.arange(0, 3600 * 10**9, 10**8)).acceleration ** 2).mean(axis=0))
    np.testing.assert_allclose(rms, [1.0, 2.0, 0.5], rtol=0.02)


def test_a_thrown_mass_centre_falls() -> None:
    run: Any = simulate(
        duration=2.0, translation="thrown", initial_velocity=[1.0, 0.0, 3.0], gravity=3.7, imu_rate=100.0
    )
    t = run.t_s[:, np.newaxis]
    np.testing.assert_allclose(run.position, t * [1.0, 0.0, 3.0] - 0.5 * 3.7 * t**2 * [0, 0, 1], rtol=0, atol=1e-14)
    np.testing.assert_allclose(run.velocity, [1.0, 0.0, 3.0] - 3.7 * t * [0, 0, 1], rtol=0, atol=1e-14)
    assert (run.acceleration == [0.0, 0.0, -3.7]).all()
    assert run.scenario.parameters()["gravity"] == 3.7
    assert "gravity" in simulate(duration=1.0, translation="thrown").scenario.parameters()


@pytest.mark.parametrize("mode", ["free_fall", "pivot_gravity"])
@pytest.mark.parametrize("translation", ["none", "thrown", "carried"])
def test_the_specific_force_is_that_of_the_table(translation: str, mode: str) -> None:
    run: Any = simulate(
        duration=3.0,
        translation=translation,
        sway_acceleration=[1.0, 1.0, 1.0] if translation == "carried" else [0.0] * 3,
        accelerometer_mode=mode,
        imu_rate=100.0,
        kicks=[1.0, 0.0, 0.0, 2.0],
        gyro_rate="integrated",
    )
    support = 9.80665 if mode == "pivot_gravity" and translation != "thrown" else 0.0
    force = np.tile([0.0, 0.0, support], (len(run.t_ns), 1))
    if translation == "carried":
        force = force + run.acceleration
    expected = quaternion.rotate(quaternion.conjugate(run.truth.attitude_xyzw), force)
    np.testing.assert_allclose(run.imu.specific_force, expected, rtol=0, atol=2e-14)


def test_a_lever_arm_feels_what_is_left_of_the_path_of_its_point() -> None:
    """Second differences of the position of the point, in the world, less gravitation."""
    arm = np.array([0.2, -0.1, 0.3])
    run: Any = simulate(
        duration=2.0,
        rate=1000.0,
        imu_rate=1000.0,
        translation="carried",
        sway_acceleration=[2.0, 1.0, 3.0],
        accelerometer_lever_arm=arm,
        initial_body_rate=[1.0, -2.0, 0.5],
        motion="closed_form",
    )
    point = run.position + quaternion.rotate(run.truth.attitude_xyzw, arm)
    acceleration = np.diff(point, 2, axis=0) / 1e-6
    read = quaternion.rotate(run.truth.attitude_xyzw, run.imu.specific_force)[1:-1] - [0.0, 0.0, 9.80665]
    np.testing.assert_allclose(read, acceleration, rtol=0, atol=5e-5)


def test_vibration_is_on_the_axes_of_the_accelerometer_alone() -> None:
    given: dict[str, Any] = {"duration": 5.0, "imu_rate": 1000.0, "kicks": [2.0, 0.0, 0.0, 0.0], "sensor_seed": 5}
    still: Any = simulate(**given)
    shaken: Any = simulate(**given, vibration_acceleration=[1.0, 0.0, 2.0])
    assert shaken.vibration is not None
    assert still.vibration is None
    added = shaken.imu.specific_force - still.imu.specific_force
    t = still.imu.t_s[:, np.newaxis]
    harmonics = zip(shaken.vibration.frequency_hz, shaken.vibration.amplitude, shaken.vibration.phase, strict=True)
    expected = [(a * np.cos(2 * np.pi * f * t + p)).sum(axis=1) for f, a, p in harmonics]
    np.testing.assert_allclose(added, np.transpose(expected), rtol=0, atol=1e-11)
    assert (shaken.imu.gyro == still.imu.gyro).all()
    assert (shaken.position == still.position).all()
    assert (shaken.truth.attitude_xyzw == still.truth.attitude_xyzw).all()
