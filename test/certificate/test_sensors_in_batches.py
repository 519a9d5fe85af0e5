"""Readings of a bag that is read in batches: the certificate that they get in memory, and none computed in vain."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_bags import BIAS, IMU, MAG, broken, certificate, laws, recorded
from tampering import Change, at, on, tamper, with_numbers

from lie_rigid_body.certificate import certify, readings, sensor_topics
from lie_rigid_body.recording import bag_reader, samples
from lie_rigid_body.recording.bag_reader import Bag, read_bag


def every_ninth(change) -> Change:
    return lambda ms: [change(m) if i % 9 == 5 else m for i, m in enumerate(ms)]


CHANGES: dict[str, Change] = {
    "honest": lambda ms: ms,
    "gap": on(IMU, lambda ms: [*ms[:100], *ms[117:]]),
    "doubled": on(BIAS, lambda ms: [*ms[:101], *ms[100:]]),
    "swapped": on(MAG, lambda ms: [*ms[:30], ms[31], ms[30], *ms[32:]]),
    "scaled": on(IMU, every_ninth(lambda m: with_numbers(m, 24, lambda x: 1.001 * x))),
    "framed": on(IMU, every_ninth(lambda m: m._replace(data=m.data.replace(b"imu_", b"abc_")))),
    "recorded": recorded(0.21, 0.1),
}


@pytest.mark.parametrize("change", CHANGES)
def test_batches_change_no_number(bag, tmp_path, monkeypatch, change):
    path = tamper(bag, tmp_path / "changed.mcap", CHANGES[change])
    whole = certify(read_bag(path))
    monkeypatch.setattr(bag_reader, "_BATCH", 50)
    monkeypatch.setattr(samples, "_HELD_BACK", 4)
    monkeypatch.setattr(readings, "REPLAY_BLOCK", 7)
    monkeypatch.setattr(sensor_topics, "REPLAY_BLOCK", 7)
    assert certify(Bag(path)) == whole


def test_a_topic_far_behind_the_other_is_compared_with_a_replay_of_its_own(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(bag_reader, "_BATCH", 50)
    monkeypatch.setattr(readings, "REPLAY_BLOCK", 7)
    monkeypatch.setattr(sensor_topics, "REPLAY_BLOCK", 7)
    last = lambda ms: [*(m for m in ms if m.topic != BIAS), *(m for m in ms if m.topic == BIAS)]  # noqa: E731
    plain = certificate(bag, tmp_path, recorded(0.0))
    found = certificate(bag, tmp_path, lambda ms: last(recorded(0.0)(ms)))
    assert found.passed, found.messages
    assert laws(found, "gyro bias") == laws(plain, "gyro bias")


def test_readings_on_both_sides_of_a_gap_are_compared(bag, tmp_path):
    fifth = on(IMU, lambda own: own[::5])
    sparse = lambda ms: fifth([m for m in recorded(0.0)(ms) if m.topic not in (MAG, BIAS)])  # noqa: E731
    found = certificate(bag, tmp_path, sparse)
    assert broken(found) == {"IMU stamps"}
    assert found.sensors == (IMU,)
    assert [law.checked for law in laws(found, "gyro")] == [67]
    forged = on(IMU, at(30, lambda m: with_numbers(m, 24, lambda x: np.concatenate([x[:1] + 1e-8, x[1:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(sparse(ms)))
    assert broken(found) == {"IMU stamps", "gyro"}
    assert [law.sample for law in laws(found, "gyro")] == [150]
