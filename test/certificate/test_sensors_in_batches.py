"""Readings of a bag that is read in batches: the certificate that they get in memory, and none computed in vain."""

from __future__ import annotations

import pytest
from sensor_bags import BIAS, IMU, MAG, broken, certificate, recorded
from tampering import Change, on, tamper, with_numbers

from lie_rigid_body.certificate import certify, sensor_topics
from lie_rigid_body.recording import bag_reader, pairing
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
    monkeypatch.setattr(pairing, "_HELD_BACK", 4)
    monkeypatch.setattr(sensor_topics, "_HELD_BACK", 4)
    monkeypatch.setattr(sensor_topics, "BLOCK", 7)
    assert certify(Bag(path)) == whole


def test_readings_so_sparse_that_most_would_be_computed_in_vain_are_not(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(sensor_topics, "_MOST_IN_VAIN", 100)
    found = certificate(bag, tmp_path, lambda ms: on(IMU, lambda own: own[::5])(recorded(0.0)(ms)))
    assert broken(found) == {"IMU stamps"}
    assert found.sensors == (BIAS, MAG)
