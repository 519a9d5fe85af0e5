"""Every kind of tampering is caught by the laws it breaks, and named with its place."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from bags import write_bag
from phrases import telling
from sensor_bags import broken, certificate, write
from tampering import at, declared, on, tamper

from foreign_bags import Message
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.scenario import Scenario
from said import numbers

SCENARIO = "/lie_rigid_body/scenario"
COUNT = 300


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bags") / "honest.mcap", COUNT)


@pytest.fixture
def two_segments(tmp_path):
    start = {"motion": "closed_form", "rate": 100.0, "imu_rate": 0.0, "magnetometer_rate": 0.0}
    return write(tmp_path / "two.mcap", (start, 0.195), ({**start, "initial_body_rate": [1.0, 0.0, 0.5]}, 0.3))


def test_inertia_given_by_hand(bag):
    assert Scenario().inertia == (1.0, 2.0, 3.0)
    assert not certify(read_bag(bag), [1.5, 2.25, 3.0]).passed


def test_an_inertia_that_is_used_instead_is_told(bag, tmp_path):
    """The bag goes on to say the other one to whoever reads it."""
    plain = certify(read_bag(bag))
    path = tamper(bag, tmp_path / "tampered.mcap", declared(inertia=[1.0, 2.0, 2.97]))
    instead = certify(read_bag(path), plain.segments[0].segment.scenario.inertia)
    assert not certify(read_bag(path)).passed
    assert instead.passed
    assert len(instead.not_certified) == len(plain.not_certified) + 1
    assert len(instead.uncovered) == len(plain.uncovered) + 1


@pytest.mark.parametrize("inertia", [5, "1,2,3", [1.0, 2.0], [1.0, 1.0, 5.0], [1.0, np.nan, 1.0], np.eye(3), {}])
def test_no_bag_is_accused_of_an_inertia_given_by_hand_that_no_body_has(bag, inertia):
    with pytest.raises(ParameterError) as caught:
        certify(read_bag(bag), inertia)
    assert caught.value.name == "inertia"


def without_first(count: int):
    cut = lambda ms: ms[count:]  # noqa: E731
    return lambda messages: on("/twist", cut)(on("/pose", cut)(messages))


def test_a_beginning_that_is_declared_away_in_every_field(bag, tmp_path):
    """The motion from sample 5 on is a true one."""
    whole = read_bag(bag)
    start = whole.poses.stamps_ns[5].item()
    later = declared(
        first_sample=5,
        start_ns=start,
        initial_attitude_xyzw=whole.poses.values[5, 3:].tolist(),
        initial_body_rate=whole.twists.values[5, 3:].tolist(),
    )
    late = on(SCENARIO, at(0, lambda m: m._replace(log_time=start)))
    found = certificate(bag, tmp_path, lambda ms: late(later(without_first(5)(ms))))
    assert "declaration" in broken(found)
    assert telling(found, "late beginning", sample=5)


def test_a_scenario_logged_at_another_time(bag, tmp_path):
    """Log times are a law of a bag of this package, whatever they are; those of a recorder are said not to be."""
    later = on(SCENARIO, at(0, lambda m: m._replace(log_time=m.log_time + 1)))
    foreign = tamper(bag, tmp_path / "later.mcap", later)
    found = certify(read_bag(foreign))
    assert found.passed
    assert telling(found, "recorder's log times")
    assert broken(certify(replace(read_bag(foreign), library="lie_rigid_body 9"))) == {"log times"}


def test_a_segment_robbed_of_all_its_samples(two_segments, tmp_path):
    found = certificate(two_segments, tmp_path, without_first(20))
    assert broken(found) == {"stamps"}
    assert numbers(found.messages[0])[:4] == [1, 20, 0, 19]


def test_a_segment_that_does_not_follow_the_clock_before_it(two_segments, tmp_path):
    def shifted(message: Message) -> Message:
        content = json.loads(message.data[8:-1])
        content |= {"epoch_ns": content["epoch_ns"] + 3, "start_ns": content["start_ns"] + 3}
        return message._replace(data=encode_string(json.dumps(content)))

    found = certificate(two_segments, tmp_path, on(SCENARIO, at(1, shifted)))
    assert "declaration" in broken(found)
    assert telling(found, "another clock")


def test_a_recorders_gap_is_told_as_one_and_as_the_recorders(bag, tmp_path):
    def recorded(messages: list[Message]) -> list[Message]:
        return [m._replace(log_time=m.log_time + 12_345) for m in messages]

    lost = on("/pose", lambda ms: [*ms[:100], *ms[141:]])
    begin = on("/twist", lambda ms: ms[3:])
    found = certificate(bag, tmp_path, lambda ms: recorded(begin(lost(ms))))
    assert broken(found) == {"stamps"}
    [segment] = found.segments
    law = segment.law("stamps")
    assert (law.worst, law.unit, law.sample) == (41, "gap", 100)
    assert law.stamp_ns == segment.segment.clock().stamp_ns(100)
    assert len(segment.notes) == 2
    own = certificate(bag, tmp_path, lost)
    assert (own.segments[0].law("stamps").worst, own.segments[0].notes) == (41, ())


def cut_off_without(path, topic, *rows):
    """A bag that says it was cut off, without some messages of a topic."""
    recording = replace(read_bag(path), expected_samples=None, was_cut_off=True)
    track = getattr(recording, topic)
    kept = {name: np.delete(v, rows, axis=0) for name, v in vars(track).items() if isinstance(v, np.ndarray)}
    return replace(recording, **{topic: replace(track, **kept)})


def test_a_bag_that_was_cut_off_may_lack_the_twist_of_its_last_pose_and_nothing_else(bag, two_segments):
    cut_off = cut_off_without(bag, "twists", -1)
    found = certify(cut_off)
    assert broken(found) == set()
    assert telling(found, "after")
    assert broken(certify(cut_off_without(bag, "twists", -1, -2))) == {"stamps"}
    assert broken(certify(cut_off_without(bag, "twists", -2))) == {"stamps"}
    assert broken(certify(cut_off_without(bag, "poses", -1))) == {"stamps"}
    assert broken(certify(cut_off_without(two_segments, "twists", 19))) == {"stamps"}
    assert broken(certify(replace(cut_off, was_cut_off=False))) == {"stamps"}
    # its writer had finished, and the cut was behind the samples
    assert broken(certify(replace(cut_off, expected_samples=COUNT))) == {"stamps"}


def test_missing_end_is_noticed_by_the_count_at_the_end(bag):
    recording = read_bag(bag)
    shorter = replace(recording, expected_samples=COUNT + 1)
    found = certify(shorter)
    assert broken(found) == {"sample count"}
    assert str(COUNT + 1) in found.messages[0]
