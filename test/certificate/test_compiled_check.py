"""A bag that is judged by compiled loops gets the certificate that it gets in Python, to the bit."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from tampering import at, flipped, on, rotated, scaled_rate, tamper
from test_streaming import honest  # noqa: F401

from lie_rigid_body.certificate import certify, residuals
from lie_rigid_body.certificate.residuals import Residuals
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.recording.bag_writer import BagWriter, write_run
from lie_rigid_body.recording.topic_messages import TopicMessages
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from sampled import sampled

CHUNK_BYTES = 20_000
"""So little that a bag has many chunks."""
SENSORS = {"imu": 100.0, "magnetometer": 25.0, "attitude_sensor": 10.0, "sun_sensor": 5.0}
KERNELS = {residuals: ("WORK",)}


@pytest.fixture(scope="module", autouse=True)
def compiled():
    pytest.importorskip("numba")
    assert all(getattr(module, name).compile() for module, names in KERNELS.items() for name in names)


@pytest.fixture
def in_python(monkeypatch):
    """A function after which nothing runs compiled."""

    def forget() -> None:
        for module, names in KERNELS.items():
            for name in names:
                monkeypatch.setattr(getattr(module, name), "_compiled", None)
                monkeypatch.setattr(getattr(module, name), "_may_compile", False)

    return forget


def renamed_frame(message):
    return message._replace(data=message.data.replace(b"world", b"wurld"))


CHANGES = {
    "honest": lambda ms: ms,
    "gap": on("/pose", lambda ms: [*ms[:300], *ms[317:]]),
    "doubled": on("/twist", lambda ms: [*ms[:301], *ms[300:]]),
    "flipped": on("/pose", at(511, flipped)),
    "turned": on("/pose", at(4, rotated(1e-6, np.array([1.0, 2.0, 3.0])))),
    "scaled": on("/twist", at(77, scaled_rate(1 + 1e-12))),
    "not a number": on("/twist", at(78, scaled_rate(np.nan))),
    "another frame": on("/pose", at(300, renamed_frame)),
}


@pytest.mark.parametrize("change", sampled(CHANGES, every=5))
def test_the_certificate_is_that_of_python(honest, tmp_path, in_python, change):  # noqa: F811
    path = tamper(honest, tmp_path / "changed.mcap", CHANGES[change], CHUNK_BYTES)
    quick = certify(Bag(path))
    assert repr(Bag(path).load().poses) == repr(read_bag(path).poses)
    in_python()
    plain = certify(Bag(path))
    assert plain == quick or change == "not a number"
    assert [law.message for s in plain.segments for law in s.laws] == [
        law.message for s in quick.segments for law in s.laws
    ]


@pytest.fixture(scope="module")
def sensed(tmp_path_factory):
    """A bag of four seconds with all sensors whose readings laws speak of."""
    rates = {f"{name}_rate": rate for name, rate in SENSORS.items()}
    noise = {"gyro_bias_random_walk": 1e-3, "accelerometer_noise_density": 1e-2, "magnetometer_noise_density": 1e-8}
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form", **rates, **noise}))
    path = tmp_path_factory.mktemp("bags") / "sensed.mcap"
    with BagWriter(path, stamped_twist=True, chunk_size=30_000) as bag:
        for _ in write_run(bag, simulation, 4 * NS - 1):
            pass
    return path


def with_number(number, value):
    """A change of one of the numbers at the end of a message, which counts from behind."""

    def change(message):
        at = len(message.data) + 8 * number
        return message._replace(data=message.data[:at] + struct.pack("<d", value) + message.data[at + 8 :])

    return change


SENSED_CHANGES = {
    "honest": lambda ms: ms,
    "another frame": on("/imu/bias", at(100, lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lynk")))),
    "a covariance": on("/imu/data_raw", at(250, with_number(-1, 1e-3))),
    "a reading": on("/imu/mag", at(33, with_number(-12, 1.0))),
    "not a number": on("/imu/data_raw", at(9, with_number(-12, np.nan))),
    "gap": on("/attitude/pose", lambda ms: [*ms[:20], *ms[23:]]),
    "swapped": on("/sun/direction", lambda ms: [*ms[:10], ms[11], ms[10], *ms[12:]]),
}


def sensor_readings(recording):
    return {name: found for name, found in recording.readings.items() if isinstance(found, TopicMessages)}


@pytest.mark.parametrize("change", SENSED_CHANGES)
def test_sensors_are_read_and_judged_as_in_python(sensed, tmp_path, in_python, change):
    path = tamper(sensed, tmp_path / "changed.mcap", SENSED_CHANGES[change], CHUNK_BYTES)
    quick, found = certify(Bag(path)), sensor_readings(Bag(path).load())
    assert quick.passed == (change == "honest")
    in_python()
    certificate, expected = certify(Bag(path)), sensor_readings(read_bag(path))
    assert repr(certificate.segments) == repr(quick.segments)
    assert (certificate.messages, certificate.sensors) == (quick.messages, quick.sensors)
    assert found.keys() == expected.keys()
    assert len(found) == 5
    for name, readings in found.items():
        for column in ("log_times_ns", "stamps_ns", "values"):
            np.testing.assert_array_equal(getattr(readings, column), getattr(expected[name], column))
        assert [readings.kinds[k] for k in readings.kind] == [expected[name].kinds[k] for k in expected[name].kind]


def test_files_that_continue_each_other_are_one_bag(honest, tmp_path, in_python):  # noqa: F811
    folder = tmp_path / "walk"
    folder.mkdir()
    for i, part in enumerate((slice(0, 900), slice(900, 901), slice(901, None))):
        tamper(honest, folder / f"walk_{i}.mcap", lambda ms, part=part: ms[part])  # type: ignore[misc]
    whole = tamper(honest, tmp_path / "whole.mcap", lambda ms: ms)
    quick = certify(Bag(folder))
    assert quick.passed
    assert quick.segments == certify(Bag(whole)).segments
    in_python()
    assert certify(Bag(folder)) == quick


def test_residuals_have_the_bits_of_arrays(in_python):
    rng = np.random.default_rng(3)
    attitude = rng.normal(size=(50, 4))
    states = State.trusted(attitude / np.linalg.norm(attitude, axis=1)[:, None], rng.normal(size=(50, 3)))
    other = State.trusted(np.roll(states.attitude_xyzw, 1, axis=0), states.body_rate)
    body, spans = RigidBody([1.0, 0.05, 0.02, 1.4, 0.1, 1.9]), rng.uniform(0.0, 0.4, 49)
    found = [Residuals.of(body, states, other, spans, 5.0, 0.4)]
    in_python()
    found.append(Residuals.of(body, states, other, spans, 5.0, 0.4))
    for name, value in vars(found[0]).items():
        np.testing.assert_array_equal(value, getattr(found[1], name), err_msg=name)
