"""The truth about faults that a bag tells is held against what its scenarios make: any other message is named."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from phrases import telling
from sensor_bags import EPOCH, EVERY, IMU, LATE, LATER, LOST, START, broken, certificate, recorded, write
from tampering import at, declared, on

from foreign_bags import Message, messages_of
from lie_rigid_body.certificate import Certificate, LawResult, certify
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation import Simulation

FAULTS = "/lie_rigid_body/faults"
OTHER: dict[str, object] = {
    **START,
    "gyro_spike_probability": 0.1,
    "magnetometer_temperature_drift": 1e-6,
    "rate": 33.0,
}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    return write(path, ({**START, **EVERY, **LATER, **LOST, **LATE}, 0.41), (START, 0.2), (OTHER, 0.28))


def law(found: Certificate) -> LawResult:
    return next(law for law in found.whole if law.name == "faults")


def test_honest_messages_are_certified(bag, tmp_path):
    found = certify(Bag(bag))
    assert found.passed, found.messages
    assert law(found).checked > 50
    assert not any(FAULTS in text for text in found.not_certified)
    assert certify(read_bag(bag)) == found


@pytest.mark.parametrize("begin", [0.0, 0.213, 0.5])
def test_those_of_a_recorder_are_certified_from_its_first_one_on(bag, tmp_path, begin):
    """It may lack the first scenario as well, and hear again of what it knows."""
    late, scenario = recorded(begin, 0.06), "/lie_rigid_body/scenario"

    def change(ms: list[Message]) -> list[Message]:
        told = [m for m in ms if m.topic == FAULTS and m.log_time >= EPOCH + 0.2e9]
        rest = [m for m in late(ms) if m.topic not in (FAULTS, scenario)]
        known = [m for m in ms if m.topic == scenario]
        return sorted([*rest, *known, *told, *told[3:5]], key=lambda m: m.log_time)

    found = certificate(bag, tmp_path, lambda ms: [m._replace(log_time=m.log_time + 777) for m in change(ms)])
    assert found.passed, found.messages
    assert telling(found, "faults again", count=2)
    gap = certificate(
        bag, tmp_path, lambda ms: [m._replace(log_time=m.log_time + 777) for m in on(FAULTS, without(9))(change(ms))]
    )
    assert broken(gap) == {"faults"}


def without(index: int) -> Callable[[list[Message]], list[Message]]:
    return lambda ms: [*ms[:index], *ms[index:][1:]]


def retold(**changes: object) -> Callable[[Message], Message]:
    """The same message with other fields of its fault."""

    def change(message: Message) -> Message:
        fault = Fault.from_json(message.data[8:-1].decode())
        return message._replace(data=encode_string(Fault(**{**vars(fault), **changes}).to_json()))

    return change


CHANGED: dict[str, dict[str, object]] = {
    "kind": {"kind": "dropout"},
    "sensor": {"sensor": "sun_sensor"},
    "axis": {"axis": "y"},
    "begin": {"begin_ns": EPOCH + 1},
    "end": {"end_ns": EPOCH + 1},
    "size": {"size": 1.0000001},
    "never": {"begin_ns": 2**62},
    "before": {"begin_ns": -(2**62)},
}


@pytest.mark.parametrize(
    ("index", "field"),
    [
        pytest.param(index, field, marks=pytest.mark.slow if (number + turn) % 3 else ())
        for turn, index in enumerate([0, 20, -2])
        for number, field in enumerate(CHANGED)
    ],
)
def test_another_field_is_named(bag, tmp_path, field, index):
    index %= count(bag)
    found = certificate(bag, tmp_path, on(FAULTS, at(index, retold(**CHANGED[field]))))
    assert "faults" in broken(found)
    assert law(found).sample == index or field in ("begin", "never", "before")


def count(bag: Path) -> int:
    return len([m for m in messages_of(bag) if m.topic == FAULTS])


@pytest.mark.parametrize("index", [0, 20, -1])
def test_a_missing_doubled_swapped_or_unreadable_message_is_named(bag, tmp_path, index):
    index %= count(bag)
    for change, what, message in (
        (without(index), "fault missing", None),
        (at(index, retold(sensor="sun_sensor")), "fault unknown", index),
        (lambda ms: [*ms[: index + 1], *ms[index:]], "fault twice", index + 1),
        (lambda ms: [*ms[: index - 1], ms[index], ms[index - 1], *ms[index + 1 :]], "faults out of order", None),
        (at(index, lambda m: m._replace(data=encode_string("{}"))), "no fault", index),
    ):
        if index > 20 or what != "faults out of order":  # before that faults begin at one time, in any order
            found = certificate(bag, tmp_path, on(FAULTS, change))
            assert broken(found) <= {"faults", "log times"}
            assert telling(found, what, topic=FAULTS, message=message) == [found.messages[-1]]


def test_a_topic_that_was_taken_away_is_missed(bag, tmp_path):
    found = certificate(bag, tmp_path, lambda ms: [m for m in ms if m.topic != FAULTS])
    assert broken(found) == {"faults"}
    late = recorded(0.1)
    found = certificate(bag, tmp_path, lambda ms: late([m for m in ms if m.topic != FAULTS]))
    assert found.passed, found.messages
    assert "faults" not in {law.name for law in found.whole}


def test_the_last_ones_cut_off_are_missed(bag, tmp_path):
    end = messages_of(bag)[-1].log_time
    cut = on(FAULTS, lambda ms: [m for m in ms if m.log_time < end - 50_000_000])
    assert broken(certificate(bag, tmp_path, cut)) == {"faults"}


def test_a_size_of_another_library_is_the_same_but_for_its_last_bits(bag, tmp_path):
    for bits, names in ((1, set()), (2000, {"faults"})):

        def change(message: Message, bits: int = bits) -> Message:
            fault = Fault.from_json(message.data[8:-1].decode())
            if fault.kind != "temperature_drift" or fault.size is None:
                return message
            return retold(size=fault.size + bits * np.spacing(1e-6))(message)

        found = certificate(bag, tmp_path, on(FAULTS, lambda ms: list(map(change, ms))))
        assert broken(found) == names


def test_messages_are_logged_when_the_fault_begins(bag, tmp_path):
    found = certificate(bag, tmp_path, on(FAULTS, at(9, lambda m: m._replace(log_time=m.log_time + 1))))
    assert "log times" in broken(found)


def test_other_faults_that_a_scenario_declares_are_caught(bag, tmp_path):
    assert "faults" in broken(certificate(bag, tmp_path, declared(gyro_noise_burst_interval=0.21)))
    older = declared(software="lie_rigid_body 0.0.9")
    found = certificate(bag, tmp_path, lambda ms: on(FAULTS, without(3))(older(ms)))
    assert found.passed, found.messages
    assert telling(found, "another version", software="lie_rigid_body 0.0.9")
    assert IMU not in found.sensors


def test_readings_that_arrive_after_the_last_stamp_of_ros_are_certified(tmp_path: Path) -> None:
    """Their faults were looked for up to a time that the search did not reach."""
    scenario = Scenario.from_parameters({"imu_rate": 100.0, "imu_latency": 0.5, "rate": 10.0})
    simulation = Simulation(scenario, MAX_EPOCH_NS - NS)
    with BagWriter(tmp_path / "last.mcap", stamped_twist=True) as bag, suppress(ParameterError):
        bag.begin_segment(simulation.segment)
        encoder = BatchEncoder(simulation.segment.scenario)
        while True:
            bag.write(encoder.encode(simulation.take_until(MAX_EPOCH_NS + NS, 40)))
    found = certify(tmp_path / "last.mcap")
    assert found.passed, found.messages
    assert max(message.log_time for message in messages_of(tmp_path / "last.mcap")) > MAX_EPOCH_NS
