"""What the node says at its start is what it does: its sentences are in `words_of_ros`."""

from __future__ import annotations

import shutil

import pytest

from lie_rigid_body import RigidBody
from lie_rigid_body.ros.publishing.announcement import commands, shape

NAMES = {"pose": "/a/truth", "~/reset": "/a/top/reset"}


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


@pytest.mark.parametrize("ros2", ["/opt/ros/bin/ros2", None])
@pytest.mark.parametrize(("domain", "prefix"), [(0, ""), (42, "ROS_DOMAIN_ID=42 ")])
def test_commands_reach_the_domain(ros2: str | None, domain: int, prefix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    which = shutil.which
    monkeypatch.setattr("shutil.which", lambda name: ros2 if name == "ros2" else which(name))
    for command in commands(NAMES, domain):
        assert command.startswith(prefix)
        assert ("ROS_DOMAIN_ID" in command) == bool(prefix)
