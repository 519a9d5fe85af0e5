"""Scenarios: their sensors, and the limits of their steps."""

from __future__ import annotations

import re

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, MovingChart
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.time_steps import steps_to
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


BODY = {"inertia": [0.6, 0.8, 1.0], "initial_body_rate": [3.0, 0.5, -0.9]}
LONG = {**BODY, "max_step": 10.0, "rate": 0.1}
TIMES = np.arange(0, 100, 10) * 10**9
LIMITED = [name for name, method in METHODS.items() if method.max_turn < np.inf]


def off(scenario: Scenario) -> float:
    """How far the attitudes of a scenario's motion are from the closed form, rad."""
    exact = ClosedForm(scenario.body(), scenario.start()).at(TIMES).attitude_xyzw
    found = scenario.make_motion().at(TIMES).attitude_xyzw
    return float(vectors.norm(quaternion.log(quaternion.multiply(quaternion.conjugate(exact), found))).max())


@pytest.mark.parametrize("method", LIMITED)
def test_a_method_that_limits_its_steps_takes_any_max_step(method: str) -> None:
    scenario = Scenario.from_parameters({**LONG, "method": method})
    chart = MovingChart(scenario.body(), scenario.start(), method=method, max_step=10.0)
    np.testing.assert_array_equal(chart.at(TIMES).attitude_xyzw, scenario.make_motion().at(TIMES).attitude_xyzw)
    if method == "dmv20":
        assert off(scenario) < 1e-14


@pytest.mark.parametrize("method", [name for name in METHODS if name not in LIMITED])
def test_a_method_that_does_not_is_refused_long_steps(method: str) -> None:
    with pytest.raises(ParameterError) as refusal:
        Scenario.from_parameters({**LONG, "method": method})
    assert refusal.value.name == "max_step"
    Scenario.from_parameters({**LONG, "method": method, "max_step": 0.2})
    Scenario.from_parameters({**LONG, "method": method, "rate": 10.0})


def test_the_steps_between_readings_of_a_sensor_are_refused_as_well() -> None:
    parameters = {**LONG, "method": "rkmk4", "rate": 10.0}
    Scenario.from_parameters({**parameters, "imu_rate": 10.0})
    for rate in ("imu_rate", "magnetometer_rate"):
        with pytest.raises(ParameterError) as refusal:
            Scenario.from_parameters({**parameters, rate: 1.0})
        assert refusal.value.name == "max_step"


def test_more_steps_than_can_be_taken_are_refused() -> None:
    fast = {"initial_body_rate": [1e12, 1e12, 0.0]}
    Scenario.from_parameters(fast)
    with pytest.raises(ParameterError) as refusal:
        Scenario.from_parameters({**fast, "rate": 1e-6})
    assert refusal.value.name == "initial_body_rate"
    Scenario.from_parameters({**fast, "rate": 1e-6, "motion": "closed_form"})
    Scenario.from_parameters({"rate": 1e-6, "max_step": 1e-9})


@pytest.mark.parametrize(
    "parameters", [BODY, LONG, {"rate": 0.5}, {**LONG, "method": "rkmk4", "max_step": 0.03}, {"rate": 59.94}]
)
def test_steps_are_counted_as_the_motion_takes_them(parameters: dict[str, object]) -> None:
    scenario = Scenario.from_parameters(parameters)
    method = METHODS[scenario.method]
    fastest = method.integrator(scenario.body(), scenario.start()).fastest
    _, counts = steps_to(np.array([round(1e9 / scenario.rate)]), 0, method.longest_step(scenario.max_step, fastest))
    # the scenario knows a bound of the body rate, the stepper its maximum
    assert counts[0] <= scenario.steps_per_sample() <= 1.3 * counts[0]
    assert Scenario.from_parameters({**parameters, "motion": "closed_form"}).steps_per_sample() == 1


def test_a_batch_is_bounded_by_its_samples_and_its_steps() -> None:
    scenario = Scenario.from_parameters({**BODY, "rate": 100.0, "max_step": 0.001})
    assert scenario.batch_size(250, 2000) == 200
    assert scenario.batch_size(100, 2000) == 100
    assert scenario.batch_size(250, 2) == 1
    assert scenario.batch_size(250, 2000, rate=1000.0) == 250
    fast = Scenario.from_parameters({**BODY, "rate": 0.001, "imu_rate": 50.0, "max_step": 0.001})
    assert fast.batch_size(250, 2000) == 100
    assert Scenario.from_parameters({"motion": "closed_form"}).batch_size(250, 1) == 1
    assert Scenario.from_parameters({"motion": "closed_form"}).batch_size(250, 250) == 250
    often = {"motion": "closed_form", "kicks": [0.5, 0.0, 0.0, 1.0], "kick_period": 1.0}
    assert Scenario.from_parameters({**often, "rate": 0.1}).batch_size(64, 64) == 1
    assert Scenario.from_parameters({**often, "rate": 100.0}).batch_size(64, 64) == 64


def test_the_bound_of_a_rate_whose_quotients_overflow_is_finite() -> None:
    """Of a rod without thickness: 2 H over its smallest moment is beyond doubles, the square root of that is not."""
    thin = {"inertia": [1e-300, 1.0, 1.0], "initial_body_rate": [1e9, 1e9, 1e9]}
    bound = Scenario.from_parameters({**thin, "motion": "closed_form"}).rate_bound()
    assert bound == pytest.approx(2.0**0.5 * 1e159, rel=1e-12)
    with pytest.raises(ParameterError) as refusal:
        Scenario.from_parameters({**thin, "motion": "moving_chart"})
    assert refusal.value.name == "initial_body_rate"
