"""Domains for filters: each is of one player at a time, whatever other users have left in the shared folder."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest

from lie_rigid_body.errors import LieRigidBodyError
from ros_domains import own_domain

if find_spec("rclpy"):
    from lie_rigid_body.ros import play

pytestmark = pytest.mark.ros


def test_what_others_have_left_holds_no_domain_and_leads_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(play, "DOMAINS", range(1, 5))
    monkeypatch.setattr(play, "_is_empty", lambda domain: True)  # other tests may be there
    monkeypatch.delenv("ROS_DOMAIN_ID")
    os.mkfifo(tmp_path / "ros-domain-1.lock")  # whoever opens it to read would wait for a writer
    (tmp_path / "ros-domain-2.lock").symlink_to(tmp_path / "made elsewhere")
    (tmp_path / "ros-domain-3.lock").touch(mode=0o444)
    with play.own_domain() as one, play.own_domain() as two, play.own_domain() as three:
        assert {one, two, three} == {1, 3, 4}
        with pytest.raises(LieRigidBodyError), play.own_domain():
            pass
    with play.own_domain() as again:
        assert again in (1, 3, 4)
    assert not (tmp_path / "made elsewhere").exists()


def test_a_domain_in_which_a_node_runs_is_left_to_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot's nodes would take the readings that are played for their own; so would those of the user's domain."""
    with own_domain() as robots, own_domain() as users, own_domain() as free:
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        monkeypatch.setattr(play, "DOMAINS", (robots, users, free))
        monkeypatch.setenv("ROS_DOMAIN_ID", f"{users}")
        with a_node(robots):
            for _ in range(5):
                with play.own_domain() as domain:
                    assert domain == free


NODE = """
import rclpy
rclpy.init()
node = rclpy.create_node("robot")
print("here", flush=True)
rclpy.spin(node)
"""


@contextmanager
def a_node(domain: int) -> Iterator[None]:
    """A node in a domain, with the transports that a robot has, and not those of the tests."""
    environment = {**os.environ, "ROS_DOMAIN_ID": f"{domain}"}
    environment.pop("FASTRTPS_DEFAULT_PROFILES_FILE", None)
    process = subprocess.Popen([sys.executable, "-c", NODE], env=environment, stdout=subprocess.PIPE)
    try:
        assert process.stdout
        assert process.stdout.readline() == b"here\n"
        yield
    finally:
        process.kill()
        process.wait()
