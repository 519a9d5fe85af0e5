"""Mistakes that are put into healthy logs are named, with the repair that undoes them; in healthy ones none is."""

from __future__ import annotations

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.inspection import Inspection, inspect
from lie_rigid_body.inspection.comparison import liveliest
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.runs import SensorArrays

GRAVITY = 9.80665
SWAPPED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # as the AK8963 in the MPU-9250: y x -z


@pytest.fixture(scope="module")
def hand() -> Run:
    return simulate("hand", duration=20.0, sensor_grade="mems")


def changed(run: Run, *, t_ns=None, gyro=None, force=None, field_ns=None, field=None, magnetometer=True) -> Run:
    imu, mag = run.imu, magnetometer_of(run)
    t_ns = imu.t_ns if t_ns is None else t_ns
    field_ns = mag.t_ns if field_ns is None else field_ns
    readings = {
        **imu.arrays,
        "gyro": imu.gyro if gyro is None else gyro,
        "specific_force": imu.specific_force if force is None else force,
    }
    sensors = {"imu": SensorArrays(t_ns, imu.arrival_ns, readings)}
    if magnetometer:
        sensors["magnetometer"] = SensorArrays(
            field_ns, mag.arrival_ns, {"field": mag.field if field is None else field}
        )
    return replace(run, sensors=sensors)


def magnetometer_of(run: Run) -> SensorArrays:
    assert run.magnetometer is not None
    return run.magnetometer


def codes(found: Inspection) -> list[str]:
    return [mistake.code for mistake in found.mistakes]


def test_nothing_is_named_in_a_healthy_log(hand: Run) -> None:
    found = inspect(hand)
    assert found.passed
    assert found.mistakes == ()
    bias = found.sensors["gyro_bias"]
    assert np.abs(np.array(bias.value) - hand.imu.gyro_bias.mean(axis=0)).max() < 0.005
    assert found.sensors["gyro_resolution"].value == pytest.approx(np.radians(1.0) / 16.384, rel=1e-9)
    assert found.sensors["imu_rate"].value == 100.0
    east, north, up = np.array(hand.scenario.value("magnetic_field"), dtype=np.float64)
    [dip] = [note for note in found.notes if note.code == "dip"]
    assert dip.value == pytest.approx(np.degrees(np.arctan2(-up, np.hypot(east, north))), abs=1.0)
    assert "below the horizontal, as in the north" in dip.message
    assert json.loads(json.dumps(found.to_dict()))["passed"]
    assert np.array_equal(found.repaired().imu.gyro, hand.imu.gyro)


def test_degrees_and_axes_at_once_are_named_and_undone(hand: Run) -> None:
    mag = magnetometer_of(hand)
    found = inspect(changed(hand, gyro=np.degrees(hand.imu.gyro), field=mag.field @ SWAPPED))
    repairs = {mistake.code: mistake.repair for mistake in found.mistakes}
    assert repairs == {"gyro_units": "× π/180", "magnetometer_axes": "y x -z"}
    misfits = [(mistake.before or 0.0, mistake.after or 1.0) for mistake in found.mistakes]
    assert all(before > 4.0 * after for before, after in misfits)
    repaired = found.repaired()
    assert np.allclose(repaired.imu.gyro, hand.imu.gyro, rtol=1e-12)
    assert np.allclose(magnetometer_of(repaired).field, mag.field, rtol=1e-12)


def test_g_and_a_late_magnetometer_at_once_are_named_and_undone(hand: Run) -> None:
    mag = magnetometer_of(hand)
    run = changed(hand, force=hand.imu.specific_force / GRAVITY, field_ns=mag.t_ns + 100_000_000)
    found = inspect(run)
    assert sorted(codes(found)) == ["accelerometer_units", "magnetometer_late"]
    repaired = found.repaired()
    assert np.allclose(repaired.imu.specific_force, hand.imu.specific_force, rtol=1e-12)
    assert np.abs(magnetometer_of(repaired).t_ns - mag.t_ns).max() < 10e6
    assert np.array_equal(magnetometer_of(repaired).field, mag.field)


def test_the_dip_tells_which_sign_fits_which_hemisphere(hand: Run) -> None:
    found = inspect(changed(hand, field=-magnetometer_of(hand).field))
    assert found.passed
    assert ["above" in note.message for note in found.notes if note.code == "dip"] == [True]


@pytest.mark.slow
def test_hard_iron_is_a_note_with_its_value(hand: Run) -> None:
    mag = magnetometer_of(hand)
    iron = np.array([20e-6, -15e-6, 15e-6])
    found = inspect(changed(hand, field=mag.field + iron))
    assert found.passed
    notes = [np.array(note.value) for note in found.notes if note.code == "hard_iron"]
    own = 30e-6 * np.tan(np.radians(2.5)) * np.array([1.0, -1.0, 1.0])  # of the grade
    assert np.linalg.norm(notes[0] - iron - own) < 2e-6


def test_an_accelerometer_without_gravity_is_named(hand: Run) -> None:
    turned = hand.attitude().at(hand.imu.t_ns[hand.imu.t_ns <= hand.t_ns[-1]])
    x, y, z, w = turned.T
    up = np.stack([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], axis=1)
    force = hand.imu.specific_force.copy()
    force[: len(up)] -= GRAVITY * up
    force[len(up) :] -= GRAVITY * up[-1]
    assert codes(inspect(changed(hand, force=force))) == ["gravity_removed"]


@pytest.mark.slow
def test_a_mean_that_was_taken_off_is_put_back(hand: Run) -> None:
    mean = hand.imu.specific_force.mean(axis=0)
    found = inspect(changed(hand, force=hand.imu.specific_force - mean))
    assert codes(found) == ["gravity_removed"]
    assert np.abs(found.repaired().imu.specific_force - hand.imu.specific_force).max() < 0.5


def test_two_sensors_do_not_tell_which_of_them_is_wrong(hand: Run) -> None:
    """A gyro and an accelerometer alone: each axes of the one are axes of the other."""
    found = inspect(changed(hand, force=hand.imu.specific_force @ SWAPPED, magnetometer=False))
    (mistake,) = found.mistakes
    assert {mistake.code, *mistake.or_else} == {"gyro_axes", "accelerometer_axes"}


@pytest.mark.slow
def test_zeros_in_the_stamps_are_named_and_filled_in(hand: Run) -> None:
    t_ns = hand.imu.t_ns.copy()
    t_ns[1000:1200] = 0
    found = inspect(changed(hand, t_ns=t_ns))
    assert codes(found) == ["stamps"]
    assert np.array_equal(found.repaired().imu.t_ns, hand.imu.t_ns)


ACCELEROMETER = ["accelerometer_axes", "accelerometer_late", "accelerometer_units", "gravity_removed"]
"""Codes of all that a comparison decides of an accelerometer."""


def test_a_log_that_no_gyro_explains_lists_all_that_it_does_not_decide() -> None:
    """A disc that turns by more than half a turn between readings: of no sensor are axes, unit or time known."""
    run = simulate(
        "thrown_disc",
        duration=60.0,
        sensor_grade="mems",
        imu_rate=5.0,
        magnetometer_rate=5.0,
        gyro_range=0.0,
        accelerometer_mode="pivot_gravity",
    )
    found = inspect(run)
    assert found.passed
    assert {*ACCELEROMETER, "magnetometer_axes", "magnetometer_late", "gyro_units"} <= {u.code for u in found.undecided}


def test_a_log_at_rest_names_nothing_and_tells_its_noise() -> None:
    run = simulate(
        duration=40.0,
        sensor_grade="mems",
        initial_body_rate=[0.0, 0.0, 0.0],
        accelerometer_mode="pivot_gravity",
        imu_rate=100.0,
        magnetometer_rate=50.0,
    )
    found = inspect(run)
    assert found.passed
    undecided = {each.code for each in found.undecided}
    assert {"accelerometer_axes", "magnetometer_axes"} <= undecided
    density = found.sensors["gyro_noise_density"]
    assert np.abs(np.subtract(density.value, np.radians(0.014))) < 4.0 * np.array(density.standard_error)
    bias = found.sensors["gyro_bias"]
    assert np.abs(np.array(bias.value) - run.imu.gyro_bias.mean(axis=0)).max() < 4.0 * np.max(bias.standard_error)


def test_only_runs_and_files_are_inspected() -> None:
    with pytest.raises(InputError, match="no Run"):
        inspect(7)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="No such file"):
        inspect("nowhere.csv")


@pytest.mark.slow
def test_stamps_of_all_sensors_in_one_column_are_one_mistake(hand: Run) -> None:
    t_ns = hand.imu.t_ns[: len(hand.imu.t_ns) // 2 * 2]
    t_ns = np.where(t_ns < t_ns[500], t_ns, t_ns + 10**9)
    run = Run.from_arrays(
        t_ns, hand.imu.gyro[: len(t_ns)], hand.imu.specific_force[: len(t_ns)], np.ones((len(t_ns), 3))
    )
    assert [(each.code, each.sensor) for each in inspect(run).mistakes if each.code == "gaps"] == [("gaps", "log")]


@pytest.mark.slow
def test_axes_at_their_range_are_one_mistake_of_the_sensor(hand: Run) -> None:
    limit = np.degrees(1.0)  # in degrees, in which the gyro reads
    found = inspect(changed(hand, gyro=np.clip(np.degrees(hand.imu.gyro), -limit, limit)))
    assert [each.sensor for each in found.mistakes if each.code == "clipped"] == ["gyro"]


@pytest.mark.slow
def test_the_field_is_told_in_the_unit_of_the_repaired_readings(hand: Run) -> None:
    found = inspect(changed(hand, field=magnetometer_of(hand).field * 1e6))
    assert codes(found) == ["magnetometer_units"]
    (field,) = (note for note in found.notes if note.code == "field")
    assert field.value == pytest.approx(48e-6, rel=0.02)
    assert " T:" in field.message


@pytest.mark.slow
def test_readings_that_tell_nothing_are_no_error(hand: Run) -> None:
    mag = magnetometer_of(hand)
    nothing = np.zeros_like(hand.imu.gyro)
    without_time = changed(hand, t_ns=np.zeros_like(hand.imu.t_ns), field_ns=np.zeros_like(mag.t_ns))
    assert codes(inspect(without_time)) == ["stamps", "stamps"]
    assert inspect(changed(hand, gyro=nothing, force=nothing, field=np.zeros_like(mag.field))).passed
    assert inspect(changed(hand, gyro=np.full_like(nothing, np.nan), magnetometer=False)).passed


@pytest.mark.slow
@pytest.mark.parametrize("ahead_ns", [10**18, 12 * 10**9, -12 * 10**9])
def test_a_magnetometer_of_another_clock_is_named_and_moved(hand: Run, ahead_ns: int) -> None:
    mag = magnetometer_of(hand)
    found = inspect(changed(hand, field_ns=mag.t_ns + ahead_ns))
    assert codes(found) == ["stamps"]
    assert np.abs(magnetometer_of(found.repaired()).t_ns - mag.t_ns).max() < 10e6


@pytest.mark.slow
def test_a_gyro_alone_and_a_few_slow_readings_are_not_compared(hand: Run) -> None:
    imu = hand.imu
    readings = {**imu.arrays, "specific_force": None}
    found = inspect(replace(hand, sensors={"imu": SensorArrays(imu.t_ns, imu.arrival_ns, readings)}))
    assert found.passed
    assert np.array_equal(found.repaired().imu.gyro, imu.gyro)
    t_ns = np.arange(16) * 500_000_000
    slow = Run.from_arrays(t_ns, hand.imu.gyro[:16], hand.imu.specific_force[:16])
    assert [each.code for each in inspect(slow).undecided] == ACCELEROMETER


def test_a_gap_of_years_takes_no_memory(hand: Run) -> None:
    t_ns = hand.imu.t_ns.copy()
    t_ns[len(t_ns) // 2 :] += 3 * 10**16  # a clock that is set while it records
    tracemalloc.start()
    stretch = liveliest(Stream("gyro", t_ns, hand.imu.gyro))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert np.ptp(stretch.t_ns) < 60e9
    assert peak < 1e6


def test_repeated_readings_have_the_rate_of_the_slower_sensor(hand: Run) -> None:
    mag = magnetometer_of(hand)
    held = np.searchsorted(mag.t_ns, hand.imu.t_ns, side="right") - 1
    found = inspect(changed(hand, field_ns=hand.imu.t_ns, field=mag.field[held]))
    assert codes(found) == ["repeated"]
    assert found.sensors["magnetometer_rate"].value == pytest.approx(1e9 / np.median(np.diff(mag.t_ns)), rel=1e-6)
