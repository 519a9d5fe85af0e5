"""The listener for places without the ros2 command: what it shows, and how it fails."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from functools import partial
from importlib import import_module

import pytest
from simulator_process import DEADLINE, SimulatorProcess

from lie_rigid_body.ros.listen import main

LISTEN = (sys.executable, "-m", "lie_rigid_body.ros.listen")


def test_without_ros_it_says_the_same_as_sim(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main([]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "rclpy" in line


@pytest.mark.ros
@pytest.mark.parametrize("arguments", [("--pose", "a b"), ("--pose", ""), ("--reset", "1/2"), ("--fast",)])
def test_bad_names_are_refused_in_one_line(arguments: tuple[str, ...], capfd: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    [line] = capfd.readouterr().err.splitlines()
    assert arguments[0] in line


@pytest.mark.ros
def test_process_ends_with_status_2() -> None:
    done = subprocess.run((*LISTEN, "--pose", "a b"), capture_output=True, text=True, timeout=DEADLINE, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)


@pytest.mark.ros
def test_silence_is_told_once() -> None:
    soon = "from lie_rigid_body.ros import client, listen; client.LONGEST_SILENCE = 0.2; listen.main(['--pose', '/no'])"
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
    assert f"nothing yet on /no in domain {os.environ['ROS_DOMAIN_ID']}" in line
    assert (process.returncode, rest) == (0, "")


@pytest.mark.ros
def test_reader_who_leaves_hears_no_complaint(full_node: SimulatorProcess) -> None:
    command = f"ROS_DOMAIN_ID={full_node.domain} {' '.join(LISTEN)} | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=DEADLINE, check=False)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1


@pytest.mark.ros
def test_scenario_control_and_parameters_without_the_ros2_command(capfd: pytest.CaptureFixture[str]) -> None:
    asked = partial(answer, capfd)
    with SimulatorProcess("-p", "rate:=5.0", "--ros-args", "-r", "__ns:=/quiet"):
        node = "/quiet/lie_rigid_body"
        assert json.loads(asked("--scenario", f"{node}/scenario"))["rate"] == 5.0
        assert asked("--pause", f"{node}/pause").startswith("time stands still at ")
        assert asked("--step", f"{node}/step").startswith("sent the sample stamped ")
        assert asked("--resume", f"{node}/resume") == "time goes on"
        assert asked("--set", "rate:=40", "--node", node) == f"{node} has rate 40"
        assert asked("--get", "rate", "--node", node) == "40.0"
        long = f"inertia:=[{', '.join(['1.0'] * 100)}]"
        assert f"{node} refuses --set inertia: " in asked("--set", long, "--node", node, status=2)
        for option, said in (("--set", "paused:=true"), "call ~/pause"), (("--get", "rte"), "no such parameter"):
            assert said in asked(*option, "--node", node, status=2)


@pytest.mark.ros
def test_no_answer_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(import_module("lie_rigid_body.ros.client"), "LONGEST_SILENCE", 0.1)
    for option in (["--reset", "/nobody"], ["--scenario", "/nobody"], ["--get", "rate", "--node", "/nobody"]):
        assert main(option) == 2
        [line] = capfd.readouterr().err.splitlines()
        assert "/nobody" in line
        assert "is the node running?" in line


def answer(capfd: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert main(arguments) == status
    said, complained = capfd.readouterr()
    # the middleware may complain on either before
    return (said if status == 0 else complained).splitlines()[-1]
