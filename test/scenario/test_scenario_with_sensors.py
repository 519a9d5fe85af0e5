"""Sensors in a scenario: kept through its text, silent when off, and refused where they could not tell the truth."""

from __future__ import annotations

import re

import pytest

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather, scenario_files
from lie_rigid_body.sensors import GRADES, SENSORS
from lie_rigid_body.simulation import Segment
from said import numbers

ON: dict[str, object] = {"imu_rate": 250.0, "gyro_noise_density": 0.003, "sensor_seed": 7, "imu_frame": "imu"}


@pytest.mark.parametrize(
    "given",
    [
        {},
        ON,
        {"sensor_seed": 5, "gravity": 3.7},
        {"magnetometer_rate": 50.0, "gravity": 3.7, "sun_direction": [0.0, 1.0, 0.0]},
        {**ON, "sensor_grade": "mems", "gyro_turn_on_bias": 1e-3, "gyro_stuck_interval": 5.0},
        {"sensor_grade": "mems"},
    ],
)
def test_text_and_repr_of_a_scenario_bring_it_back(given: dict[str, object]) -> None:
    scenario = Scenario.from_parameters(given)
    assert Segment.from_json(Segment(scenario, 0, 0).to_json()).scenario == scenario
    if len(repr(scenario)) < 150:
        assert eval(repr(scenario)) == scenario


def test_text_has_all_of_the_sensors_that_are_on_and_of_others_what_was_given() -> None:
    names = {name: {p.name for p in sensor.all_parameters} for name, sensor in SENSORS.items()}
    bare = set(Scenario().parameters())
    assert bare.isdisjoint(SENSORS.parameters)
    told = set(Scenario.from_parameters({**ON, "sun_direction": [0.0, 1.0, 0.0]}).parameters()) - bare
    assert told == set(SENSORS.parameters) - names["magnetometer"] - names["attitude_sensor"] - names["sun_sensor"] | {
        "sun_direction"
    }


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"gyro_spike_probability": 0.1}, ["gyro_spike_probability", "imu_rate"]),
        (
            {"imu_rate": 9.0, "magnetometer_hard_iron": [1e-6, 0.0, 0.0], "magnetic_disturbance_interval": 5.0},
            ["magnetometer_hard_iron", "magnetometer_rate"],
        ),
        (
            {"imu_latency": 0.1, "sun_sensor_noise": 0.1, "attitude_sensor_rate": 1.0},
            ["imu_latency", "imu_rate", "sun_sensor_noise", "sun_sensor_rate"],
        ),
        ({"sensor_grade": "mems", "gyro_range": 1.0}, ["gyro_range", "imu_rate"]),
        ({"sensor_grade": "mems"}, []),
        ({"gyro_spike_probability": 0.0, "imu_frame": "sensor", "sensor_seed": 3}, []),
        ({"imu_rate": 9.0, "magnetic_field": [0.0, 0.0, 1e-5]}, ["magnetic_field", "magnetometer_rate"]),
        ({"sun_direction": [0.0, 1.0, 0.0]}, ["sun_direction", "sun_sensor_rate"]),
        ({"gravity": 9.7}, ["gravity", "imu_rate"]),
        ({"imu_rate": 9.0, "gyro_spike_probability": 0.1, "sensor_grade": "mems"}, []),
        ({"imu_rate": 9.0, "gyro_spike_size": 2.0}, ["gyro_spike_size", "gyro_spike_probability"]),
        (
            {"magnetometer_rate": 9.0, "magnetic_disturbance_size": 1e-4, "magnetic_disturbance_duration": 2.0},
            ["magnetic_disturbance_duration", "magnetic_disturbance_interval"],
        ),
        (
            {"imu_rate": 9.0, "accelerometer_temperature_drift_duration": 9.0, "imu_heading_noise": 0.1},
            [
                "imu_heading_noise",
                "imu_orientation",
                "accelerometer_temperature_drift_duration",
                "accelerometer_temperature_drift",
            ],
        ),
        ({"imu_rate": 9.0, "fault_end": 5.0}, ["fault_end"]),
        ({"imu_rate": 9.0, "fault_end": 5.0, "gyro_stuck_interval": 3.0, "gyro_stuck_duration": 2.0}, []),
        ({"imu_rate": 9.0, "imu_latency_jitter": 0.1, "gyro_temperature_drift": 0.1}, []),
        ({"gyro_spike_size": 2.0}, ["gyro_spike_size", "imu_rate"]),
    ],
)
def test_what_is_asked_of_sensors_and_faults_that_are_off_is_told(given: dict[str, object], named: list[str]) -> None:
    told = Scenario.from_parameters(given).without_effect
    assert [word for word in re.findall(r"\w+", " ".join(told)) if word in SENSORS.parameters] == named
    assert bool(told) == bool(named)


@pytest.mark.parametrize("name", scenario_files())
def test_no_shipped_scenario_asks_it(name: str) -> None:
    for grade in GRADES:
        assert Scenario.from_parameters({**gather(name, [], []), "sensor_grade": grade}).without_effect == []


def test_integrated_rate_needs_less_than_half_a_turn_between_readings() -> None:
    given = {"gyro_rate": "integrated", "initial_body_rate": [0.0, 0.0, 30.0], "imu_rate": 9.0}
    with pytest.raises(ParameterError) as refusal:
        Scenario.from_parameters(given)
    assert refusal.value.name == "imu_rate"
    Scenario.from_parameters({**given, "imu_rate": numbers(str(refusal.value))[-1]})
    Scenario.from_parameters({**given, "gyro_rate": "instantaneous"})
