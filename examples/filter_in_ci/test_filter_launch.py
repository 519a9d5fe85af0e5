"""The same with launch_testing, which comes with ROS 2: for pytest with its plugin, or for launch_test."""

import random
import sys
import unittest
from pathlib import Path

import pytest

pytest.importorskip("launch_testing", reason="launch_testing is not installed: it comes with ROS 2")

import launch_testing.actions
import launch_testing.asserts
from launch import LaunchDescription
from launch.actions import ExecuteProcess, SetEnvironmentVariable
from launch_ros.actions import Node

HERE = Path(__file__).parent
LIMITS = ["--duration", "20", "--wait", "30", "--max-rms", "1deg"]


@pytest.mark.launch_test
def generate_test_description():
    """Simulator, filter and evaluator in a domain of their own; the test begins at once, and waits for the last."""
    simulator = Node(
        package="lie_rigid_body",
        executable="sim",
        arguments=["--scenario", "tumbling_cubesat"],
        parameters=[str(HERE / "simulator.yaml")],
    )
    # yours: Node(package="my_package", executable="my_filter"); 'ros2 run' would leave its child behind
    attitude_filter = ExecuteProcess(
        cmd=[sys.executable, str(HERE.parent / "complementary_filter" / "complementary_filter_node.py")]
    )
    evaluator = Node(
        package="lie_rigid_body",
        executable="evaluate",
        arguments=LIMITS,
        remappings=[("estimate", "/imu/data")],
        output="screen",
    )
    description = LaunchDescription(
        [
            SetEnvironmentVariable("ROS_DOMAIN_ID", str(random.randint(1, 101))),
            SetEnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
            simulator,
            attitude_filter,
            evaluator,
            launch_testing.actions.ReadyToTest(),
        ]
    )
    return description, {"evaluator": evaluator}


class TestFilter(unittest.TestCase):
    """While all three run."""

    def test_the_evaluator_ends(self, proc_info, evaluator):
        proc_info.assertWaitForShutdown(process=evaluator, timeout=120.0)


@launch_testing.post_shutdown_test()
class TestScore(unittest.TestCase):
    """After the end."""

    def test_the_filter_keeps_its_limit(self, proc_info, evaluator):
        launch_testing.asserts.assertExitCodes(proc_info, process=evaluator)
