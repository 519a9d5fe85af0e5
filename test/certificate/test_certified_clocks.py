"""Sensors whose clock errs: their stamps are turned back into times, and held, as are the readings, like others."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from phrases import telling
from sensor_bags import (
    ALL,
    BIAS,
    EPOCH,
    ERRING_CLOCKS,
    FORCE,
    IMU,
    MAG,
    MOTIONS,
    START,
    broken,
    certificate,
    recorded,
    write,
)
from tampering import Change, at, on, tamper

from foreign_bags import Message
from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.segments import SensorClocks
from lie_rigid_body.recording.topic_messages import TopicMessages
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import SampleClock, Segment
from sampled import sampled


@pytest.mark.parametrize(
    ("grade", "motion"),
    [("perfect", "dmv20"), ("navigation", "closed form"), ("tactical", "dmv20"), ("mems", "closed form")],
)
def test_resets_that_change_the_clock(tmp_path, grade, motion):
    """Also so that the same stamps come again, or are left out."""
    start: dict[str, object] = {**MOTIONS[motion], "sensor_grade": grade, **FORCE}
    stages = [
        ({**start, **ERRING_CLOCKS["all"]}, 0.4),
        ({**start, "imu_clock_offset": -0.3, "magnetometer_clock_skew": 0.01}, 0.4),
        ({**start, "rate": 80.0, "imu_rate": 300.0, "imu_clock_skew": 0.01}, 0.3),
        (start, 0.3),
    ]
    path = write(tmp_path / "a.mcap", *stages)
    for change, sensors in ((lambda ms: ms, ALL), (recorded(0.213, 0.06), ())):
        found = certificate(path, tmp_path, change)
        assert found.passed, found.messages
        assert found.sensors == sensors


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ({"imu_clock_offset": 0.2, "imu_latency": 0.1}, {"imu_latency": 0.1}),
        ({"imu_clock_skew": 0.01}, {"imu_clock_skew": 0.01, "rate": 30.0}),
    ],
)
def test_which_clock_shows_a_stamp_is_told_of_a_recorders_bag_as_not_certified(tmp_path, before, after):
    """Before the reset and after it the clocks show the very same stamps; the log times of an own bag tell which."""
    even: dict[str, object] = {"motion": "closed_form", "rate": 50.0, "imu_rate": 100.0, "magnetometer_rate": 10.0}
    path = write(tmp_path / "a.mcap", ({**even, **before}, 1.0), ({**even, **after}, 0.7))
    assert certify(Bag(path)).sensors == ALL
    found = certificate(path, tmp_path, recorded(0.0))
    assert found.passed, found.messages
    assert len(found.segments) == 2
    assert found.sensors == (MAG,)
    assert telling(found, "which clock", topic=IMU)


@pytest.mark.parametrize(
    "none_arrives",
    [
        {"imu_latency": 3.0},
        {"imu_latency": 0.5, "imu_latency_jitter": 3.0},
        {"imu_dropout_probability": 1.0},
        {"imu_outage_interval": 0.3, "imu_outage_duration": 0.3},
    ],
)
def test_a_clock_shows_no_stamp_of_a_reading_that_never_arrives(tmp_path, none_arrives):
    """It shows those of the readings after the reset, whose own clock is right."""
    even: dict[str, object] = {"motion": "closed_form", "rate": 50.0, "imu_rate": 100.0, "magnetometer_rate": 0.0}
    stages = (even, 0.3), ({**even, "imu_clock_offset": 0.2, **none_arrives}, 0.4), (even, 0.5)
    found = certify(Bag(tamper(write(tmp_path / "a.mcap", *stages), tmp_path / "b.mcap", recorded(0.0))))
    assert found.passed, found.messages
    assert len(found.segments) == 3


def test_a_reading_just_before_the_first_scenario_is_none_of_it(tmp_path):
    """A recorder began between it and a reset: half a period from the first reading, whose clock is known."""
    even: dict[str, object] = {
        "motion": "closed_form",
        "rate": 50.0,
        "magnetometer_rate": 0.0,
        "imu_clock_offset": 1e-6,
    }
    path = write(tmp_path / "a.mcap", ({**even, "imu_rate": 240.0}, 0.5), ({**even, "imu_rate": 100.0}, 0.5))

    def begun_just_before(messages: list[Message]) -> list[Message]:
        reset = max(i for i, m in enumerate(messages) if m.topic.endswith("scenario"))
        late = next(i for i in range(reset - 1, 0, -1) if messages[i].topic == IMU)
        return recorded(0.0)([messages[late], *messages[reset:]])

    found = certificate(path, tmp_path, begun_just_before)
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    whole: dict[str, object] = {**START, **ERRING_CLOCKS["all"], "imu_dropout_probability": 0.0}
    return write(path, (whole, 0.4), ({**whole, "initial_body_rate": [0.3, 1.0, 0.2]}, 0.395))


def moved(by_ns: int) -> Change:
    """A reading of the magnetometer with another stamp."""

    def move(message: Message) -> Message:
        sec, nanosec = struct.unpack("<iI", message.data[4:12])
        stamp = divmod(sec * 1_000_000_000 + nanosec + by_ns, 1_000_000_000)
        return message._replace(data=message.data[:4] + struct.pack("<iI", *stamp) + message.data[12:])

    return on(MAG, at(37, move))


@pytest.mark.parametrize("is_original", [True, False])
@pytest.mark.parametrize(
    "by_ns", sampled([1, -1, 1000, -10_000_000, 10_000_000, 10**9, -(10**18), -(10**9), 10**17], every=3)
)
def test_another_stamp_is_named(bag, tmp_path, by_ns, is_original):
    change, late = moved(by_ns), (lambda ms: ms) if is_original else recorded(0.1)
    found = certificate(bag, tmp_path, lambda ms: late(change(ms)))
    assert broken(found) & {"magnetometer stamps", "sensor stamps"}
    if abs(by_ns) <= 1000:
        stamped, right = (int(word) for word in found.messages[0].split() if word.isdigit() and len(word) == 19)
        assert stamped - right == by_ns
        assert right != EPOCH + round(37e9 / 70.0)


def test_the_right_reading_is_found_in_any_time_that_can_be_stamped():
    """With the fastest readings that are told apart, years after the epoch, and again after resets."""
    random = np.random.default_rng(5)
    for _ in range(50):
        epoch = int(random.integers(0, 2**30)) * 1_000_000_000 + int(random.integers(10**9))
        rate, skew = (
            float(random.choice([1.0, 333.3, 1e6, 9.9e6, 5e7])),
            float(random.choice([0.0, 1e-9, -0.01, 0.01, 0.003])),
        )
        given = {
            "rate": 1e-3,
            "imu_rate": rate,
            "imu_clock_skew": skew,
            "imu_clock_offset": float(random.uniform(-3, 3)),
        }
        scenario = Scenario.from_parameters({**given, "epoch_ns": epoch})
        segments = [Segment(scenario, k, epoch + k * 1_000_000_000_000) for k in (0, int(random.integers(1, 10**6)))]
        model = scenario.sensors.imu
        assert model is not None
        assert model.delivery is not None
        clock = SampleClock(epoch, rate)
        before = clock.count_until(segments[1].start_ns - 1)
        measured = clock.stamps_ns(before - 50 if before > 50 else 0, 100)
        stamps = model.delivery.stamps_ns(measured, epoch)
        numbers = clock.count_until(int(measured[0])) - 1 + np.arange(100)
        for shift in (0, 1, -1):
            rows = np.arange(float(len(stamps)))[:, np.newaxis]
            messages = TopicMessages(measured, stamps + shift, rows, (("", b""),), np.zeros_like(stamps))
            for in_order in (True, False):
                placed = list(SensorClocks(segments, "imu").placed(messages, in_order=in_order))
                assert [part.place for part in placed] == sorted({int(t >= segments[1].start_ns) for t in measured})
                for part in placed:
                    assert (part.numbers == numbers[part.messages.values[:, 0].astype(np.int64)]).all()
                    assert (part.times_ns == measured[part.messages.values[:, 0].astype(np.int64)] + shift).all()
