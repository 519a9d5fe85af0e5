"""Bad input ends the node at its start: status 2, one line that says what and why, nothing written."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from simulator_process import DEADLINE, sim_command

from lie_rigid_body.ros.sim import main

pytestmark = pytest.mark.ros

BAD_PARAMETERS = {
    "inertia not positive": (["-p", "inertia:=[0.0, 1.0, 1.0]"], ["inertia", "positive"]),
    "inertia against the triangle": (["-p", "inertia:=[1.0, 1.0, 3.0]"], ["inertia", "triangle"]),
    "inertia of wrong length": (["-p", "inertia:=[1.0, 2.0]"], ["inertia", "3 or 6"]),
    "inertia empty": (["-p", "inertia:=[]"], ["inertia", "3 or 6"]),
    "inertia not a number": (["-p", "inertia:=[1.0, .nan, 3.0]"], ["inertia", "finite"]),
    "zero quaternion": (["-p", "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 0.0]"], ["initial_attitude_xyzw", "norm 0"]),
    "long quaternion": (["-p", "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 2.0]"], ["initial_attitude_xyzw", "norm 2"]),
    "rate zero": (["-p", "rate:=0.0"], ["rate", "0 is outside"]),
    "rate negative": (["-p", "rate:=-5.0"], ["rate", "-5 is outside"]),
    "rate infinite": (["-p", "rate:=.inf"], ["rate", "finite"]),
    "rate a word": (["-p", "rate:=fast"], ["rate", "'fast'"]),
    "unknown motion": (["-p", "motion:=perpetual"], ["motion", "moving_chart, closed_form"]),
    "unknown method": (["-p", "method:=rk5"], ["method", "rkmk4"]),
    "unknown name": (["-p", "metod:=rkmk4"], ["metod", "did you mean method"]),
    "step too long": (["-p", "method:=rkmk4", "-p", "max_step:=5.0", "-p", "rate:=0.1"], ["max_step", "more than 1"]),
    "epoch at the end of time": (["-p", "epoch_ns:=2147483647000000001"], ["epoch_ns", "outside"]),
    "no folder for the bag": (["-p", "record_path:=/no/such/folder/a.mcap"], ["record_path", "/no/such/folder"]),
    "bag exists": (["-p", "record_path:={folder}/existing.mcap"], ["record_path", "exists and is kept"]),
    "assignment without a value": (["-p", "rate:="], ["-p 'rate:='", "NAME:=VALUE"]),
    "params file missing": (["--params-file", "{folder}/none.yaml"], ["none.yaml", "does not exist"]),
    "params file not YAML": (["--params-file", "{folder}/broken.yaml"], ["broken.yaml", "YAML"]),
    "params file with a bad value": (["--params-file", "{folder}/bad.yaml"], ["inertia", "triangle"]),
    "params file with an unknown name": (["--params-file", "{folder}/unknown.yaml"], ["speed", "no such parameter"]),
}
CASES = {
    **{f"own: {name}": case for name, case in BAD_PARAMETERS.items() if "params file" in name or "bag" in name},
    **{f"ros: {name}": (["--ros-args", *arguments], words) for name, (arguments, words) in BAD_PARAMETERS.items()},
    "own: bad inertia": (["-p", "inertia:=[1.0, 1.0, 3.0]"], ["inertia", "triangle"]),
    "own: unknown scenario": (["--scenario", "perpetual"], ["--scenario 'perpetual'", "dzhanibekov"]),
    "own: unknown option": (["--fast"], ["--fast", "--help"]),
    "ros: unknown option": (["--ros-args", "--fast"], ["--fast"]),
    "ros: bad remapping": (["--ros-args", "-r", "pose"], ["-r pose"]),
    "ros: pose on twist": (["--ros-args", "-r", "pose:=twist"], ["pose and twist", "/twist"]),
    "ros: two topics in one": (
        ["--ros-args", "-r", "twist:=/a", "-r", "~/scenario:=/a"],
        ["twist and ~/scenario", "remapped to /a"],
    ),
    "ros: topic of another type": (["--ros-args", "-r", "pose:=/rosout"], ["the topic pose as /rosout"]),
    "ros: mixed numbers": (["--ros-args", "--params-file", "{folder}/mixed.yaml"], ["mixed.yaml", "same type"]),
}
FILES = {
    "existing.mcap": "precious",
    "broken.yaml": "/**: [",
    "bad.yaml": "/**:\n  ros__parameters:\n    inertia: [1.0, 1.0, 3.0]\n",
    "unknown.yaml": "/**:\n  ros__parameters:\n    speed: 1.0\n",
    "mixed.yaml": "/**:\n  ros__parameters:\n    inertia: [1, 2.5, 3]\n",
}

# Before rclpy is initialised, while it is, and while the node is made.
IN_A_PROCESS_OF_ITS_OWN = ["ros: params file not YAML", "ros: bad remapping", "ros: topic of another type"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def own_signals() -> Iterator[None]:
    """The node changes the signal handlers of its process; here they are pytest's."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    handlers = [signal.getsignal(number) for number in numbers]
    yield
    for number, handler in zip(numbers, handlers, strict=True):
        signal.signal(number, handler)


def filled(name: str, folder: Path) -> list[str]:
    return [argument.format(folder=folder) for argument in CASES[name][0]]


def require_one_good_line(name: str, out: str, err: str) -> None:
    assert out == ""
    [line] = err.splitlines()
    assert [word for word in CASES[name][1] if word not in line] == []


@pytest.mark.parametrize("name", CASES)
@pytest.mark.usefixtures("own_signals")
def test_refused_in_one_line_with_status_2(name: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(filled(name, folder)) == 2
    require_one_good_line(name, *capfd.readouterr())
    assert {path.name: path.read_text() for path in folder.iterdir()} == FILES


@pytest.mark.parametrize("name", IN_A_PROCESS_OF_ITS_OWN)
def test_process_ends_with_status_2(name: str, folder: Path) -> None:
    done = subprocess.run(
        sim_command(*filled(name, folder)), capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert done.returncode == 2
    require_one_good_line(name, done.stdout, done.stderr)
