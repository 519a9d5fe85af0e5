"""Runs of anybody's sensors: of logs and of arrays, with and without a truth."""
# mypy: ignore-errors

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import Estimate, Run, SampledTruth, evaluate, simulate
from lie_rigid_body.estimates.programs import CommandEstimator
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.ensemble import BlindRun

TRUE = simulate("hand", duration=4.0, imu_rate=100.0, magnetometer_rate=25.0, sensor_grade="mems", rate=200.0)
ARRAYS = (TRUE.imu.t_ns, TRUE.imu.gyro, TRUE.imu.specific_force)
FIELD = (TRUE.magnetometer.t_ns, TRUE.magnetometer.field)
TRUTH = (TRUE.t_ns, TRUE.truth.attitude_xyzw)
SENSORS = {
    name: value for name, value in TRUE.scenario.parameters().items() if name.startswith(("gyro_", "magn", "acc"))
}


def integrated(run: Run) -> Estimate:
    """A filter that integrates the gyro, from the true attitude on."""
    steps = quaternion.exp(run.imu.gyro * np.diff(run.imu.t_s, prepend=run.imu.t_s[0])[:, np.newaxis])
    attitude = [TRUE.truth.attitude_xyzw[0]]
    for step in steps[1:]:
        attitude.append(quaternion.multiply(attitude[-1], step))
    return Estimate(np.array(attitude), run.imu.t_ns)


def test_a_run_of_arrays_has_the_readings() -> None:
    run = Run.from_arrays(*ARRAYS, FIELD)
    assert (run.imu.gyro == TRUE.imu.gyro).all()
    assert (run.imu.specific_force == TRUE.imu.specific_force).all()
    assert run.magnetometer is not None
    assert (run.magnetometer.t_ns == FIELD[0]).all()
    assert (run.magnetometer.field == FIELD[1]).all()
    assert run.truth is None
    assert run.position is run.velocity is run.acceleration is None
    assert run.imu.gyro_bias is None
    assert len(run.to_dataframe()) >= len(run.imu.t_ns)
    assert "Run" in repr(run)
    assert run._repr_html_()


def test_a_field_without_a_clock_has_that_of_the_imu() -> None:
    run = Run.from_arrays(*ARRAYS, TRUE.imu.specific_force * 1e-6)
    assert run.magnetometer is not None
    assert (run.magnetometer.t_ns == run.imu.t_ns).all()


@pytest.mark.parametrize("truth", [TRUTH, SampledTruth(*TRUTH)])
def test_an_estimate_is_scored_by_the_truth_that_was_given(truth) -> None:
    run = Run.from_arrays(*ARRAYS, FIELD, truth=truth)
    estimate = integrated(run)
    score = run.score(estimate)
    assert score.total_deg.rms == evaluate(estimate.t_ns, estimate, SampledTruth(*TRUTH)).total_deg.rms
    assert score.total_deg.rms == pytest.approx(TRUE.score(estimate).total_deg.rms, rel=1e-3)
    assert evaluate(estimate.t_ns, estimate, run).total_deg.rms == score.total_deg.rms
    assert (run.t_ns == TRUE.t_ns).all()
    assert run.truth.attitude_xyzw == pytest.approx(TRUTH[1], abs=1e-15)
    assert np.median(np.abs(run.truth.body_rate - TRUE.truth.body_rate)) < 1e-3  # kicks are jumps of the rate


def test_estimated_biases_have_no_score() -> None:
    run = Run.from_arrays(*ARRAYS, truth=TRUTH)
    estimate = integrated(run)
    with_bias = Estimate(estimate.attitude_xyzw, estimate.t_ns, gyro_bias=0.0 * run.imu.gyro)
    assert run.score(with_bias).total_deg == run.score(estimate).total_deg


def test_attitudes_that_cameras_lost_are_gaps_of_the_truth() -> None:
    attitude = TRUE.truth.attitude_xyzw.copy()
    attitude[300:400] = np.nan
    run = Run.from_arrays(*ARRAYS, truth=(TRUE.t_ns, attitude))
    assert len(run.t_ns) == len(TRUE.t_ns) - 100
    assert not run.attitude().covers(TRUE.t_ns[350:351]).any()


def test_a_log_and_the_truth_of_its_bag_make_a_run(tmp_path: Path) -> None:
    estimate = integrated(TRUE)
    TRUE.to_bag(tmp_path / "own.mcap", estimates={"/mine": Estimate(estimate.attitude_xyzw, estimate.t_ns)})
    np.savetxt(tmp_path / "own.tum", np.column_stack([TRUE.t_s, 0 * TRUE.truth.body_rate, TRUTH[1]]), fmt="%.17g")
    for truth in ("/pose", tmp_path / "own.tum", tmp_path / "own.mcap"):
        run = Run.from_log(tmp_path / "own.mcap", truth=truth)
        assert (run.imu.gyro == TRUE.imu.gyro).all()
        assert run.score(estimate).total_deg.rms == pytest.approx(TRUE.score(estimate).total_deg.rms, rel=1e-3)
    assert run.log is not None
    assert run.log.taken


def test_an_accelerometer_with_a_clock_of_its_own_is_linear_between_its_readings(tmp_path: Path) -> None:
    for name, values in (("Gyroscope", TRUE.imu.gyro), ("Accelerometer", TRUE.imu.specific_force)):
        late = 3 if name == "Accelerometer" else 0
        rows = np.column_stack([TRUE.imu.t_s[late:], values[late:]])
        np.savetxt(tmp_path / f"{name}.csv", rows, fmt="%.17g", delimiter=",", header='"Time (s)",x,y,z', comments="")
    run = Run.from_log(tmp_path)
    assert run.imu.specific_force[3:] == pytest.approx(TRUE.imu.specific_force[3:], rel=1e-12)


def test_a_program_is_given_the_readings_of_such_a_run(tmp_path: Path) -> None:
    filter_ = tmp_path / "filter.py"
    filter_.write_text(
        "for line in [*open(0)][1:]:\n    if line.split(',')[1]:\n        print(line.split(',')[0] + ',0,0,0,1')"
    )
    command = CommandEstimator(f"{sys.executable} {filter_}")
    t_ns, _ = command(Run.from_arrays(*ARRAYS, FIELD))
    assert t_ns.tolist() == TRUE.imu.t_ns.tolist()
    rows = np.column_stack([TRUE.imu.t_s, TRUE.imu.gyro])
    np.savetxt(tmp_path / "gyro.csv", rows, delimiter=",", header="Time (s),gx,gy,gz", comments="")
    run = Run.from_log(tmp_path / "gyro.csv")
    assert run.imu.specific_force is None
    given, _ = command(run)  # the columns of the accelerometer are empty
    assert given.tolist() == run.imu.t_ns.tolist()
    with pytest.raises(InputError, match="no accelerometer"):
        run.to_bag(tmp_path / "gyro.mcap")


def test_a_run_of_a_log_cannot_be_blind() -> None:
    with pytest.raises(InputError, match="no scenario"):
        BlindRun.without_truth(Run.from_arrays(*ARRAYS, FIELD))


def test_declared_sensors_give_a_bound() -> None:
    run = Run.from_arrays(*ARRAYS, FIELD, truth=TRUTH).with_sensors(SENSORS)
    bound, wanted = run.cramer_rao_bound(), TRUE.cramer_rao_bound()
    assert bound is not None
    assert wanted is not None
    ratio = np.median(bound.filtered) / np.median(wanted.filtered)
    assert ratio == pytest.approx(1.0, rel=0.02)
    assert run.score(integrated(run)).best is not None
    with pytest.raises(InputError, match="initial_attitude_xyzw"):
        _ = run.scenario.initial_attitude_xyzw
