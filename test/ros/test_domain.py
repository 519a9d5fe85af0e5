"""The node heeds the environment of ROS 2: other domains do not see it."""

from __future__ import annotations

from importlib.util import find_spec

import pytest
from simulator_process import SimulatorProcess

from ros_domains import own_domain
from said import numbers

if find_spec("rclpy"):
    from peer import Peer

pytestmark = pytest.mark.ros


def test_other_domains_do_not_see_the_node() -> None:
    with (
        own_domain() as domain,
        own_domain() as other,
        Peer("inside", domain) as inside,
        Peer("outside", other) as outside,
        SimulatorProcess("--ros-args", "-r", "__node:=hidden", domain=domain) as simulator,
    ):
        inside.spin_until(lambda: "hidden" in inside.node.get_node_names(), "the node in its domain")
        with Peer("later", other):
            outside.spin_until(lambda: "later" in outside.node.get_node_names(), "a node that came later")
            assert "hidden" not in outside.node.get_node_names()
        assert any(numbers(line)[-1:] == [domain] for line in simulator.said)
