"""Sensors with faults, and those of attitude and sun: honest ones pass, and any change is named."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_bags import (
    ALL,
    ATTITUDE,
    AXES,
    BIAS,
    FORCE,
    IMU,
    LATE,
    LATER,
    LOST,
    MAG,
    MOTIONS,
    NOISY,
    START,
    SUN,
    VALUES,
    broken,
    certificate,
    episodes,
    laws,
    recorded,
    write,
)
from tampering import at, declared, on, tamper, with_numbers

from foreign_bags import Message
from lie_rigid_body.certificate import LawResult, SegmentCertificate, certify
from lie_rigid_body.certificate.stamps import DUPLICATE, GAP
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.runs import Run
from sampled import sampled

SENSORS = ("gyro", "accelerometer", "magnetometer")


@pytest.mark.parametrize("draw", sampled(range(6), every=6))
def test_a_range_or_level_that_is_no_multiple_of_the_resolution(tmp_path, draw):
    """What saturates is at the last step within it, in the bag and where it is computed anew."""
    random = np.random.default_rng(draw)
    coarse = {
        f"{sensor}_{key}": size * random.uniform(*share)
        for sensor, size in (("gyro", 0.5), ("accelerometer", 5.0), ("magnetometer", 2e-5))
        for key, share in (("range", (1.0, 2.0)), ("saturation_level", (0.1, 0.9)), ("resolution", (0.01, 0.8)))
    }
    low = {key: value for sensor in SENSORS for key, value in episodes(f"{sensor}_saturation", 0.3, 0.2).items()}
    path = write(tmp_path / "a.mcap", ({**START, **coarse, **low}, 0.6))
    found = certify(Bag(path))
    assert found.passed, found.messages
    assert all(law.worst == 0.0 for value in VALUES for law in laws(found, value))
    run = Run.from_bag(path)
    assert run.magnetometer is not None
    for sensor, read in zip(SENSORS, (run.imu.gyro, run.imu.specific_force, run.magnetometer.field), strict=True):
        assert np.abs(read).max() <= coarse[f"{sensor}_range"]


@pytest.mark.parametrize("name", sampled(AXES, every=3))
def test_faults_of_axes_that_are_declared_away_are_missed(tmp_path, name):
    path = write(tmp_path / "a.mcap", ({**START, **AXES[name]}, 0.5))
    none = dict.fromkeys((key for key in AXES[name] if not key.endswith("duration")), 0.0)
    found = certificate(path, tmp_path, declared(**none))
    assert broken(found) & set(VALUES)


@pytest.mark.parametrize("topic", [IMU, BIAS, MAG])
def test_readings_that_should_be_lost_or_not_are_named(tmp_path, topic):
    path = write(tmp_path / "a.mcap", ({**START, **LOST}, 0.6))
    whole = write(tmp_path / "whole.mcap", (START, 0.6))
    stamps = "magnetometer stamps" if topic == MAG else "IMU stamps"
    missing = certificate(path, tmp_path, on(topic, lambda ms: [*ms[:20], *ms[21:]]))
    assert broken(missing) == {stamps}
    assert {law.unit for law in laws(missing, stamps)} == {GAP}
    extra: list[Message] = []
    tamper(whole, tmp_path / "c.mcap", lambda ms: extra.extend(m for m in ms if m.topic == topic) or ms)  # type: ignore[func-returns-value]

    def filled(messages: list[Message]) -> list[Message]:
        known = {m.log_time for m in messages}
        return sorted([*messages, *(m for m in extra if m.log_time not in known)], key=lambda m: m.log_time)

    found = certificate(path, tmp_path, on(topic, filled))
    assert broken(found) == {stamps}
    assert {law.unit for law in laws(found, stamps)} == {DUPLICATE}


@pytest.mark.parametrize(("parameter", "topic"), [("world_frame", "/pose"), ("body_frame", "/twist")])
@pytest.mark.parametrize("names", [(b"aaaa", b"bbbb"), (b"bbbb", b"aaaa")])
def test_frames_are_those_of_their_own_segment(tmp_path, parameter, topic, names):
    path = write(tmp_path / "a.mcap", ({parameter: "aaaa"}, 0.3), ({parameter: "bbbb"}, 0.3))
    assert certify(Bag(path)).passed

    def renamed(messages: list[Message]) -> list[Message]:
        return [message._replace(data=message.data.replace(*names)) for message in messages]

    assert broken(certificate(path, tmp_path, on(topic, renamed))) == {"frames"}


def test_a_late_reading_that_is_logged_otherwise_is_counted(tmp_path):
    path = write(tmp_path / "a.mcap", ({**START, **LATE}, 0.4))
    sooner = on(IMU, at(20, lambda m: m._replace(log_time=m.log_time - 1)))
    found = certificate(path, tmp_path, sooner)
    assert broken(found) == {"log times"}
    assert [law.broken for law in found.whole if law.name == "log times"] == [1]


@pytest.mark.parametrize("motion", ["closed form", "dmv20"])
def test_a_reset_that_switches_the_orientation_is_certified_segment_by_segment(tmp_path, motion):
    start = {**MOTIONS[motion], **FORCE, **NOISY, **LATER, "rate": 7.0}
    path = write(tmp_path / "a.mcap", (start, 0.3), ({**start, "imu_orientation": False}, 0.3), (start, 0.4))
    for change in (lambda ms: ms, recorded(0.213, 0.06)):
        found = certificate(path, tmp_path, change)
        assert found.passed, found.messages
        assert found.sensors == (*ALL, ATTITUDE, SUN)
        assert [bool(laws_of_orientation(segment)) for segment in found.segments] == [True, False, True]
    turned = certificate(path, tmp_path, on(IMU, at(2, forged_orientation)))
    assert broken(turned) == {"IMU orientation"}
    none = certificate(path, tmp_path, on(IMU, at(150, forged_orientation)))
    assert broken(none) == {"IMU frame and covariances"}


def laws_of_orientation(segment: SegmentCertificate) -> list[LawResult]:
    return [law for law in segment.laws if law.name == "IMU orientation"]


def forged_orientation(message: Message) -> Message:
    """Another first component."""
    return with_numbers(message, 37, lambda numbers: np.concatenate([[numbers[0] + 1e-9], numbers[1:]]))
