"""The limits bound what every stepper errs, near the separatrix as well, and are not much wider than that."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import simulate
from lie_rigid_body.certificate.tolerance import ATTITUDE_CAP, tolerance
from lie_rigid_body.motion import METHODS
from lie_rigid_body.scenario import Scenario
from stepper_bounds import DURATIONS, MOTIONS, STEPS, Run, runs

SAMPLE = ("dzhanibekov", "separatrix, 1e-6", "about the equator", "nearly spherical", "slow", "products of inertia")


def require_bounds(several: list[Run]) -> None:
    found = {run: run.ratios() for run in several}
    beyond = {(run, name): two.worst for run, ratios in found.items() for name, two in ratios.items() if two.worst >= 1}
    assert beyond == {}
    late = [two.late for ratios in found.values() for two in ratios.values()]
    assert np.median(late) > 1e-3


@pytest.mark.parametrize("method", ["rkmk1", "rkmk2", "rkmk4", "dmv4", "dmv20"])
def test_errors_of_a_minute_stay_below_their_limits(method: str) -> None:
    require_bounds([Run(motion, method, 100.0, 0.01, 60.0) for motion in SAMPLE])


@pytest.mark.parametrize(("motion", "rate"), [("dzhanibekov", 100.0), ("separatrix, 1e-2", 70.0)])
def test_errors_of_short_steps_stay_below_their_limits(motion: str, rate: float) -> None:
    """Steps of a millisecond: here a bound that only adds up errors of the rate is passed."""
    require_bounds([Run(motion, "rkmk4", rate, 1e-3, 60.0)])


@pytest.mark.parametrize("method", ["rkmk1", "rkmk2", "rkmk4"])
@pytest.mark.parametrize(
    ("inertia", "rate"),
    [
        ([1.0, 2.0, 3.0], [0.001, 0.0, 0.0]),
        ([1.0, 2.0, 3.0], [0.0, 0.03, 0.0]),
        ([2.0, 2.0, 2.0], [0.0, 0.033, 0.0]),
        ([1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [0.0, 1e-5, 0.0]),
    ],
)
def test_slow_steps_whose_roundings_are_alike_stay_below_their_limits(
    method: str, inertia: list[float], rate: list[float]
) -> None:
    attitude = [0.48, 0.6, 0.0, 0.64]
    given = {"inertia": inertia, "initial_body_rate": rate, "initial_attitude_xyzw": attitude, "method": method}
    run = simulate(Scenario.from_parameters({**given, "rate": 10.0, "max_step": 5e-4}), duration=60.0)
    assert run.certificate().passed


@pytest.mark.parametrize(("imu_rate", "gyro_rate"), [(100.0, "instantaneous"), (200.0, "integrated")])
def test_a_gyro_of_runge_kutta_steps_near_the_separatrix_is_certified(imu_rate: float, gyro_rate: str) -> None:
    run = simulate("dzhanibekov", duration=60.0, method="rkmk4", imu_rate=imu_rate, gyro_rate=gyro_rate)
    assert run.certificate().passed


def test_an_integrated_gyro_has_no_wider_limit_than_an_instantaneous_one():
    """Near the separatrix errors of the rate are capped: those of its mean as well, whatever the interval."""
    scenario = Run("separatrix, 1e-4", "rkmk4", 100.0, 1e-3, 60.0).scenario()
    limits, t = tolerance(scenario, 60.0), np.array([60.0])
    assert limits.stepper_rate(t) == limits.fastest * ATTITUDE_CAP
    assert limits.stepper_mean_rate(t, 0.01) < 1.05 * limits.stepper_rate(t)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_stepper_keeps_to_its_limits(method: str) -> None:
    several = list(runs([method]))
    assert {run.motion for run in several} == set(MOTIONS)
    assert {run.duration for run in several} <= set(DURATIONS)
    assert {(run.rate, run.max_step) for run in several} == set(STEPS)
    require_bounds(several)
