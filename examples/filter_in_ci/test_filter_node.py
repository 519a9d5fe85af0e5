"""A filter node in continuous integration, with pytest and subprocesses alone: its score is the same on any machine.

Simulator, filter and evaluator are processes of their own. The simulator goes in lock-step: it sends the next reading
when the filter has answered the last one, as fast as the filter can.
"""

import json
import os
import random
import signal
import subprocess
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FILTER = [sys.executable, str(HERE.parent / "complementary_filter" / "complementary_filter_node.py")]
"""Your filter, as in ["ros2", "run", "my_package", "my_filter"]."""
ESTIMATE = "/imu/data"
"""The topic on which it publishes its attitude, stamped as the reading that it answers; simulator.yaml names it too."""
PACKAGE = [sys.executable, "-m", "lie_rigid_body"]
SIMULATOR = [*PACKAGE, "sim", "--scenario", "tumbling_cubesat", "--params-file", str(HERE / "simulator.yaml")]
LIMITS = ["--duration", "20", "--wait", "30", "--max-rms", "1deg"]
EVALUATOR = [*PACKAGE, "evaluate", *LIMITS, "--json", "score.json", "--ros-args", "-r", f"estimate:={ESTIMATE}"]


@pytest.fixture
def environment():
    """A ROS domain of its own, on this machine alone."""
    return {**os.environ, "ROS_DOMAIN_ID": str(random.randint(1, 101)), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def started(stack, command, **options):
    """A process that is ended with the test, whatever happens, and its children with it: 'ros2 run' has one."""
    process = stack.enter_context(subprocess.Popen(command, start_new_session=True, **options))
    stack.callback(end_group, process.pid)
    return process


def end_group(pid):
    """End what still runs of a process and its children: a child may outlive it."""
    with suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)


def test_the_filter_keeps_its_limit(environment, tmp_path):
    with ExitStack() as stack:
        started(stack, SIMULATOR, env=environment)
        started(stack, FILTER, env=environment)
        evaluator = started(stack, EVALUATOR, env=environment, cwd=tmp_path)
        status = evaluator.wait(timeout=120)
    assert status in (0, 1)  # 2: there is nothing to score, and a line says why
    score = json.loads((tmp_path / "score.json").read_text())
    assert status == 0, score["total_deg"]  # 1: the limit is broken
    assert score["samples"] == 2001
