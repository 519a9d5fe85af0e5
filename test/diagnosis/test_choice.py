"""The rule by which repairs are chosen, and the repairs themselves."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.diagnosis.course import MARGIN, Readings, courses_of
from lie_rigid_body.diagnosis.course import readings as readings_of
from lie_rigid_body.diagnosis.examination import instead_of
from lie_rigid_body.diagnosis.outputs import CODED, COMPOSED, of_output
from lie_rigid_body.diagnosis.repairs import (
    FITTED,
    JOINT,
    ORDER,
    SENSOR_READINGS,
    Repair,
    exact_repairs,
    factor,
    late,
)
from lie_rigid_body.diagnosis.trials import Trial, choose
from lie_rigid_body.evaluation.attitudes import angles_between
from lie_rigid_body.evaluation.causes import BY_CODE, CAUSES
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.lie import quaternion

FLOOR = 0.001
REPAIRS = {repair.code: repair for repair in exact_repairs()}


def trial(*codes: str, error: float, outputs: tuple[str, ...] = ()) -> Trial:
    causes = (of_output(BY_CODE[code], np.zeros(BY_CODE[code].price)) for code in outputs)
    return Trial((*(REPAIRS[code] for code in codes), *causes), "integrated", error)


@pytest.mark.parametrize(
    ("found", "named", "or_else"),
    [
        ([trial("gyro_axes", error=0.0)], ("gyro_axes",), ()),
        ([trial("gyro_axes", error=0.101)], None, ()),  # more than a tenth
        ([trial("gyro_axes", error=0.099)], ("gyro_axes",), ()),
        (  # below the floor all are equal: the fewest, the cheapest, the first of the table
            [
                trial("gyro_axes", "gyro_units", error=0.0),
                trial(outputs=("world_turned",), error=0.0),
                trial("magnetometer_axes", error=0.0009),
                trial("accelerometer_axes", error=0.0005),
            ],
            ("accelerometer_axes",),
            ("magnetometer_axes", "world_turned"),
        ),
        (
            [trial(outputs=("world_turned",), error=0.0), trial(outputs=("lagging",), error=0.0)],
            ("lagging",),
            ("world_turned",),
        ),
        (  # above it within a factor of 2
            [trial("magnetometer_axes", error=0.02), trial("gyro_axes", error=0.039)],
            ("gyro_axes",),
            ("magnetometer_axes",),
        ),
        ([trial("magnetometer_axes", error=0.02), trial("gyro_axes", error=0.041)], ("magnetometer_axes",), ()),
    ],
)
def test_fewest_then_cheapest_then_first_is_named(
    found: list[Trial], named: tuple[str, ...] | None, or_else: tuple[str, ...]
) -> None:
    chosen = choose([trial(error=1.0), *found], FLOOR)
    assert (chosen[0].codes if chosen else None) == named
    if chosen:
        assert instead_of(chosen[0], chosen[1:], chosen[0].codes[0]) == or_else


def test_two_rotations_of_the_body_are_not_named_together() -> None:
    both = trial("body_axes", error=0.0, outputs=("body_mounting",))
    assert not choose([trial(error=1.0), both], FLOOR)
    assert choose([trial(error=1.0), trial("gyro_axes", error=0.0, outputs=("body_mounting",))], FLOOR)


def test_nothing_is_named_below_the_floor() -> None:
    assert choose([trial(error=0.9 * FLOOR), trial("gyro_axes", error=0.0)], FLOOR) == []


def test_small_error_is_mended_by_a_repair_that_halves_it_below_the_floor() -> None:
    before = trial(error=1.5 * FLOOR)
    assert not choose([before, trial("gyro_axes", error=0.8 * FLOOR)], FLOOR)
    assert choose([before, trial("gyro_axes", error=0.7 * FLOOR)], FLOOR)


def test_each_sensor_has_every_wrong_signed_permutation_once() -> None:
    repairs = Counter(repair.code for repair in exact_repairs())
    assert [repairs[f"{sensor}_axes"] for sensor in SENSOR_READINGS] == [47, 47, 47]
    assert repairs["body_axes"] == 23
    assert repairs["gyro_world_axes"] == 24
    assert {*repairs, *FITTED, *CODED, factor(1.01).code} == {*ORDER}
    assert len({(repair.code, repair.text) for repair in exact_repairs()}) == len(exact_repairs())


@pytest.mark.parametrize("kind", ["integrated", "instantaneous"])
def test_readings_are_those_of_the_path(kind: str) -> None:
    course = courses_of({})[1].of_scenario(gyro_rate=kind)
    readings = readings_of(course)
    imu = readings.run().imu
    truth = course.at(imu.t_ns)
    assert imu.t_ns[0] == 0
    assert len(imu.t_ns) == len(readings.t_ns) - 2 * MARGIN
    up = quaternion.rotate(truth, imu.specific_force)
    assert np.max(np.abs(up - [0.0, 0.0, 9.80665])) < 1e-13
    steps = quaternion.exp(imu.gyro[1:] * 0.01)
    left = angles_between(quaternion.multiply(truth[:-1], steps), truth[1:]).max()
    assert left < 1e-13 if kind == "integrated" else 1e-6 < left < 1e-2
    assert np.abs(imu.gyro[:100]).max() < 1e-13  # at rest
    assert np.abs(imu.gyro[101:]).min(axis=0).max() > 0.0


def given(readings: Readings) -> dict[str, Any]:
    """What a filter is given, by name."""
    run = readings.run()
    assert run.magnetometer is not None
    return {"gyro": run.imu.gyro, "specific_force": run.imu.specific_force, "field": run.magnetometer.field}


def repaired(readings: Readings, *repairs: Repair) -> dict[str, Any]:
    """What a filter is given after some repairs."""
    for repair in repairs:
        assert repair.change is not None
        readings = repair.change(readings)
    return given(readings)


def test_late_readings_are_undone_by_earlier_ones() -> None:
    readings = readings_of(courses_of({})[0])
    for sensor, name in SENSOR_READINGS.items():
        moved = repaired(readings, late(sensor, -3), late(sensor, 3))
        assert np.array_equal(moved[name], given(readings)[name])
        once = repaired(readings, late(sensor, 3))
        assert np.array_equal(once[name][:-3], given(readings)[name][3:])


def test_joint_repair_gives_the_first_reading_twice() -> None:
    plain = readings_of(courses_of({})[0])
    moved = repaired(plain, JOINT)
    for name in ("specific_force", "field"):
        assert np.array_equal(moved[name][1:], given(plain)[name][:-1])
        assert np.array_equal(moved[name][0], given(plain)[name][0])
    assert np.array_equal(moved["gyro"], given(plain)["gyro"])


@pytest.mark.parametrize(
    ("code", "constants"),
    [
        ("heading_offset", [0.4]),
        ("world_turned", [0.3, -0.2, 0.5]),
        ("body_mounting", [0.1, 0.2, -0.6]),
        ("lagging", [0.043]),
        ("leading", [-0.031]),
        ("clock_rate", [1.07]),
        ("euler_order", [COMPOSED.index(("XYZ", "ZYX", (1.0, 1.0, 1.0)))]),
        ("inverted", [0.0]),
        ("scalar_first", [0.0]),
        ("ned_world", [1.0]),
    ],
)
def test_cause_that_was_put_in_is_fitted(code: str, constants: list[float]) -> None:
    truth, stamps = courses_of({})[0], np.arange(300, 1300) * 10_000_000
    q, (x, *_) = truth.at(stamps), constants
    from scipy.spatial.transform import Rotation

    put = {
        "heading_offset": lambda: quaternion.multiply(quaternion.exp([0.0, 0.0, x]), q),
        "world_turned": lambda: quaternion.multiply(quaternion.exp(constants), q),
        "body_mounting": lambda: quaternion.multiply(q, quaternion.exp(constants)),
        "lagging": lambda: truth.at(stamps - round(x * 1e9)),
        "leading": lambda: truth.at(stamps - round(x * 1e9)),
        "clock_rate": lambda: truth.at(stamps[0] + np.round((stamps - stamps[0]) * x).astype(np.int64)),
        "euler_order": lambda: Rotation.from_euler("XYZ", Rotation.from_quat(q).as_euler("ZYX")[:, ::-1]).as_quat(),
        "inverted": lambda: q * [-1.0, -1.0, -1.0, 1.0],
        "scalar_first": lambda: np.roll(q, 1, axis=1),
        "ned_world": lambda: quaternion.multiply(
            [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], q[:, [3, 2, 1, 0]] * [1, 1, -1, -1]
        ),
    }[code]()
    cause = CODED[code]
    fitted, left = cause.fitted([Matched(stamps, put, truth)])
    assert left < 1e-7
    assert fitted == pytest.approx(constants, abs=1e-7)


def test_clock_of_another_rate_is_undone_where_only_later_samples_are_compared() -> None:
    truth, stamps = courses_of({})[0], np.arange(1300) * 10_000_000
    whole = Matched(np.round(1.03 * stamps).astype(np.int64), truth.at(stamps), truth)
    (clock,) = (cause for cause in CAUSES if cause.code == "clock_rate")
    constants, left = clock.fitted([whole.fraction()])
    assert left < 1e-7
    assert constants == pytest.approx([1.0 / 1.03], abs=1e-7)
    assert clock.undo(whole, constants).error().total.max() < 1e-7
