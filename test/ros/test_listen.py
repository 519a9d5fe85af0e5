"""The listener for places without the ros2 command: what it shows, and how it fails."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from functools import partial

import pytest
from simulator_process import DEADLINE, SimulatorProcess

from lie_rigid_body.ros.listen import main
from said import numbers

pytestmark = pytest.mark.ros
LISTEN = (sys.executable, "-m", "lie_rigid_body.ros.listen")


@pytest.mark.slow
def test_silence_is_told_once() -> None:
    soon = "from lie_rigid_body.ros import client, listen; client.MAX_SILENCE = 0.2; listen.main(['--pose', '/no'])"
    with subprocess.Popen((sys.executable, "-c", soon), stderr=subprocess.PIPE, text=True) as process:
        patience = threading.Timer(DEADLINE, process.kill)
        patience.start()
        try:
            assert process.stderr
            line = process.stderr.readline()
            process.send_signal(signal.SIGINT)
            _, rest = process.communicate(timeout=DEADLINE)
        finally:
            patience.cancel()
            process.kill()
    assert f" /no in domain {os.environ['ROS_DOMAIN_ID']}: " in line
    assert (process.returncode, rest) == (0, "")


@pytest.mark.slow
def test_reader_who_leaves_hears_no_complaint(full_node: SimulatorProcess) -> None:
    command = f"ROS_DOMAIN_ID={full_node.domain} {' '.join(LISTEN)} | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=DEADLINE, check=False)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1


@pytest.mark.slow
def test_scenario_control_and_parameters_without_the_ros2_command(capfd: pytest.CaptureFixture[str]) -> None:
    asked = partial(answer, capfd)
    with SimulatorProcess("-p", "rate:=5.0", "--ros-args", "-r", "__ns:=/quiet"):
        node = "/quiet/lie_rigid_body"
        assert json.loads(asked("--scenario", f"{node}/scenario"))["rate"] == 5.0
        assert asked("--pause", f"{node}/pause").endswith(" ns")
        assert asked("--step", f"{node}/step").endswith(" ns")
        assert asked("--resume", f"{node}/resume")
        assert numbers(asked("--set", "rate:=40", "--node", node)) == [40]
        assert asked("--get", "rate", "--node", node) == "40.0"
        long = f"inertia:=[{', '.join(['1.0'] * 100)}]"
        for option, given in ("--set", long), ("--set", "paused:=true"), ("--get", "rte"):
            line = asked(option, given, "--node", node, status=2)
            assert (node in line, given.partition(":=")[0] in line) == (True, True)


@pytest.mark.parametrize("asked", ["--reset /nobody", "--scenario /nobody", "--get rate --node /nobody"])
def test_whom_nobody_answers_is_told_in_one_line(
    asked: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("lie_rigid_body.ros.client.MAX_SILENCE", 0.1)
    assert main(asked.split()) == 2
    [line] = capfd.readouterr().err.splitlines()
    assert f" /nobody in domain {os.environ['ROS_DOMAIN_ID']}: " in line


def answer(capfd: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert main(arguments) == status
    said, complained = capfd.readouterr()
    # the middleware may complain on either before
    return (said if status == 0 else complained).splitlines()[-1]
