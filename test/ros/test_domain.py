"""The node heeds the environment of ROS 2: other domains do not see it."""

from __future__ import annotations

import os
import time
from importlib.util import find_spec

import pytest
from simulator_process import SimulatorProcess, eventually

if find_spec("rclpy"):
    import rclpy
    from rclpy.context import Context
    from rclpy.node import Node

pytestmark = pytest.mark.ros

DISCOVERY = 2.0
"""s; in its own domain a node is seen after some tenths."""


def observer(domain: int) -> Node:
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    return rclpy.create_node("observer", context=context)


def test_other_domains_do_not_see_the_node() -> None:
    domain = int(os.environ["ROS_DOMAIN_ID"])
    inside, outside = observer(domain), observer(domain % 101 + 1)
    # another test run may have that domain
    name = f"hidden_{os.getpid()}"
    with SimulatorProcess("--ros-args", "-r", f"__node:={name}") as simulator:
        eventually(lambda: name in inside.get_node_names(), "the node in its domain")
        time.sleep(DISCOVERY)
        assert name not in outside.get_node_names()
        assert any(f"in ROS domain {domain}" in line for line in simulator.said)
    for node in (inside, outside):
        node.destroy_node()
        rclpy.shutdown(context=node.context)
