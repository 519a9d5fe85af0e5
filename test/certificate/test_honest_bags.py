"""Honest bags are certified: every scenario that comes with the package, with every stepper, grade and fault."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
import scipy.special
from phrases import PHRASES
from sensor_bags import CLOCKS, EPOCH, EVERY, LATE, LATER, LOST, certificate, recorded
from tampering import at, declared, on, with_numbers

from lie_rigid_body import simulate
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import METHODS
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.report.certificates import as_json, as_table
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files
from lie_rigid_body.sensors import GRADES
from sampled import sampled

U = 2.0**-53
STEPPERS = ["closed_form", *(name for name, method in METHODS.items() if method.order >= 4)]
"""The motions that stay a ground truth with steps of 1 ms."""
FAULTS: dict[str, dict[str, object]] = {
    "none": {},
    "axes": EVERY,
    "late": LATE,
    "lost": LOST,
    "clocks": CLOCKS,
    "all": {**EVERY, **LATE, **LOST, **CLOCKS},
}
KINDS = list(itertools.product(GRADES, FAULTS, ("instantaneous", "integrated")))
PAIRS = list(itertools.product(scenario_files(), STEPPERS))
CASES = [(*pair, *KINDS[(7 * i) % len(KINDS)]) for i, pair in enumerate(PAIRS)]
"""Every scenario with every stepper, and in turn with every grade, faults and kind of gyro."""


@pytest.mark.parametrize(("scenario", "stepper", "grade", "faults", "gyro_rate"), sampled(CASES, every=23))
def test_honest_bags_are_certified(tmp_path, scenario, stepper, grade, faults, gyro_rate):
    motion = {"motion": stepper} if stepper == "closed_form" else {"motion": "moving_chart", "method": stepper}
    if stepper not in ("closed_form", "dmv20"):
        motion["max_step"] = 0.00025  # the fastest body here turns by 0.01 rad in it
    given = {**LATER, **FAULTS[faults], **motion, "sensor_grade": grade, "gyro_rate": gyro_rate, "epoch_ns": 10**18}
    rates = {"imu_rate": 111.0, "magnetometer_rate": 40.0, "accelerometer_mode": "pivot_gravity"}
    simulate(scenario, duration=2.0, **{**rates, **given}).to_bag(tmp_path / "a.mcap")
    found = certify(Bag(tmp_path / "a.mcap"))
    assert found.passed, found.messages
    assert len(found.sensors) == 5


class Elsewhere:
    """An exact motion as another library might compute it: states 1e-15 rad and 12 roundings off."""

    def __init__(self, motion):
        self._motion, self._random = motion, np.random.default_rng(1)

    def at(self, t_ns):
        """The states at some times, moved."""
        states = self._motion.at(t_ns)
        turns, change = (self._random.normal(size=states.body_rate.shape) for _ in range(2))
        turns *= 1e-15 / vectors.norm(turns)[..., np.newaxis]
        change *= (12.0 * U * vectors.norm(states.body_rate) / vectors.norm(change))[..., np.newaxis]
        attitude = quaternion.multiply(states.attitude_xyzw, quaternion.exp(turns))
        return State.trusted(attitude, states.body_rate + change)


@pytest.mark.parametrize("faults", ["none", "axes"])
@pytest.mark.parametrize("gyro_rate", ["instantaneous", "integrated"])
def test_readings_of_another_library_are_certified(tmp_path, monkeypatch, gyro_rate, faults):
    """With normal deviates up to 16 roundings off, also those that a walk sums up, and the states moved."""
    ndtri, exact, random = scipy.special.ndtri, Scenario.exact_motion, np.random.default_rng(2)
    given = {**LATER, **FAULTS[faults], "sensor_grade": "mems", "gyro_rate": gyro_rate, "motion": "closed_form"}
    rates = {"imu_rate": 500.0, "magnetometer_rate": 100.0, "gyro_resolution": 0.0, "accelerometer_resolution": 0.0}
    simulate("tumbling_cubesat", duration=8.0, **{**rates, **given}).to_bag(tmp_path / "a.mcap")

    def moved(x, out=None):
        deviates = ndtri(x, out=out)
        return np.multiply(deviates, 1.0 + 16.0 * U * random.uniform(-1.0, 1.0, deviates.shape), out=out)

    monkeypatch.setattr(scipy.special, "ndtri", moved)
    monkeypatch.setattr(Scenario, "exact_motion", lambda self: Elsewhere(exact(self)))
    found = certify(Bag(tmp_path / "a.mcap"))
    broken = [law for segment in found.segments for law in segment.laws if not law.holds]
    assert not broken, found.messages
    assert sum(law.worst > 0.0 for segment in found.segments for law in segment.laws if law.unit != "ns") > 8


@pytest.mark.parametrize("sensor", ["imu", "magnetometer", "attitude_sensor", "sun_sensor"])
def test_a_reading_is_certified_whose_successor_would_have_no_stamp(tmp_path, sensor):
    """The one reading stands half a period of its sensor, and more, before the end of all stamps."""
    given: dict[str, Any] = {f"{sensor}_rate": 1e-3, "motion": "closed_form", "epoch_ns": MAX_EPOCH_NS - 49 * 10**9}
    simulate(duration=1.0, **given).to_bag(tmp_path / "a.mcap")
    assert certify(Bag(tmp_path / "a.mcap")).passed


def test_a_bag_that_is_replayed_to_the_bit_says_so(tmp_path):
    given: dict[str, Any] = {"imu_rate": 50.0, "magnetometer_rate": 20.0, "sensor_grade": "mems", "epoch_ns": 10**18}
    path = tmp_path / "a.mcap"
    simulate("tumbling_cubesat", duration=2.0, motion="closed_form", **given).to_bag(path)
    found = certify(Bag(path))
    assert (found.passed, found.to_the_bit) == (True, True)
    bias_free = tmp_path / "bias_free.mcap"
    simulate("tumbling_cubesat", duration=2.0, motion="closed_form", imu_rate=50.0, epoch_ns=EPOCH).to_bag(bias_free)
    told: Any = as_json("a", found)["certified"]
    assert told["to_the_bit"] is True
    last_bit = on("/imu/bias", at(7, lambda m: with_numbers(m, 24, lambda x: np.append(np.nextafter(x[:3], 9), x[3:]))))
    other = certificate(path, tmp_path, last_bit)
    assert (other.passed, other.to_the_bit) == (True, False)
    assert PHRASES["not to the bit"] in as_table("b", other)
    last_bit = on("/twist", at(7, lambda m: with_numbers(m, 3, lambda x: np.nextafter(x, 9))))
    assert certificate(path, tmp_path, last_bit).to_the_bit is False
    zero = on("/imu/bias", at(7, lambda m: with_numbers(m, 24, lambda x: np.append(-0.0 * x[:3], x[3:]))))
    signed = certificate(bias_free, tmp_path, zero)
    assert (certify(Bag(bias_free)).to_the_bit, signed.passed, signed.to_the_bit) == (True, True, False)
    late = certificate(bias_free, tmp_path, recorded(1.0))
    assert (late.passed, late.to_the_bit) == (True, True)
    older = certificate(path, tmp_path, declared(software="lie_rigid_body 0.0.9"))
    assert (older.passed, older.to_the_bit) == (True, None)
    simulate("tumbling_cubesat", duration=2.0, **given).to_bag(tmp_path / "e.mcap")
    assert certify(Bag(tmp_path / "e.mcap")).to_the_bit is None
