"""Bad input ends the node at its start: status 2, one line that says what and why, nothing written."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from simulator_process import DEADLINE, sim_command
from test_wording_of_ros import phrase

from lie_rigid_body.ros.sim import main
from sampled import sampled

pytestmark = pytest.mark.ros

BAD_PARAMETERS = {
    "inertia not positive": (["-p", "inertia:=[0.0, 1.0, 1.0]"], ["inertia", " 0.0 "]),
    "inertia against the triangle": (["-p", "inertia:=[1.0, 1.0, 3.0]"], ["inertia", " 3.0 "]),
    "inertia of wrong length": (["-p", "inertia:=[1.0, 2.0]"], ["inertia", "3 or 6"]),
    "inertia empty": (["-p", "inertia:=[]"], ["inertia", "3 or 6"]),
    "inertia not a number": (["-p", "inertia:=[1.0, .nan, 3.0]"], ["inertia", "nan "]),
    "zero quaternion": (["-p", "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 0.0]"], ["initial_attitude_xyzw", " 0 "]),
    "long quaternion": (["-p", "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 2.0]"], ["initial_attitude_xyzw", " 2 "]),
    "rate zero": (["-p", "rate:=0.0"], ["rate", " 0 "]),
    "rate negative": (["-p", "rate:=-5.0"], ["rate", " -5 "]),
    "rate infinite": (["-p", "rate:=.inf"], ["rate", " inf "]),
    "rate a word": (["-p", "rate:=fast"], ["rate", "'fast'"]),
    "unknown motion": (["-p", "motion:=perpetual"], ["motion", "moving_chart, closed_form"]),
    "unknown method": (["-p", "method:=rk5"], ["method", "rkmk4"]),
    "unknown name": (["-p", "metod:=rkmk4"], ["metod", "method?"]),
    "step too long": (["-p", "method:=rkmk4", "-p", "max_step:=5.0", "-p", "rate:=0.1"], ["max_step", " 5 s "]),
    "steps without end": (["-p", "rate:=0.01", "-p", "max_step:=1e-9"], ["max_step", "1e+11"]),
    "epoch at the end of time": (["-p", "epoch_ns:=2147483647000000001"], ["epoch_ns", "2147483647000000000]"]),
    "no folder for the bag": (["-p", "record_path:=/no/such/folder/a.mcap"], ["record_path", "/no/such/folder"]),
    "bag exists": (["-p", "record_path:={folder}/existing.mcap"], ["record_path", "existing.mcap " + phrase("kept")]),
    "assignment without a value": (["-p", "rate:="], ["-p 'rate:='", "NAME:=VALUE"]),
    "params file missing": (["--params-file", "{folder}/none.yaml"], ["none.yaml "]),
    "params file not YAML": (["--params-file", "{folder}/broken.yaml"], ["broken.yaml", "YAML"]),
    "params file with a bad value": (["--params-file", "{folder}/bad.yaml"], ["inertia", " 3.0 "]),
    "params file with an unknown name": (["--params-file", "{folder}/unknown.yaml"], ["speed: "]),
}
CASES = {
    **{f"own: {name}": case for name, case in BAD_PARAMETERS.items() if "params file" in name or "bag" in name},
    **{f"ros: {name}": (["--ros-args", *arguments], words) for name, (arguments, words) in BAD_PARAMETERS.items()},
    "own: bad inertia": (["-p", "inertia:=[1.0, 1.0, 3.0]"], ["inertia", " 3.0 "]),
    "own: unknown scenario": (["--scenario", "perpetual"], ["scenario 'perpetual'", "dzhanibekov"]),
    "own: unknown option": (["--fast"], ["--fast", "--help"]),
    "own: clock before 1970, with a bag": (
        [
            *("-p", "epoch_ns:=5", "-p", "record_path:={folder}/new.mcap"),
            *("-p", "sun_sensor_rate:=33.3", "-p", "sun_sensor_clock_offset:=-100.0"),
        ],
        ["sun_sensor_clock_offset", " -99999999995 ns"],
    ),
    "ros: unknown option": (["--ros-args", "--fast"], [phrase("refused by ROS", given="--fast")]),
    "own: quality of service": (["-p", "qos_overrides./pose.publisher.depth:=5"], ["depth", phrase("for every node")]),
    "own: simulated time": (["-p", "use_sim_time:=true"], ["use_sim_time", phrase("for every node")]),
    **{
        f"ros: depth {depth}": (
            ["--ros-args", "-p", f"qos_overrides./pose.publisher.depth:={depth}"],
            ["/pose", phrase("depth", depth=depth)],
        )
        for depth in (0, -1, 2**31, 2**63 - 1)
    },
    "ros: bad remapping": (["--ros-args", "-r", "pose"], [phrase("refused by ROS", given="-r pose")]),
    "ros: pose on twist": (
        ["--ros-args", "-r", "pose:=twist"],
        [phrase("one name", first="pose", second="twist", name="/twist")],
    ),
    "ros: two topics in one": (
        ["--ros-args", "-r", "twist:=/a", "-r", "~/scenario:=/a"],
        [phrase("one name", first="twist", second="~/scenario", name="/a")],
    ),
    "ros: topic of another type": (
        ["--ros-args", "-r", "pose:=/rosout"],
        [phrase("one name", first="pose", second="/rosout", name="/rosout")],
    ),
    "ros: the clock is no twist": (
        ["--ros-args", "-r", "twist:=/clock"],
        [phrase("one name", first="twist", second="/clock", name="/clock")],
    ),
    "ros: reset on pause": (
        ["--ros-args", "-r", "~/reset:=~/pause"],
        [phrase("one name", first="~/reset", second="~/pause", name="/lie_rigid_body/pause")],
    ),
    "ros: reset on parameters": (
        ["--ros-args", "-r", "~/reset:=~/set_parameters"],
        ["~/reset", "~/set_parameters", " /lie_rigid_body/set_parameters: "],
    ),
    "ros: bad topic name": (["--ros-args", "-r", "pose:=/a//b"], ["pose:=/a//b"]),
    "ros: long node name": (["--ros-args", "-r", f"__node:={300 * 'n'}"], [phrase("long name", count=300)]),
    "ros: node name too long for services": (
        ["--ros-args", "-r", f"__node:={240 * 'n'}"],
        [phrase("long name", count=240)],
    ),
    "ros: params file a device": (["--ros-args", "--params-file", "/dev/zero"], ["/dev/zero "]),
    "ros: mixed numbers": (["--ros-args", "--params-file", "{folder}/mixed.yaml"], ["mixed.yaml", "--params-file"]),
}
FILES = {
    "existing.mcap": "precious",
    "broken.yaml": "/**: [",
    "bad.yaml": "/**:\n  ros__parameters:\n    inertia: [1.0, 1.0, 3.0]\n",
    "unknown.yaml": "/**:\n  ros__parameters:\n    speed: 1.0\n",
    "mixed.yaml": "/**:\n  ros__parameters:\n    inertia: [1, 2.5, 3]\n",
}

# Before rclpy is initialised, while it is, and while the node is made.
IN_A_PROCESS_OF_ITS_OWN = [
    *("ros: params file not YAML", "ros: topic of another type"),
    *("ros: bad remapping", "ros: long node name"),
    *("ros: depth 0", "ros: depth -1"),
]
ENVIRONMENTS = [
    ({"ROS_DOMAIN_ID": "99999"}, phrase("domain", given=99999)),
    ({"RMW_IMPLEMENTATION": "rmw_nope"}, phrase("middleware", given="rmw_nope")),
    ({"HOME": "", "ROS_LOG_DIR": ""}, phrase("log folder")),
    ({"RCUTILS_COLORIZED_OUTPUT": "7"}, phrase("a switch", name="RCUTILS_COLORIZED_OUTPUT", given="7")),
    ({"RCUTILS_LOGGING_USE_STDOUT": "yes"}, phrase("a switch", name="RCUTILS_LOGGING_USE_STDOUT", given="yes")),
    ({"ROS_LOG_DIR": "/dev/null"}, "'/dev/null': 20" + phrase("log folder")),
    ({"ROS_LOG_DIR": "/proc/1"}, phrase("log folder")),
    ({"ROS_STATIC_PEERS": "no..where"}, "no..where" + phrase("peers")),
    ({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, phrase("no keys")),
    (
        {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": "/no"},
        phrase("bad keys"),
    ),
]
"""Settings that ROS refuses: some by a status of its own, some by lines of its own, some without a reason."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


def filled(name: str, folder: Path) -> list[str]:
    return [argument.format(folder=folder) for argument in CASES[name][0]]


def require_one_good_line(name: str, out: str, err: str) -> None:
    assert out == ""
    [line] = err.splitlines()
    assert [word for word in CASES[name][1] if word not in line] == []


@pytest.fixture(autouse=True)
def deadline() -> Iterator[None]:
    """The end of a node that takes what it should refuse: it would run for ever, in this process."""
    end = threading.Timer(DEADLINE, os.kill, (os.getpid(), signal.SIGTERM))
    end.start()
    yield
    end.cancel()


@pytest.mark.parametrize("name", CASES)
def test_refused_in_one_line_with_status_2(name: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(filled(name, folder)) == 2
    require_one_good_line(name, *capfd.readouterr())
    assert {path.name: path.read_text() for path in folder.iterdir()} == FILES


@pytest.mark.parametrize("name", sampled(IN_A_PROCESS_OF_ITS_OWN, every=2))
def test_process_ends_with_status_2(name: str, folder: Path) -> None:
    done = subprocess.run(
        sim_command(*filled(name, folder)), capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert done.returncode == 2
    require_one_good_line(name, done.stdout, done.stderr)


@pytest.mark.parametrize(("settings", "said"), sampled(ENVIRONMENTS, every=3))
def test_an_environment_in_which_ros_does_not_start_is_refused(settings: dict[str, str], said: str) -> None:
    """In a process of its own, which ROS would end."""
    environment = {**os.environ, **settings}
    done = subprocess.run(sim_command(), capture_output=True, text=True, timeout=DEADLINE, check=False, env=environment)
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert said in line


@pytest.mark.parametrize(("name", "limit"), [("RLIMIT_NOFILE", 20), ("RLIMIT_AS", 600_000_000)])
def test_a_limit_within_which_no_node_works_is_refused(name: str, limit: int, tmp_path: Path) -> None:
    import resource

    number, path = getattr(resource, name), tmp_path / "new.mcap"
    done = subprocess.run(
        sim_command("-p", f"record_path:={path}"),
        preexec_fn=lambda: resource.setrlimit(number, (limit, limit)),
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert done.returncode == 2
    [line] = done.stderr.splitlines()
    assert phrase("limited", what={"RLIMIT_NOFILE": "20", "RLIMIT_AS": "600 MB"}[name]) in line
    assert not path.exists()


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
    from rclpy.executors import MultiThreadedExecutor

    from lie_rigid_body.ros import session

    def spin(executor: MultiThreadedExecutor) -> None:
        rclpy.try_shutdown()
        raise RuntimeError("the context of the wait set is not valid")

    monkeypatch.setattr(MultiThreadedExecutor, "spin", spin)
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
