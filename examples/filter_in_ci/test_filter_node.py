"""A filter node in continuous integration, with pytest and subprocesses alone: its score is the same on any machine.

Simulator, filter and evaluator are processes of their own. The simulator goes in lock-step: it sends the next reading
when the filter has answered the last one, as fast as the filter can.
"""

import json
import os
import random
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

FILTER = [sys.executable, str(Path(__file__).parents[1] / "complementary_filter" / "complementary_filter_node.py")]
"""Your filter, as in ["ros2", "run", "my_package", "my_filter"]."""
ESTIMATE = "/imu/data"
"""The topic on which it publishes its attitude, stamped as the reading that it answers."""
PARAMETERS = {
    "epoch_ns": 1_767_225_600_000_000_000,
    "imu_rate": 100.0,
    "magnetometer_rate": 100.0,
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
    "sensor_grade": "tactical",
    "lockstep_topic": ESTIMATE,
    "lockstep_nodes": "[/evaluator]",
    "real_time_factor": 0.0,
}
SIMULATOR = [sys.executable, "-m", "lie_rigid_body", "sim", "--scenario", "tumbling_cubesat"]
SIMULATOR += [word for name, value in PARAMETERS.items() for word in ("-p", f"{name}:={value}")]
EVALUATOR = [sys.executable, "-m", "lie_rigid_body", "evaluate", "--json", "--duration", "20", "--wait", "30"]
EVALUATOR += ["--max-rms", "1deg", "--ros-args", "-r", f"estimate:={ESTIMATE}"]


@pytest.fixture
def environment():
    """A ROS domain of its own, on this machine alone."""
    return {**os.environ, "ROS_DOMAIN_ID": str(random.randint(1, 101)), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def started(stack, command, environment):
    """A process that is ended with the test, whatever happens."""
    process = stack.enter_context(subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True))
    stack.callback(process.kill)
    return process


def test_the_filter_keeps_its_limit(environment):
    with ExitStack() as stack:
        started(stack, SIMULATOR, environment)
        started(stack, FILTER, environment)
        evaluator = started(stack, EVALUATOR, environment)
        said, _ = evaluator.communicate(timeout=120)
    assert evaluator.returncode == 0, said  # 1: the limit is broken
    score = json.loads(said)
    assert score["samples"] == 2001
    assert score["findings"] == []
