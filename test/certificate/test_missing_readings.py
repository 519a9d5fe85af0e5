"""Readings that are missing, some or all of a sensor: a broken law, unless its faults, or a recorder, explain it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest
from phrases import refused, telling
from sensor_bags import BIAS, IMU, MAG, broken, certificate, recorded, write
from tampering import Change, on, with_numbers

from foreign_bags import Message
from lie_rigid_body.certificate import certify, sensor_topics
from lie_rigid_body.recording.bag_reader import Bag

START: dict[str, object] = {"motion": "closed_form", "imu_rate": 40.0, "magnetometer_rate": 30.0}
SILENT: dict[str, dict[str, object]] = {
    "lost": {"magnetometer_dropout_probability": 1.0},
    "an outage": {"magnetometer_outage_interval": 1.0, "magnetometer_outage_duration": 1.0},
    "under way": {"magnetometer_latency": 9.0},
}
FAULTS = "/lie_rigid_body/faults"


def cut_out(*topics: str, since_ns: int = 0) -> Change:
    return lambda ms: [m for m in ms if m.topic not in topics or m.log_time < since_ns]


@pytest.mark.parametrize("why", SILENT)
def test_a_sensor_that_its_faults_silence_is_mentioned(tmp_path, why):
    given = {**START, **SILENT[why]}
    found = certify(Bag(write(tmp_path / "a.mcap", (given, 0.4), (START, 0.3), (given, 0.35))))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
    [said] = found.segments[0].notes
    assert said in telling(found, "none arrives" if why == "under way" else "all lost", topic=MAG, count=13)
    assert [len(segment.notes) for segment in found.segments] == [1, 0, 1]
    never = certify(Bag(write(tmp_path / "never.mcap", (given, 0.4))))
    assert never.passed, never.messages
    assert never.sensors == (IMU, BIAS)
    assert telling(never, "silent", topic="imu/mag")


@pytest.mark.parametrize(("topics", "law"), [((MAG,), "magnetometer stamps"), ((IMU, BIAS), "IMU stamps")])
def test_a_sensor_that_was_cut_out_is_missed(tmp_path, topics, law):
    path = write(tmp_path / "a.mcap", (START, 0.4), ({**START, "sensor_seed": 2}, 0.4))
    found = certificate(path, tmp_path, cut_out(*topics))
    assert broken(found) == {law}
    assert not any(segment.notes for segment in found.segments)
    second = found.segments[1].segment.start_ns
    found = certificate(path, tmp_path, cut_out(*topics, since_ns=second))
    assert broken(found) == {law}
    assert all(said.startswith("segment 2: ") for said in found.messages)


def test_a_sensor_of_which_a_recorder_has_nothing_is_mentioned(tmp_path):
    path, late = write(tmp_path / "a.mcap", (START, 0.4), (START, 0.4)), recorded(0.1)
    found = certificate(path, tmp_path, lambda ms: late(cut_out(MAG)(ms)))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS)
    second = certify(Bag(path)).segments[1].segment.start_ns
    found = certificate(path, tmp_path, lambda ms: late([m for m in ms if m.topic != MAG or m.log_time > second]))
    assert found.passed, found.messages
    assert [sum(MAG in note for note in segment.notes) for segment in found.segments] == [1, 0]


@pytest.mark.parametrize(("topic", "law"), [(MAG, "magnetometer stamps"), (IMU, "IMU stamps"), (BIAS, "IMU stamps")])
def test_a_topic_that_a_recorder_lost_before_a_reset_ends_there(tmp_path, topic, law):
    """As before the end of the bag: what is missing between its messages is a gap all the same, and in an own bag."""
    path, late = write(tmp_path / "a.mcap", *[(START, 0.4)] * 3), recorded(0.1)
    second = certify(Bag(path)).segments[1].segment.start_ns
    ends = partial(keep, topic, lambda time_ns: time_ns < second - 150_000_000)
    found = certificate(path, tmp_path, lambda ms: late(ends(ms)))
    assert found.passed, found.messages
    notes = [[note for note in segment.notes if topic in note] for segment in found.segments]
    assert [len(own) for own in notes] == [1, 1, 1]
    assert notes[0] == telling(found, "ends", topic=topic)[:1]
    assert notes[1][0] in telling(found, "recorder lacks", topic=topic)
    assert broken(certificate(path, tmp_path, ends)) == {law}
    missing = partial(keep, topic, lambda time_ns: abs(time_ns - second) > 150_000_000)
    assert broken(certificate(path, tmp_path, lambda ms: late(missing(ms)))) == {law}


def test_a_recorder_may_lose_the_truth_long_before_a_sensor_that_loses_readings(tmp_path):
    given = {**START, "magnetometer_dropout_probability": 0.3}
    path, late = write(tmp_path / "a.mcap", (given, 2.5)), recorded(0.1)
    found = certify(Bag(path))
    since = found.segments[0].segment.start_ns + 500_000_000
    found = certificate(
        path, tmp_path, lambda ms: late([m for m in ms if m.topic not in ("/pose", "/twist") or m.log_time < since])
    )
    assert found.passed, found.messages
    assert found.segments[0].samples < 100


def test_a_reset_that_takes_a_sensor_away_leaves_its_readings_out_if_the_bag_ends_before_the_next_sample(tmp_path):
    """The other sensor goes on until the sample that does not come any more."""
    slow: dict[str, object] = {**START, "rate": 0.2}
    found = certify(write(tmp_path / "a.mcap", (slow, 7.0), ({**slow, "imu_rate": 0.0}, 1.0)))
    assert found.passed, found.messages
    assert len(found.segments) == 1
    for topic in (IMU, BIAS):  # of both more may have been sent
        assert telling(found, "ends", topic=topic)


def keep_truth(until_ns: int) -> Change:
    return lambda ms: [m for m in ms if m.topic not in ("/pose", "/twist") or m.log_time < until_ns]


@pytest.mark.parametrize("change", [lambda ms: ms, recorded(0.1)])
def test_readings_under_a_scenario_without_a_sample_are_judged(tmp_path, change):
    """As of a bag that lost its truth, or of a forger who cut it out, behind the last reset."""
    path = write(tmp_path / "a.mcap", (START, 0.4), ({**START, "sensor_seed": 2}, 0.4))
    second = certify(Bag(path)).segments[1].segment.start_ns
    cut = keep_truth(second)
    found = certificate(path, tmp_path, lambda ms: change(cut(ms)))
    assert found.passed, found.messages
    assert len(found.segments) == 1
    assert {law.name for law in found.whole} >= {"gyro", "magnetometer", "IMU stamps"}
    for topic, numbers, law in ((IMU, 24, "gyro"), (MAG, 12, "magnetometer")):
        off = on(topic, partial(shifted, numbers))
        found = certificate(path, tmp_path, partial(lambda off, ms: change(cut(off(ms))), off))
        assert law in broken(found)
        assert found.segments[0].passed


def shifted(numbers: int, messages: list[Message]) -> list[Message]:
    return [*messages[:-5], with_numbers(messages[-5], numbers, lambda x: x + 1e-6), *messages[-4:]]


def keep(topic: str, when: Callable[[int], bool], messages: list[Message]) -> list[Message]:
    return [m for m in messages if m.topic != topic or when(m.log_time)]


def test_a_recorder_that_came_too_late_for_a_replay_is_refused(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(sensor_topics, "MAX_MISSING", 20)
    with refused("too many missing", topic=IMU, count=100, number=100):
        certificate(bag, tmp_path, recorded(0.3))


def test_poses_that_a_recorder_has_no_twist_of_are_told(bag, tmp_path):
    late, few, poses = recorded(0.1), on("/twist", lambda ms: ms[:20]), list[int]()

    def change(ms):
        left = few(late(ms))
        poses.append(sum(m.topic == "/pose" for m in left))
        return left

    found = certificate(bag, tmp_path, change)
    assert found.passed, found.messages
    assert telling(found, "samples in half", count=poses[0] - 20)
