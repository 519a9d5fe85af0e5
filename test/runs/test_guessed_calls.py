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
    Estimate,
    MovingChart,
    RigidBody,
    Run,
    SampledTruth,
    Scenario,
    State,
    attitude_error,
    certify,
)
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs import SensorArrays
from lie_rigid_body.sensors import SENSORS
from untyped import evaluate, simulate

BODY = RigidBody([[2.0, 0.1, -0.2], [0.1, 2.5, 0.3], [-0.2, 0.3, 3.0]])
START = State([0.1, -0.2, 0.3, np.sqrt(1.0 - 0.14)], [0.4, -0.3, 0.2])


def test_a_body_and_a_start_are_simulated():
    run = simulate(BODY, START, duration=2.0, imu_rate=50.0, motion="closed_form")
    states = ClosedForm(BODY, START).at(run.t_ns - run.t_ns[0])
    np.testing.assert_allclose(run.truth.attitude_xyzw, states.attitude_xyzw, atol=1e-14)
    np.testing.assert_allclose(run.truth.body_rate, states.body_rate, atol=1e-14)
    np.testing.assert_allclose(run.t_s * 1e9, run.t_ns, rtol=1e-15)
    np.testing.assert_allclose(run.imu.t_s * 1e9, run.imu.t_ns, rtol=1e-15)
    assert len(simulate(duration=0.5).t_ns) == 50
    assert simulate("tumbling_cubesat", START, duration=0.1).truth.body_rate[0] == pytest.approx(START.body_rate)


def test_a_scenario_takes_parameters_by_their_names():
    scenario = Scenario(inertia=np.array([1.0, 2.0, 2.5]), rate=200, imu_rate=50.0)
    assert scenario == Scenario.from_parameters({"inertia": [1.0, 2.0, 2.5], "rate": 200.0, "imu_rate": 50.0})
    assert Scenario() == Scenario.from_parameters()
    later = scenario.resampled(epoch_ns=7)
    assert later == Scenario(inertia=[1.0, 2.0, 2.5], rate=200.0, imu_rate=50.0, epoch_ns=7)
    assert scenario.epoch_ns == 0


def test_a_run_as_the_truth_tells_what_its_sensors_leave():
    """A turn of the heading that declared hard iron explains is no mistake, by either call."""
    run = simulate(duration=4.0, imu_rate=20.0, magnetometer_rate=20.0, sensor_grade="mems")
    turned = quaternion.multiply(quaternion.exp(np.array([0.0, 0.0, np.radians(5.0)])), run.truth.attitude_xyzw)
    own, guessed = run.score(turned, run.t_ns), evaluate(run.t_ns, turned, run)
    assert own.findings == guessed.findings == ()
    assert own.to_dict(series=True) == guessed.to_dict(series=True)
    assert [found.code for found in evaluate(run.t_ns, turned, run.attitude()).findings] == ["heading_offset"]


def test_what_an_estimator_returns_is_scored_against_a_run():
    run = simulate("tumbling_cubesat", duration=1.0, imu_rate=100.0)
    P, own = np.eye(3) * 1e-4, "body"
    estimate = Estimate(run.truth.attitude_xyzw, run.t_ns, P, own)
    score = evaluate(run.t_ns, estimate, run)
    assert score.to_dict() == run.score(estimate).to_dict()
    beside = evaluate(None, estimate, run.attitude())
    assert beside.total_deg == score.total_deg
    assert beside.consistency.mean == score.consistency.mean


def test_a_bag_is_certified_by_its_name(tmp_path):
    run = simulate("tumbling_cubesat", duration=1.0)
    run.to_bag(tmp_path / "run.mcap")
    assert certify(str(tmp_path / "run.mcap")).passed
    assert certify(tmp_path / "run.mcap").passed
    with pytest.raises(BagError):
        certify(tmp_path / "none.mcap")


def columns_of_pandas(t_ns, attitude_xyzw):
    frame = pytest.importorskip("pandas").DataFrame(attitude_xyzw, columns=list("xyzw")).assign(t_ns=t_ns)
    return frame["t_ns"], frame[list("xyzw")]


class Columns:
    """What is no array, and can be read as one: as polars, torch and any such library have it."""

    def __init__(self, array):
        self._array = array

    def __array__(self, dtype=None, copy=None):
        return np.array(self._array, dtype=dtype)


@pytest.mark.parametrize("make", [columns_of_pandas, lambda t, q: (Columns(t), Columns(q))])
def test_columns_and_tensors_are_taken_as_arrays(make):
    run = simulate(duration=1.0, motion="closed_form")
    t_ns, attitude = make(run.t_ns, run.truth.attitude_xyzw)
    read = Estimate(attitude, t_ns)
    np.testing.assert_array_equal(read.attitude_xyzw, run.truth.attitude_xyzw)
    np.testing.assert_array_equal(read.t_ns, run.t_ns)
    truth = SampledTruth(t_ns, attitude)
    assert evaluate(t_ns, attitude, truth).total_deg.max < 1e-12
    assert run.score(attitude, t_ns).total_deg.max < 1e-12
    assert attitude_error(attitude, attitude).total.max() < 1e-14
    np.testing.assert_array_equal(
        MovingChart(BODY, START).at(t_ns).body_rate, MovingChart(BODY, START).at(run.t_ns).body_rate
    )


def test_editors_know_the_arrays_of_the_sensors():
    named = {*Run.__bases__[0].__annotations__}
    assert named == {sensor.key for sensor in SENSORS.values()}
    arrays = {field.array for sensor in SENSORS.values() for topic in sensor.topics for field in topic.fields}
    assert {*SensorArrays.__annotations__} == {"t_ns", "arrival_ns", *arrays}
    assert simulate(duration=0.1).sun is None


def test_public_names_are_loaded_when_they_are_used():
    code = "import lie_rigid_body, sys; print(sorted(set(sys.modules) & {'numpy', 'scipy', 'dask', 'matplotlib'}))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
    assert all(getattr(lie_rigid_body, name) is not None for name in lie_rigid_body.__all__)
