"""What no node in this process can be asked: refusals of ROS itself, of limits, without libraries, and at its end.

Which arguments are refused, each in one line with status 2, is in `words_of_nodes`.
"""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from simulator_process import DEADLINE, SimulatorProcess, sim_command

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.ros.sim import main
from sampled import sampled

pytestmark = pytest.mark.ros

SECURE = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}
ENVIRONMENTS = [
    ({"ROS_DOMAIN_ID": "99999"}, "ROS_DOMAIN_ID 99999 "),
    ({"RMW_IMPLEMENTATION": "rmw_nope"}, "'rmw_nope'"),
    ({"HOME": "", "ROS_LOG_DIR": ""}, "ROS_LOG_DIR"),
    ({"RCUTILS_COLORIZED_OUTPUT": "7"}, "RCUTILS_COLORIZED_OUTPUT is '7': "),
    ({"RCUTILS_LOGGING_USE_STDOUT": "yes"}, "RCUTILS_LOGGING_USE_STDOUT is 'yes': "),
    ({"ROS_LOG_DIR": "/dev/null"}, "'/dev/null': 20: "),
    ({"ROS_LOG_DIR": "/proc/1"}, "ROS_LOG_DIR"),
    ({"ROS_STATIC_PEERS": "no..where"}, "no..where: "),
    (SECURE, "ROS_SECURITY_KEYSTORE"),
    ({**SECURE, "ROS_SECURITY_KEYSTORE": "/no"}, "ROS_SECURITY_KEYSTORE"),
]
"""Settings that ROS refuses: some by a status of its own, some by lines of its own, some without a reason."""


def refusal(*arguments: str, without: Sequence[str] = (), **options: Any) -> str:
    """The one line of a process that ends with status 2."""
    command = sim_command(*arguments, without=without)
    done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE, check=False, **options)
    assert (done.returncode, done.stdout) == (2, "")
    [line] = done.stderr.splitlines()
    assert line.startswith("lie-rigid-body sim: error: ")
    return line


@pytest.mark.parametrize(("settings", "said"), sampled(ENVIRONMENTS, every=3))
def test_an_environment_in_which_ros_does_not_start_is_refused(settings: dict[str, str], said: str) -> None:
    """In a process of its own, which ROS would end."""
    assert said in refusal(env={**os.environ, **settings})


@pytest.mark.parametrize(("name", "limit", "said"), [("NOFILE", 20, " 20 "), ("AS", 600_000_000, " 600 MB ")])
def test_a_limit_within_which_no_node_works_is_refused(name: str, limit: int, said: str, tmp_path: Path) -> None:
    import resource

    number = getattr(resource, f"RLIMIT_{name}")
    path = tmp_path / "new.mcap"
    limited: dict[str, Any] = {"preexec_fn": lambda: resource.setrlimit(number, (limit, limit))}
    assert said in refusal("-p", f"record_path:={path}", **limited)
    assert not path.exists()


@pytest.mark.slow
def test_without_a_bag_and_sensors_the_node_needs_few_libraries() -> None:
    with SimulatorProcess(without=["mcap", "zstandard", "scipy", "matplotlib", "tqdm"]) as running:
        assert running.end(signal.SIGINT) == 0
    assert running.errors() == []


def test_a_bag_that_cannot_be_written_is_told_before_the_first_sample(tmp_path: Path) -> None:
    assert refusal("-p", "record_path:=run.mcap", without=["mcap"], cwd=tmp_path).endswith(": pip install mcap")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("own_signals")
def test_a_pipe_is_refused_where_rclpy_would_find_it_empty(capfd: pytest.CaptureFixture[str]) -> None:
    ours, theirs = os.pipe()
    os.write(theirs, b"/**: {ros__parameters: {rate: 10.0}}")
    os.close(theirs)
    assert main(["--ros-args", "--params-file", f"/dev/fd/{ours}"]) == 2
    os.close(ours)
    assert f"/dev/fd/{ours}" in capfd.readouterr().err


def test_an_end_while_a_wait_begins_is_no_failed_callback(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    import rclpy

    from lie_rigid_body.ros import session

    def wait(executor: session.Pool, timeout_sec: float) -> None:
        rclpy.try_shutdown()
        raise RuntimeError("the context of the wait set is not valid")

    monkeypatch.setattr(session.Pool, "wait_for_ready_callbacks", wait)
    with session.initialised([]), session.spinning(rclpy.create_node("ended")):
        pass
    assert capfd.readouterr() == ("", "")


def test_a_change_of_pace_while_the_node_ends_is_refused_and_not_left_as_a_failure(
    isolated_ros: None, capfd: pytest.CaptureFixture[str]
) -> None:
    from peer import Peer

    from lie_rigid_body.ros import session
    from lie_rigid_body.ros.node import SimulatorNode
    from lie_rigid_body.ros.timing.requests import Mailbox

    mailbox = Mailbox()
    mailbox.close()
    ended: Any = SimpleNamespace(ask=mailbox.request, change_factor=float)
    with session.initialised([]):
        node = SimulatorNode(lambda name, namespace: {})
        with session.destroying(node), session.spinning(node):
            node.serve(ended)
            with Peer("asking") as peer:
                result = peer.set_together(real_time_factor=2.0)
    assert not result.successful
    assert "never retrieved" not in capfd.readouterr().err


def test_settings_of_the_middleware_are_those_of_the_user_where_there_are_any(
    isolated_ros: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lie_rigid_body.ros import session

    monkeypatch.setenv("RMW_FASTRTPS_PUBLICATION_MODE", "SYNCHRONOUS")
    monkeypatch.delenv("ZENOH_ROUTER_CHECK_ATTEMPTS", raising=False)
    with session.initialised([]):
        assert os.environ["RMW_FASTRTPS_PUBLICATION_MODE"] == "SYNCHRONOUS"
        assert int(os.environ["ZENOH_ROUTER_CHECK_ATTEMPTS"]) > 0
    monkeypatch.delenv("ZENOH_ROUTER_CHECK_ATTEMPTS")
    with pytest.raises(InputError) as refused, session.translated_errors("to start"):
        raise RuntimeError("failed to initialize rcl: Unable to connect to a Zenoh router after 5 retries., at x.c:1")
    assert "rmw_zenohd" in str(refused.value)
