"""What the node says at its start is what it does."""

from __future__ import annotations

import shutil

import pytest
from test_wording_of_ros import NAMES

from lie_rigid_body import RigidBody
from lie_rigid_body.motion.moving_chart import DEFAULT_METHOD
from lie_rigid_body.ros.publishing.announcement import announcement, commands, shape
from lie_rigid_body.scenario import Scenario

AT_THE_START = ("~", "pose", "twist", "~/scenario", "~/reset")


@pytest.mark.parametrize(
    ("moments", "name"),
    [
        ([1.0, 1.0, 1.0], "spherical"),
        ([1.0, 1.0, 1.5], "oblate"),
        ([1.5, 1.0, 1.5], "prolate"),
        ([1.0, 2.0, 3.0], "asymmetric"),
        ([1.0, 1.0 + 1e-6, 1.5], "asymmetric"),
        ([1.0, 1.0 + 5e-14, 1.5], "asymmetric"),
        ([1.0, 1.0 + 2e-16, 1.5], "oblate"),
    ],
)
def test_tops_by_their_shape(moments: list[float], name: str) -> None:
    assert shape(RigidBody(moments)).startswith(name)


def test_names_numbers_and_files_are_told() -> None:
    scenario = Scenario.from_parameters(
        {"inertia": [1, 2, 2.5], "rate": 250, "stamped_twist": False, "world_frame": "map"}
    )
    text = announcement(scenario, NAMES, 42, "/tmp/a.mcap")
    for value in ("1 2 2.5 ", " 250 ", " 42\n", DEFAULT_METHOD, " map\n", " Twist ", " /tmp/a.mcap\n"):
        assert value in text
    for name in AT_THE_START:
        assert NAMES[name] in text


def test_no_bag_is_told_of_where_there_is_none() -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    text = announcement(scenario, NAMES, 42, "")
    told = announcement(scenario, NAMES, 42, "/tmp/a.mcap").splitlines()
    assert [line for line in told if line not in text.splitlines()] == [line for line in told if "/tmp/a.mcap" in line]
    assert NAMES["imu/data_raw"] not in text
    assert DEFAULT_METHOD not in text


def test_topics_of_sensors_are_told_in_a_line() -> None:
    scenario = Scenario.from_parameters({"imu_rate": 10.0, "gyro_temperature_drift": 1e-6})
    assert "  /a/imu /a/bias /a/top/faults  " in announcement(scenario, NAMES, 42, "")


@pytest.mark.parametrize("ros2", ["/opt/ros/bin/ros2", None])
@pytest.mark.parametrize(("domain", "prefix"), [(0, ""), (42, "ROS_DOMAIN_ID=42 ")])
def test_commands_reach_the_domain(ros2: str | None, domain: int, prefix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    which = shutil.which
    monkeypatch.setattr("shutil.which", lambda name: ros2 if name == "ros2" else which(name))
    for command in commands(NAMES, domain):
        assert command.startswith(prefix)
        assert ("ROS_DOMAIN_ID" in command) == bool(prefix)
