"""Texts that others publish beside a body, without end: none is kept, whatever their topic is called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bags import MakeBag
from refused_bags import refused

from foreign_bags import Message, bag_of, messages_of
from lie_rigid_body.certificate import certify
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.messages import decode_string, encode_string
from lie_rigid_body.messages.definitions import STRING, definition
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.runs import Run, simulate

SAMPLES = 40
PER_MESSAGE = 5
LINE = json.dumps({"level": "INFO", "text": 200 * "x"})
LOGGED = encode_string(LINE)
SCENARIO = "/lie_rigid_body/scenario"


def mixed(source: Path, target: Path, topic: str, *, left_out: str = "", **options: object) -> Path:
    """A copy of a bag with lines of a log between its messages."""
    mixed = list[Message]()
    for message in messages_of(source):
        line = Message(topic, STRING, definition(STRING).encode(), message.log_time, message.log_time, LOGGED)
        mixed += [message] * (message.topic != left_out) + [line] * PER_MESSAGE
    target.write_bytes(bag_of(mixed, **options))  # type: ignore[arg-type]
    return target


@pytest.mark.parametrize("topic", ["/log", "/faults"])
@pytest.mark.parametrize("chunked", [True, False])
def test_a_log_beside_a_body_is_only_counted(make_bag: MakeBag, tmp_path: Path, topic: str, chunked: bool) -> None:
    path = mixed(make_bag(count=SAMPLES), tmp_path / "mixed.mcap", topic, use_chunking=chunked, chunk_size=4000)
    certificate = certify(Bag(path))
    assert certificate.passed
    count = PER_MESSAGE * (2 * SAMPLES + 1)
    [said] = [each for each in certificate.not_certified if f" {topic} ({count} " in each]
    assert said


@pytest.mark.parametrize("topic", ["/log", "/faults"])
def test_nor_does_a_run_or_a_score_keep_it(tmp_path: Path, topic: str) -> None:
    simulate(duration=SAMPLES / 100.0, imu_rate=20.0).to_bag(tmp_path / "bag.mcap")
    path = mixed(tmp_path / "bag.mcap", tmp_path / "mixed.mcap", topic)
    run = Run.from_bag(path)
    assert (len(run.t_ns), run.faults) == (SAMPLES, ())
    assert len(recorded_estimate(path, "/pose").track.stamps_ns) == SAMPLES


def test_other_texts_among_scenarios_end_the_reading(
    make_bag: MakeBag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A topic that calls itself a scenario may be without end: a score, too, is refused at the first other text."""
    path = mixed(make_bag(count=SAMPLES), tmp_path / "mixed.mcap", SCENARIO, chunk_size=1000)
    read = list[int]()

    def counted(payload: bytes, number: int) -> str:
        read.append(number)
        return decode_string(payload, number)

    monkeypatch.setattr("lie_rigid_body.recording.topic_messages.decode_string", counted)
    with refused("no scenario text"):
        recorded_estimate(path, "/pose", truth_bag=path)
    assert 1 <= max(read) < SAMPLES


def test_a_log_in_place_of_the_scenario_is_left_at_its_first_line(make_bag: MakeBag, tmp_path: Path) -> None:
    path = mixed(make_bag(count=SAMPLES), tmp_path / "mixed.mcap", "/log", left_out=SCENARIO)
    bag = Bag(path, topics={"scenario": "/log"})
    assert [text for _, text in bag.scenario_texts] == [LINE]
    with refused("no scenario text"):
        certify(bag)
