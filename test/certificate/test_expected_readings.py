"""The readings that a scenario determines: where one may be a step beside, and biases computed only once."""

from __future__ import annotations

import numpy as np
from sensor_bags import BODY, NOISY, RATES

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate.imu_readings import BiasReadings, ImuReadings
from lie_rigid_body.certificate.readings import Expected
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Imu
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.simulation import Simulation


def test_a_step_is_allowed_only_where_the_truth_may_be_on_either_side():
    step = Converter(0.5, 2.0)
    signal = np.array([[0.2499999, 0.2, 3.0]])
    expected = Expected(signal, np.full_like(signal, 1e-6), step)
    for recorded_, holds in (
        ([0.0, 0.0, 2.0], True),
        ([0.5, 0.0, 2.0], True),
        ([0.25, 0.0, 2.0], False),
        ([-0.5, 0.0, 2.0], False),
        ([0.0, 0.5, 2.0], False),
        ([0.0, 0.0, 2.5], False),
        ([0.0, np.nan, 2.0], False),
    ):
        residuals, limits = expected.residuals(np.array([recorded_]))
        assert bool((residuals <= limits).all()) == holds, recorded_


def test_biases_are_the_same_with_the_readings_beside_them_and_alone():
    segment = Simulation(Scenario.from_parameters({**BODY, **RATES, **NOISY, "sensor_seed": 17})).segment
    alone, beside, readings = (of(segment, 9.0) for of in (BiasReadings, BiasReadings, ImuReadings))
    first, drawn = alone.next, []

    def draw(elapsed: Integers) -> tuple[Array, Array]:
        drawn.append(len(elapsed))
        return Imu.biases(beside._sensor, elapsed)

    beside._sensor.biases = draw
    wanted = [alone.take(first + begin, count) for begin, count in ((0, 90), (90, 200), (300, 10), (320, 60))]
    readings.take(first + 50, 50)
    readings = ImuReadings(segment, 9.0)
    readings.take(first, 100)
    found = [beside.take(first, 90)]
    readings.take(first + 100, 190)
    found += [beside.take(first + 90, 200)]
    assert not drawn
    readings.take(first + 310, 80)
    found += [beside.take(first + 300, 10)]
    assert drawn == [10]
    found += [beside.take(first + 320, 60)]
    assert drawn == [10]
    for one, other in zip(wanted, found, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.signal.tobytes() == b.signal.tobytes()
            assert a.uncertainty.tobytes() == b.uncertainty.tobytes()
