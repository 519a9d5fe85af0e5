"""Grades of sensors: the numbers of the sheets in SI, their order, and single parameters over them."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sensor_models import sensors_of

from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.scenario.parameter_table import read_parameters
from lie_rigid_body.sensors import GRADES, SENSORS

ON = {"imu_rate": 100.0, "magnetometer_rate": 50.0}
DEFAULTS = {parameter.name: parameter.default for parameter in SENSORS.parameters.values()}
ERRORS = [name for name in DEFAULTS if re.search("noise|bias|scale|misalignment|iron|resolution|_range", name)]
PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "imu.md").read_text(encoding="utf-8")


def size(name: str, value: Any) -> float:
    """The largest deviation from no error."""
    return float(np.abs(np.asarray(value) - np.asarray(DEFAULTS[name])).max())


def test_grades_set_errors_and_nothing_else() -> None:
    assert list(GRADES) == ["perfect", "navigation", "tactical", "mems"]
    for grade, errors in GRADES.items():
        assert set(errors) <= set(ERRORS)
        sensors_of({**ON, "sensor_grade": grade})
    assert GRADES["perfect"] == {}
    assert sensors_of({**ON, "sensor_grade": "perfect"}) == sensors_of(ON)


@pytest.mark.parametrize("name", [name for name in ERRORS if not re.search("range|iron", name)])
def test_a_better_grade_has_the_smaller_error(name: str) -> None:
    told = [size(name, errors[name]) for errors in GRADES.values() if name in errors]
    assert told == sorted(told)
    assert all(number > 0.0 for number in told)


@pytest.mark.parametrize(
    ("grade", "sensor", "lowest"),
    [
        ("tactical", "gyro", math.radians(0.5) / 3600.0),
        ("tactical", "accelerometer", 0.05e-3 * 9.80665),
        ("mems", "gyro", math.radians(2.0) / 3600.0),
    ],
)
def test_the_lowest_allan_deviation_is_that_of_the_sheet(grade: str, sensor: str, lowest: float) -> None:
    N, K = (float(GRADES[grade][f"{sensor}_{name}"]) for name in ("noise_density", "bias_random_walk"))  # type: ignore[arg-type]
    tau = np.geomspace(1e-2, 1e6, 20_000)
    assert np.sqrt(N**2 / tau + K**2 * tau / 3.0).min() == pytest.approx(lowest, rel=1e-5)


def test_numbers_of_the_sheets() -> None:
    assert GRADES["navigation"]["gyro_noise_density"] == pytest.approx(5.8178e-7, rel=1e-4)
    assert GRADES["navigation"]["gyro_turn_on_bias"] == pytest.approx(1.6968e-8, rel=1e-4)
    assert GRADES["tactical"]["gyro_noise_density"] == pytest.approx(4.3633e-5, rel=1e-4)
    assert GRADES["tactical"]["accelerometer_noise_density"] == pytest.approx(1e-3)
    assert GRADES["mems"]["gyro_noise_density"] == pytest.approx(2.4435e-4, rel=1e-4)
    assert GRADES["mems"]["gyro_scale_factor"] == (1.01, 0.99, 1.01)


@pytest.mark.parametrize("grade", [grade for grade in GRADES if grade != "perfect"])
def test_single_parameters_override(grade: str) -> None:
    name, value = "gyro_noise_density", 0.125
    for given in ({"sensor_grade": grade, name: value}, {name: value, "sensor_grade": grade}):
        values = read_parameters(given)
        assert values[name] == value
        assert values["gyro_turn_on_bias"] == GRADES[grade]["gyro_turn_on_bias"]
    assert read_parameters({"sensor_grade": grade, name: 0.0})[name] == 0.0


def test_a_grade_in_a_file_and_an_error_in_an_assignment(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("/**:\n  ros__parameters: {sensor_grade: mems, imu_rate: 100.0, gyro_range: 1.0}\n")
    values = read_parameters(gather(None, [file], ["gyro_turn_on_bias:=0.5", "sensor_grade:=tactical"]))
    assert (values["gyro_turn_on_bias"], values["gyro_range"]) == (0.5, 1.0)
    assert values["gyro_noise_density"] == GRADES["tactical"]["gyro_noise_density"]


def test_the_page_has_a_column_for_each_grade() -> None:
    assert "| | `navigation` | `tactical` | `mems` |" in PAGE
