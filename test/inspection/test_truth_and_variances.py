"""The clock and the mounting of a truth, the gyro against it, and declared variances against the scatter at rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lie_rigid_body import Run, inspect, simulate
from lie_rigid_body.inspection import Inspection
from sampled import sampled

LATE_NS = 120_000_000
MOUNTING = Rotation.from_rotvec([0.3, -1.0, 0.4])


@pytest.fixture(scope="module")
def hand() -> Run:
    return simulate("hand", duration=20.0, sensor_grade="mems")


def own(run: Run, t_ns: np.ndarray, attitude_xyzw: np.ndarray, gyro: np.ndarray) -> Run:
    """The run as arrays of somebody, beside a truth."""
    assert run.magnetometer is not None
    field = (run.magnetometer.t_ns, run.magnetometer.field)
    return Run.from_arrays(run.imu.t_ns, gyro, run.imu.specific_force, field, (t_ns, attitude_xyzw))


def codes(found: Inspection) -> list[str]:
    return [mistake.code for mistake in found.mistakes]


def value(found: Inspection, code: str) -> float:
    (note,) = (note for note in found.notes if note.code == code)
    assert isinstance(note.value, float)
    return note.value


def test_clock_and_mounting_of_a_truth_are_named_and_undone(hand: Run) -> None:
    truth = hand.truth.attitude_xyzw
    turned = (Rotation.from_quat(truth) * MOUNTING.inv()).as_quat()
    found = inspect(own(hand, hand.t_ns + LATE_NS, turned, hand.imu.gyro))
    assert codes(found) == ["truth_late", "truth_mounting"]
    repaired = found.repaired()
    half_ns = 5_000_000  # an integrated rate is late by half of the time between readings
    assert np.abs(repaired.t_ns - hand.t_ns - half_ns).max() < 1_000_000
    left = Rotation.from_quat(repaired.truth.attitude_xyzw) * Rotation.from_quat(truth).inv()
    assert np.degrees(left.magnitude()).max() < 1.5  # the gyro's own mounting is off by 1°
    again = inspect(repaired)
    assert again.passed
    assert abs(value(again, "truth_late")) < 1e-4
    assert value(again, "truth_mounting") < 0.01


@pytest.mark.slow
def test_a_right_truth_is_a_note(hand: Run) -> None:
    found = inspect(own(hand, hand.t_ns, hand.truth.attitude_xyzw, hand.imu.gyro))
    assert found.passed
    assert value(found, "truth_late") == pytest.approx(-0.005, abs=0.001)
    assert value(found, "truth_mounting") == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(
    ("factor", "code", "repair"),
    sampled(
        [(np.degrees(1.0), "gyro_units", "× 0.0174533"), (-1.0, "gyro_axes", "-x -y -z"), (0.5, "time_step", "× 1.98")],
        every=3,
    ),
)
def test_a_gyro_alone_is_judged_by_the_truth(hand: Run, factor: float, code: str, repair: str, tmp_path: Path) -> None:
    readings = np.column_stack([hand.imu.t_ns, factor * hand.imu.gyro])
    np.savetxt(tmp_path / "gyro.csv", readings, delimiter=",", header="t_ns,wx,wy,wz", comments="", fmt="%.17g")
    run = Run.from_log(tmp_path / "gyro.csv", truth=(hand.t_ns, hand.truth.attitude_xyzw))
    (mistake,) = inspect(run).mistakes
    assert mistake.code == code
    assert mistake.repair.startswith(repair)


@pytest.mark.slow
def test_a_gyro_alone_in_degrees_is_undone_by_the_truth(hand: Run, tmp_path: Path) -> None:
    readings = np.column_stack([hand.imu.t_ns, np.degrees(hand.imu.gyro)])
    np.savetxt(tmp_path / "gyro.csv", readings, delimiter=",", header="t_ns,wx,wy,wz", comments="", fmt="%.17g")
    found = inspect(Run.from_log(tmp_path / "gyro.csv", truth=(hand.t_ns, hand.truth.attitude_xyzw)))
    assert np.allclose(found.repaired().imu.gyro, hand.imu.gyro, rtol=1e-9)


@pytest.mark.slow
def test_the_attitude_of_another_body_is_undecided(hand: Run) -> None:
    other = simulate(duration=40.0, initial_body_rate=[0.3, 0.2, 1.0])
    found = inspect(own(hand, other.t_ns, other.truth.attitude_xyzw, hand.imu.gyro))
    assert found.passed
    assert {"truth_late", "truth_mounting"} <= {each.code for each in found.undecided}


def resting(folder: Path, end_s: float = 20.0) -> Run:
    run = simulate(
        duration=40.0,
        initial_body_rate=[0.0, 0.0, 0.0],
        kicks=[end_s, 0.5, 1.0, -0.7, 30.0, -1.0, 0.8, 0.6],
        imu_rate=100.0,
        magnetometer_rate=50.0,
        sensor_grade="mems",
    )
    run.to_bag(folder / "resting.mcap")
    return Run.from_log(folder / "resting.mcap")


def test_declared_variances_are_held_against_the_scatter_at_rest(tmp_path: Path) -> None:
    run = resting(tmp_path)
    assert run.log is not None
    assert run.log.gyro.variance is not None
    assert codes(inspect(run)) == []
    for factor, named in ((3.0, []), (6.0, ["covariance"]), (1.0 / 6.0, ["covariance"])):
        gyro = replace(run.log.gyro, variance=run.log.gyro.variance * factor)
        assert codes(inspect(replace(run, log=replace(run.log, gyro=gyro)))) == named


def test_a_motion_that_begins_at_the_end_of_a_rest_is_no_noise(tmp_path: Path) -> None:
    found = inspect(resting(tmp_path, end_s=19.965))
    assert codes(found) == []
    assert found.sensors["gyro_noise_density"].value == pytest.approx(np.radians(0.014), rel=0.2)


def test_declared_variances_of_a_log_that_never_rests_are_undecided(hand: Run, tmp_path: Path) -> None:
    hand.to_bag(tmp_path / "hand.mcap")
    found = inspect(tmp_path / "hand.mcap")
    assert "covariance" in {each.code for each in found.undecided}
