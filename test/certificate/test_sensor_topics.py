"""The topics of sensors are found by their names beside the poses, and others are listed."""

from __future__ import annotations

from pathlib import Path

from phrases import telling
from sensor_bags import ALL, BIAS, IMU, MAG

from foreign_bags import bag_of, messages_of
from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag


def rewritten(
    bag: Path, target: Path, names: dict[str, str], twice: dict[str, str] | None = None, silent: tuple[str, ...] = ()
) -> Path:
    """A bag with other names of topics, copies of topics under other names, and topics without messages."""
    messages = [
        message._replace(topic=topic)
        for message in messages_of(bag)
        for topic in (names.get(message.topic, message.topic), (twice or {}).get(message.topic))
        if topic
    ]
    target.write_bytes(bag_of(messages, topics=[(topic, "std_msgs/msg/Empty") for topic in silent]))
    return target


def test_topics_are_found_beside_the_poses_and_others_are_listed(bag, tmp_path):
    twice = {MAG: "/robot/imu/mag", IMU: "/robot/imu/data"}
    found = certify(Bag(rewritten(bag, tmp_path / "two.mcap", {}, twice)))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
    for topic, count in (("/robot/imu/mag", 70), ("/robot/imu/data", 332)):
        assert telling(found, "stray", topic=topic, count=count)
    elsewhere = {topic: f"/a{topic}" for topic in ("/pose", "/twist", "/lie_rigid_body/scenario", *ALL)}
    found = certify(Bag(rewritten(bag, tmp_path / "elsewhere.mcap", elsewhere, {MAG: "/b/imu/mag"})))
    assert found.sensors == ("/a/imu/data_raw", "/a/imu/bias", "/a/imu/mag")
    silent = certify(Bag(rewritten(bag, tmp_path / "silent.mcap", {}, silent=("/twist", "/another/twist"))))
    assert silent.passed
    assert telling(silent, "stray", topic="/another/twist", count=0)
    assert telling(silent, "another type", topic="/twist", kind="std_msgs/msg/Empty")
    apart = certify(Bag(rewritten(bag, tmp_path / "apart.mcap", {"/pose": "/truth/pose"})))
    assert apart.sensors == (IMU, BIAS, MAG)
