"""Every kind of tampering is caught by the laws it breaks, and named with its place."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from phrases import telling
from sensor_bags import broken, certificate
from tampering import at, declared, flipped, on, rotated, scaled_rate, tamper

from foreign_bags import Message
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError, ParameterError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep
from said import numbers

SCENARIOS: dict[str, dict[str, object]] = {
    "default": {},
    "closed form": {"motion": "closed_form", "inertia": [0.6, 0.8, 1.0], "initial_body_rate": [3.0, 0.5, -0.9]},
    "products": {
        "inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9],
        "initial_body_rate": [0.4, -1.2, 0.7],
        "epoch_ns": 10**18,
    },
    "symmetric": {"inertia": [1.0, 1.0, 1.8], "initial_body_rate": [0.3, 0.5, 1.1], "rate": 37.0},
}
COUNT = 300


# each way of moving in every run, with all that a declaration can hold; every law looks at both alike
QUICK = {"closed form", "products"}


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in SCENARIOS]
)
def bag(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    simulation = Simulation(Scenario.from_parameters(SCENARIOS[request.param]))
    encoder = BatchEncoder(simulation.segment.scenario)
    with BagWriter(path, stamped_twist=True) as writer:
        writer.begin_segment(simulation.segment)
        samples = simulation.take(COUNT)
        writer.write(encoder.encode(SimulationStep(samples)))
    return path


def test_the_honest_bag_and_its_faithful_copy_are_certified(bag, tmp_path):
    for path in (bag, tamper(bag, tmp_path / "copy.mcap", lambda messages: messages)):
        found = certify(read_bag(path))
        assert found.passed, found.messages
        assert found.attitude_accuracy < 1e-10


@pytest.mark.parametrize("factor", [1 + 1e-9, 1 - 1e-9])
@pytest.mark.parametrize("which", ["one", "all"])
def test_scaled_rate(bag, tmp_path, factor, which):
    change = scaled_rate(factor)
    found = certificate(
        bag, tmp_path, on("/twist", at(170, change) if which == "one" else lambda ms: list(map(change, ms)))
    )
    assert broken(found) == {"body rate"}
    law = found.segments[0].law("body rate")
    assert (law.sample == 170) == (which == "one")
    assert law.broken == (1 if which == "one" else COUNT)


def test_all_quaternions_flipped(bag, tmp_path):
    """The declared start has a sign, and the path goes on from there."""
    found = certificate(bag, tmp_path, on("/pose", lambda ms: list(map(flipped, ms))))
    assert broken(found) == {"sign continuity"}
    assert found.segments[0].law("sign continuity").sample == 0


def test_all_rotated_by_a_hundred_millionth(bag, tmp_path):
    turn = rotated(1e-8, np.array([0.3, 0.8, -0.5]))
    found = certificate(bag, tmp_path, on("/pose", lambda ms: list(map(turn, ms))))
    assert "attitude" in broken(found)


def with_inertia(change):
    def changed(message: Message) -> Message:
        content = json.loads(message.data[8:-1])
        content["inertia"][-1] = change(content["inertia"][-1])
        return message._replace(data=encode_string(json.dumps(content)))

    return on("/lie_rigid_body/scenario", at(0, changed))


def test_inertia_given_by_hand(bag):
    declared = Scenario.from_parameters(SCENARIOS["default"]).inertia
    assert declared == (1.0, 2.0, 3.0)
    assert not certify(read_bag(bag), [1.5, 2.25, 3.0]).passed


def test_an_inertia_that_is_used_instead_is_told(bag, tmp_path):
    """The bag goes on to say the other one to whoever reads it."""
    plain = certify(read_bag(bag))
    path = tamper(bag, tmp_path / "tampered.mcap", with_inertia(lambda value: value * 0.99))
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


@pytest.mark.parametrize("first", [5, 10**30])
def test_a_beginning_that_is_declared_away(bag, tmp_path, first):
    with pytest.raises(BagError):
        certificate(bag, tmp_path, lambda ms: declared(first_sample=first)(without_first(5)(ms)))


def test_a_late_epoch_does_not_make_a_sample_before_the_first(bag, tmp_path):
    epoch = read_bag(bag).poses.stamps_ns[0].item() + 10**7
    with pytest.raises(BagError):
        certificate(bag, tmp_path, declared(epoch_ns=epoch))


@pytest.mark.parametrize("recorder", [False, True])
def test_a_beginning_that_is_declared_away_in_every_field(bag, tmp_path, recorder):
    """The motion from sample 5 on is a true one; it is certified where a recorder came late, and only with a note."""
    whole = read_bag(bag)
    start, attitude = whole.poses.stamps_ns[5].item(), whole.poses.values[5, 3:].tolist()
    forged = declared(
        first_sample=5,
        start_ns=start,
        initial_attitude_xyzw=attitude,
        initial_body_rate=whole.twists.values[5, 3:].tolist(),
        motion="closed_form",
    )
    logged = start + 7 if recorder else start
    late = on("/lie_rigid_body/scenario", at(0, lambda m: m._replace(log_time=logged)))
    found = certificate(bag, tmp_path, lambda ms: late(forged(without_first(5)(ms))))
    if recorder:
        assert "declaration" not in broken(found)
        assert telling(found, "before")
    else:
        assert "declaration" in broken(found)
        assert telling(found, "late beginning", sample=5)


def test_a_scenario_logged_at_another_time(bag, tmp_path):
    """Log times are a law of a bag of this package, whatever they are; those of a recorder are said not to be."""
    with pytest.raises(BagError):
        certificate(bag, tmp_path, on("/lie_rigid_body/scenario", at(0, lambda m: m._replace(log_time=2**64 - 1))))
    later = on("/lie_rigid_body/scenario", at(0, lambda m: m._replace(log_time=m.log_time + 1)))
    foreign = tamper(bag, tmp_path / "later.mcap", later)
    found = certify(read_bag(foreign))
    assert found.passed
    assert telling(found, "recorder's log times")
    assert broken(certify(replace(read_bag(foreign), library="lie_rigid_body 9"))) == {"log times"}


@pytest.fixture
def two_segments(tmp_path):
    path = tmp_path / "two.mcap"
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form"}))
    with BagWriter(path, stamped_twist=True) as writer:
        for count in (20, 30):
            writer.begin_segment(simulation.segment)
            encoder = BatchEncoder(simulation.segment.scenario)
            writer.write(encoder.encode(SimulationStep(simulation.take(count))))
            simulation.reset(Scenario.from_parameters({"motion": "closed_form", "initial_body_rate": [1.0, 0.0, 0.5]}))
    return path


def test_a_segment_robbed_of_all_its_samples(two_segments, tmp_path):
    found = certificate(two_segments, tmp_path, without_first(20))
    assert broken(found) == {"stamps"}
    assert numbers(found.messages[0])[:4] == [1, 20, 0, 19]


def test_a_segment_that_does_not_follow_the_clock_before_it(two_segments, tmp_path):
    def shifted(message: Message) -> Message:
        content = json.loads(message.data[8:-1])
        content |= {"epoch_ns": content["epoch_ns"] + 3, "start_ns": content["start_ns"] + 3}
        return message._replace(data=encode_string(json.dumps(content)))

    found = certificate(two_segments, tmp_path, on("/lie_rigid_body/scenario", at(1, shifted)))
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
