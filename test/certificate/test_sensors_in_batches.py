"""Readings of a bag that is read in batches: the certificate that they get in memory, and none computed in vain."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_bags import BIAS, IMU, MAG, broken, certificate, laws, recorded
from tampering import Change, at, on, tamper, with_numbers

from lie_rigid_body.certificate import certify, readings
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
    monkeypatch.setattr(readings, "_LONGEST_GAP", 2)
    monkeypatch.setattr(readings, "_MAX_PIECES", 2)
    assert certify(Bag(path)) == whole


@pytest.mark.parametrize("longest", [256, 3])
def test_sparse_readings_are_compared_and_those_between_are_left_out(bag, tmp_path, monkeypatch, replayed, longest):
    monkeypatch.setattr(readings, "_LONGEST_GAP", longest)
    sparse = lambda ms: [m for m in recorded(0.0)(ms) if m.topic not in (MAG, BIAS)]  # noqa: E731
    fifth = on(IMU, lambda own: own[::5])
    found = certificate(bag, tmp_path, lambda ms: fifth(sparse(ms)))
    assert broken(found) == {"IMU stamps"}
    assert found.sensors == (IMU,)
    assert [law.checked for law in laws(found, "gyro")] == [67]
    assert sum(replayed) == (67 if longest == 3 else 331)
    forged = on(IMU, at(30, lambda m: with_numbers(m, 24, lambda x: np.concatenate([x[:1] + 1e-11, x[1:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(fifth(sparse(ms))))
    assert broken(found) == {"IMU stamps", "gyro"}
    assert [law.sample for law in laws(found, "gyro")] == [150]
