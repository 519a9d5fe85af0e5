"""Laws of the parts of an inspection, against independent references."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lie_rigid_body import Run, inspect, simulate
from lie_rigid_body.inspection.explanations import SensorExplanation, SensorRepair, axes_repairs, judged
from lie_rigid_body.inspection.minimum import minimum
from lie_rigid_body.inspection.rule import RIGHT, TURNS
from lie_rigid_body.inspection.search import Fitting
from lie_rigid_body.inspection.world import Vector, gram, integrated

T_S = np.arange(6000) / 100.0
RATE = np.stack([np.sin(0.7 * T_S), 1.3 * np.cos(1.1 * T_S), 0.8 * np.sin(0.4 * T_S + 1.0)], axis=1)


def constant_in_the_world(vector: np.ndarray, delay_s: float = 0.0) -> np.ndarray:
    """Readings at T_S of a vector, by SciPy's rotations over steps of 1 ms."""
    fine = np.arange(-1000, 61000) / 1000.0
    middle = (fine[1:] + fine[:-1]) / 2.0
    rates = np.stack([np.interp(middle, T_S, axis) for axis in RATE.T], axis=1)
    attitude = np.eye(3)
    found = []
    matrices = Rotation.from_rotvec(rates * 1e-3).as_matrix()
    for matrix in matrices:
        found.append(attitude.T @ vector)
        attitude = attitude @ matrix
    index = np.clip(np.searchsorted(fine, T_S - delay_s), 0, len(found) - 1)
    return np.array(found)[index]


@pytest.fixture(scope="module")
def readings() -> np.ndarray:
    return constant_in_the_world(np.array([0.3, -0.2, 0.9]))


@pytest.mark.parametrize("turn", [0, 7, 23])
@pytest.mark.parametrize("bias", [0.0, 0.01])
def test_the_turn_bias_and_offset_put_in_are_those_that_fit(readings: np.ndarray, turn: int, bias: float) -> None:
    offset = np.array([0.1, 0.2, -0.1])
    vector = Vector("magnetometer", T_S, readings @ TURNS[turn] + offset, 0.0, lambda _: integrated(T_S, RATE + bias))
    (windows,) = vector.windows(RIGHT, 0.0, 2.0)
    fit = vector.fit(gram(windows))
    assert fit.misfit.argmin() == turn
    assert fit.misfit[turn] < 0.005
    assert np.sort(fit.misfit)[1] > 0.1
    assert np.allclose(TURNS[turn].T @ fit.constants[turn, :3] * vector.size, offset, atol=0.003)
    assert np.allclose(fit.constants[turn, 3:], -bias, atol=0.0015)


def test_chunks_add_up_to_the_whole(readings: np.ndarray) -> None:
    vector = Vector("magnetometer", T_S, readings, 0.0, lambda _: integrated(T_S, RATE))
    (windows,) = vector.windows(RIGHT, 0.0, 2.0)
    assert np.allclose(gram(windows, 7).sum(axis=0), gram(windows)[0], rtol=1e-12, atol=1e-12)


def test_a_common_rotation_of_all_sensors_is_one_repair_of_the_gyro() -> None:
    """Each of three frames may be that of all: with equal turns of both vectors the gyro alone is wrong."""
    turns = {"gyro": 0, "accelerometer": 5, "magnetometer": 5}
    repairs = axes_repairs(1.0, 5, turns)
    assert [repair.code for repair in repairs] == ["gyro_axes"]
    assert [repair.code for repair in axes_repairs(1.0, 0, turns)] == [
        "accelerometer_axes",
        "magnetometer_axes",
    ]


def explained(*codes: str, ratio: float, late: tuple[str, ...] = ()) -> SensorExplanation:
    """An explanation by repairs of the gyro, of a vector that nobody measured."""
    repairs = tuple(SensorRepair(code, "gyro") for code in codes)
    return SensorExplanation(repairs, late, (Fitting(None, RIGHT, 0, 0.0, ratio),))  # type: ignore[arg-type]


def test_fewer_repairs_that_are_not_excluded_leave_it_open() -> None:
    """Nothing at a ratio of 2.2 is not excluded, whatever else fits with a delay and no repair."""
    late = explained(ratio=2.2, late=("magnetometer",))
    verdict = judged([explained(ratio=2.2), late, explained("time_step", ratio=1.3)])
    assert (verdict.named, verdict.fewer) == ((), True)
    assert verdict.is_open
    assert [repair.code for repair in verdict.alternatives] == ["time_step"]


def test_what_fits_as_well_by_as_few_repairs_is_told_beside() -> None:
    verdict = judged([explained("gyro_units", ratio=1.1), explained("time_step", ratio=1.0)])
    assert [repair.code for repair in verdict.named] == ["gyro_units"]
    assert not verdict.is_open
    assert [repair.code for repair in verdict.alternatives] == ["time_step"]


def test_newton_finds_the_minimum_of_a_parabola() -> None:
    found = minimum(lambda place: (place - 0.3) ** 2 * np.ones(3) + 1.0, 0.0, 1.0)
    assert found.place == pytest.approx(0.3)
    assert found.sigma == pytest.approx(0.0, abs=1e-12)
    assert found.level / found.width == pytest.approx(np.sqrt(3.0))


def test_what_nothing_compares_is_undecided() -> None:
    run = simulate("hand", duration=10.0, sensor_grade="mems")
    stuck = run.imu.gyro * [1.0, 0.0, 1.0]
    found = inspect(Run.from_arrays(run.imu.t_ns, stuck, run.imu.specific_force))
    assert [mistake.code for mistake in found.mistakes] == ["stuck"]
    assert {"gyro_axes", "gyro_units", "time_step"} <= {each.code for each in found.undecided}
