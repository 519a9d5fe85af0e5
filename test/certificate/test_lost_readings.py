"""Readings that a recorder lost, or a topic without any: told as lost, and what is left is judged."""

from __future__ import annotations

import struct

import pytest
from phrases import telling
from sensor_bags import BIAS, IMU, MAG, broken, certificate, laws, recorded, write
from tampering import Change, on

from lie_rigid_body.certificate import certify, sensors, stamps
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.recovery import recover
from lie_rigid_body.sensors import TransportFaults


def without(*topics: str) -> Change:
    return lambda ms: [m for m in ms if m.topic not in topics]


def test_a_topic_that_was_taken_away_is_missed(bag, tmp_path):
    found = certificate(bag, tmp_path, without(BIAS))
    assert broken(found) == {"IMU stamps"}
    [law] = laws(found, "IMU stamps")
    assert (law.unit, law.worst, law.sample) == ("gap", 332, 0)
    late = recorded(0.1)
    found = certificate(bag, tmp_path, lambda ms: late(without(BIAS)(ms)))
    assert found.passed, found.messages
    assert found.sensors == (IMU, MAG)


def test_a_recorder_that_lost_readings_is_told(bag, tmp_path):
    late, holed = recorded(0.2, 0.05), on(MAG, lambda ms: [*ms[:30], *ms[32:]])
    found = certificate(bag, tmp_path, lambda ms: holed(late(ms)))
    assert broken(found) == {"magnetometer stamps"}
    [law] = laws(found, "magnetometer stamps")
    assert (law.unit, law.worst) == ("gap", 2)


def test_a_recorder_that_came_too_late_for_a_replay_is_told(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(sensors, "MAX_SPARE_READINGS", 50)
    found = certificate(bag, tmp_path, recorded(0.3))
    assert found.passed, found.messages
    assert found.sensors == (MAG,)
    assert not laws(found, "gyro")
    assert telling(found, "too many readings", topic=IMU)


def test_poses_that_a_recorder_has_no_twist_of_are_told(bag, tmp_path):
    late, few, poses = recorded(0.1), on("/twist", lambda ms: ms[:20]), list[int]()

    def change(ms):
        left = few(late(ms))
        poses.append(sum(m.topic == "/pose" for m in left))
        return left

    found = certificate(bag, tmp_path, change)
    assert found.passed, found.messages
    assert telling(found, "samples in half", count=poses[0] - 20)


def test_a_forged_stamp_years_ahead_is_not_searched_for_lost_readings(tmp_path, monkeypatch):
    searched, lost = list[int](), TransportFaults.lost

    def counted(self, numbers, times_ns):
        searched.append(len(numbers))
        return lost(self, numbers, times_ns)

    def ahead(ms):
        *before, last = ms
        stamp = last.log_time + 3 * 10**10
        data = last.data[:4] + struct.pack("<iI", *divmod(stamp, 10**9)) + last.data[12:]
        return [*before, last._replace(log_time=stamp, data=data)]

    path = write(tmp_path / "lossy.mcap", ({"imu_rate": 1000.0, "imu_dropout_probability": 0.9}, 0.5))
    monkeypatch.setattr(stamps, "MAX_LOST", 3000)
    monkeypatch.setattr(TransportFaults, "lost", counted)
    both = [on(topic, ahead) for topic in ("/pose", "/twist")]
    found = certificate(path, tmp_path, lambda ms: both[1](both[0](ms)))
    assert "stamps" in broken(found)
    assert sum(searched) < 9000


@pytest.mark.parametrize("cut", [0.3, 0.55, 0.8, 0.95])
def test_what_is_recovered_of_a_cut_off_bag_is_certified(bag, tmp_path, cut):
    data, broken_off = bag.read_bytes(), tmp_path / "cut.mcap"
    broken_off.write_bytes(data[: int(cut * len(data))])
    recover(broken_off, tmp_path / "fixed.mcap", overwrite=False)
    found = certify(Bag(tmp_path / "fixed.mcap"))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
