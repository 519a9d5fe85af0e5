"""Scenario messages that come twice are told, and samples are judged by the last of a start."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from phrases import telling
from sensor_bags import certificate, write
from sensor_bags import recorded as recorded_late

from foreign_bags import PLAIN, bag_of, messages_of
from lie_rigid_body import certify, simulate
from lie_rigid_body.messages import decode_string, encode_string

Change = Callable[[dict[str, Any]], object]


def recorded(path: Path, *texts: tuple[float, Change]) -> Path:
    """A bag of 3 s by `ros2 bag record`, with more scenario messages that come at some time, s."""
    simulate(duration=2.9, rate=5.0).to_bag(path)
    first, *rest = messages_of(path)
    scenario = json.loads(decode_string(first.data))
    for time, change in texts:
        data = encode_string(json.dumps(change(dict(scenario))))
        rest.append(first._replace(log_time=int(1e9 * time), publish_time=int(1e9 * time), data=data))
    path.write_bytes(bag_of([first, *sorted(rest, key=lambda m: m.log_time)], "libmcap 1.0", compression=PLAIN))
    return path


def another(name: str, value: object) -> Change:
    return lambda scenario: {**scenario, name: value}


def test_a_repeated_message_is_told(tmp_path: Path) -> None:
    assert not certify(recorded(tmp_path / "once.mcap")).uncovered
    certificate = certify(recorded(tmp_path / "twice.mcap", (2.0, lambda scenario: scenario)))
    assert certificate.passed
    [said] = certificate.uncovered
    assert telling(certificate, "scenarios again", count=1) == [said]


def test_a_second_reset_at_once_is_told(tmp_path: Path) -> None:
    """It happens while the node pauses: the later one holds."""
    path = recorded(tmp_path / "x.mcap", (-0.0, another("max_step", 0.0005)))
    certificate = certify(path)
    assert certificate.passed
    [said] = certificate.uncovered
    assert telling(certificate, "scenarios without a sample", count=1) == [said]


def test_a_scenario_that_comes_back_after_another_is_the_last(tmp_path: Path) -> None:
    """Three resets between two samples, as while the node pauses, the third of which goes back to the first."""
    first: dict[str, object] = {"motion": "closed_form", "initial_body_rate": [0.1, 1.0, 0.2]}
    second: dict[str, object] = {"motion": "closed_form", "initial_body_rate": [0.5, 0.2, 0.2]}
    path = write(tmp_path / "x.mcap", ({}, 0.4), (first, 0.0), (second, 0.0), (first, 0.4))
    for change in (lambda messages: messages, recorded_late(0.0)):
        found = certificate(path, tmp_path, change)
        assert found.passed, found.messages
        assert [segment.segment.scenario.initial_body_rate for segment in found.segments][1:] == [(0.1, 1.0, 0.2)]


def test_a_message_that_contradicts_samples_before_it_breaks_a_law(tmp_path: Path) -> None:
    assert not certify(recorded(tmp_path / "x.mcap", (2.0, another("initial_body_rate", [0.0, 0.0, 1.0])))).passed


def test_the_same_scenario_in_other_words_contradicts_nothing(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.mcap", (2.0, lambda scenario: dict(reversed(scenario.items()))))
    assert certify(path).passed
