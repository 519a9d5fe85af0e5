"""Calls of Python as one guesses them: bodies and starts, times in seconds, runs as truths, bags by their names."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import lie_rigid_body
from lie_rigid_body import (
    BagError,
    ClosedForm,
    InputError,
    Limits,
    ParameterError,
    RigidBody,
    Scenario,
    State,
    certify,
    evaluate,
    simulate,
)

BODY = RigidBody([[2.0, 0.1, -0.2], [0.1, 2.5, 0.3], [-0.2, 0.3, 3.0]])
START = State([0.1, -0.2, 0.3, np.sqrt(1.0 - 0.14)], [0.4, -0.3, 0.2])


def test_a_body_and_a_start_are_simulated():
    run = simulate(BODY, START, duration=2.0, imu_rate=50.0, motion="closed_form")
    states = ClosedForm(BODY, START).at(run.t_ns - run.t_ns[0])
    np.testing.assert_allclose(run.truth.attitude_xyzw, states.attitude_xyzw, atol=1e-14)
    np.testing.assert_allclose(run.truth.body_rate, states.body_rate, atol=1e-14)
    assert run.imu is not None
    np.testing.assert_allclose(run.t_s * 1e9, run.t_ns, rtol=1e-15)
    np.testing.assert_allclose(run.imu.t_s * 1e9, run.imu.t_ns, rtol=1e-15)
    assert len(simulate(duration=0.5).t_ns) == 50
    assert simulate("tumbling_cubesat", START, duration=0.1).truth.body_rate[0] == pytest.approx(START.body_rate)


@pytest.mark.parametrize(
    "arguments",
    [
        (RigidBody.from_principal_moments([[1.0, 2.0, 3.0], [1.0, 1.5, 2.0]]), START),
        (BODY, State([START.attitude_xyzw] * 2, [START.body_rate] * 2)),
        (BODY, [0.0, 0.0, 1.0]),
    ],
)
def test_many_bodies_and_what_is_no_start_are_refused(arguments):
    with pytest.raises(InputError):
        simulate(*arguments, duration=1.0)


def test_a_scenario_takes_parameters_by_their_names():
    scenario = Scenario(inertia=np.array([1.0, 2.0, 2.5]), rate=200, imu_rate=50.0)
    assert scenario == Scenario.from_parameters({"inertia": [1.0, 2.0, 2.5], "rate": 200.0, "imu_rate": 50.0})
    assert Scenario() == Scenario.from_parameters()
    assert scenario.sensors.imu is not None
    with pytest.raises(ParameterError, match="did you mean inertia"):
        Scenario(inertai=[1.0, 2.0, 2.5])
    with pytest.raises(ParameterError, match="triangle"):
        Scenario(inertia=[1.0, 1.0, 3.0])
    later = scenario.resampled(epoch_ns=7)
    assert later == Scenario(inertia=[1.0, 2.0, 2.5], rate=200.0, imu_rate=50.0, epoch_ns=7)
    assert scenario.epoch_ns == 0


def test_a_run_is_the_truth():
    run = simulate("tumbling_cubesat", duration=2.0)
    attitude = run.truth.attitude_xyzw
    score = evaluate(run.t_ns, attitude, run, limits=Limits.parse("1deg"))
    assert score.passed
    assert score.total_deg.rms < 1e-12
    with pytest.raises(InputError, match="give the run"):
        evaluate(run.t_ns, attitude, run.truth)  # type: ignore[arg-type]


def test_a_bag_is_certified_by_its_name(tmp_path):
    run = simulate("tumbling_cubesat", duration=1.0)
    run.to_bag(tmp_path / "run.mcap")
    assert certify(str(tmp_path / "run.mcap")).passed
    assert certify(tmp_path / "run.mcap").passed
    with pytest.raises(BagError):
        certify(tmp_path / "none.mcap")


def test_public_names_are_loaded_when_they_are_used():
    code = "import lie_rigid_body, sys; print(sorted(set(sys.modules) & {'numpy', 'scipy', 'dask', 'matplotlib'}))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
    assert all(getattr(lie_rigid_body, name) is not None for name in lie_rigid_body.__all__)
