"""Domains: others do not see a node, and those for filters are of one player at a time, whatever is left of others."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import pytest

from lie_rigid_body.foundation.errors import LieRigidBodyError
from ros_domains import PROFILES_FILE, own_domain

if find_spec("rclpy"):
    from lie_rigid_body.ros import play

pytestmark = pytest.mark.ros


def test_a_domain_is_of_one_player_until_its_process_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    with own_domain() as one, own_domain() as other:
        monkeypatch.setattr(play, "DOMAINS", (one, other, 0, 102, 103))  # two that no other test has
        monkeypatch.setattr(play, "_is_empty", lambda domain: domain in (102, 103))
        monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
        holding = "import time; from lie_rigid_body.ros import play\n"
        holding += "play.DOMAINS, play._is_empty = (102,), lambda domain: True\n"
        holding += "with play.own_domain() as domain: print(domain, flush=True); time.sleep(1000)"
        with subprocess.Popen([sys.executable, "-c", holding], stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"102\n"
            with play.own_domain() as domain:
                assert domain == 103
                with pytest.raises(LieRigidBodyError), play.own_domain():
                    pass
            process.kill()
        with play.own_domain() as first, play.own_domain() as second:
            assert {first, second} == {102, 103}


def test_a_domain_in_which_a_node_runs_is_left_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot's nodes would take the readings that are played for their own; so would those of the user's domain."""
    with own_domain() as robots, own_domain() as users, own_domain() as free:
        monkeypatch.setattr(play, "DOMAINS", (robots, users, free))
        monkeypatch.setattr(play, "_PLAYED", "\0lie_rigid_body/tested/{}")  # the others are held here
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
    environment.pop(PROFILES_FILE, None)
    process = subprocess.Popen([sys.executable, "-c", NODE], env=environment, stdout=subprocess.PIPE)
    try:
        assert process.stdout
        assert process.stdout.readline() == b"here\n"
        yield
    finally:
        process.kill()
        process.wait()
