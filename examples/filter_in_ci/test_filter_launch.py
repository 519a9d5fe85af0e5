"""The same with launch_testing, which comes with ROS 2: for pytest with its plugin, or for launch_test."""

import unittest

import pytest

pytest.importorskip("launch_testing", reason="launch_testing is not installed: it comes with ROS 2")

import launch_testing.actions
import launch_testing.asserts
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from test_filter_node import EVALUATOR, FILTER, SIMULATOR


@pytest.mark.launch_test
def generate_test_description():
    """Simulator, filter and evaluator; the test begins at once, and waits for the evaluator."""
    evaluator = ExecuteProcess(cmd=EVALUATOR, output="screen")
    description = LaunchDescription(
        [
            ExecuteProcess(cmd=SIMULATOR, output="screen"),
            ExecuteProcess(cmd=FILTER, output="screen"),
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
