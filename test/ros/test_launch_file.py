"""The launch files with the real launch: what they start, how it ends, and what they refuse before anything is started.

The programs that they start are stand-ins, which write down what they were given. PyPI does not have launch.
"""

from __future__ import annotations

import json
import os
import stat
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import yaml

from lie_rigid_body.report import score_options
from lie_rigid_body.ros import launching
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather, read_sections

LAUNCH = Path(__file__).parents[2] / "launch"
FILES = sorted(path.name for path in LAUNCH.glob("*.launch.py"))
PROGRAMS = {
    "lie_rigid_body": ("sim", "evaluate"),
    "tf2_ros": ("static_transform_publisher",),
    "rviz2": ("rviz2",),
    "mine": ("filter",),
}
"""Executables that the launch files may start, by their packages."""
STAND_IN = """\
#!{python}
import json, sys, time
from pathlib import Path
words = sys.argv[1:]
files = []
for before, word in zip(words, words[1:]):
    if before == "--params-file":  # launch removes its own at its end
        files.append(f"{folder}/{{time.time_ns()}}.yaml")
        Path(files[-1]).write_text(Path(word).read_text())
given = json.dumps([Path(sys.argv[0]).name, words, files])
Path("{folder}", f"{{time.time_ns()}}.json").write_text(given)
while len([*Path("{folder}").glob("*.json")]) < {count} or Path(sys.argv[0]).name != "{first}":
    time.sleep(0.05)
sys.exit({status})
"""
"""It stays until as many have started as will; then the one whose end is that of all ends, with a status."""

Launched = Callable[..., tuple[int, list["Started"]]]
with_launch = pytest.mark.skipif(
    find_spec("launch_ros") is None, reason="launch_ros is not installed: it is not on PyPI"
)


class Started:
    """A program that was started, and what it was given."""

    def __init__(self, name: str, words: list[str], files: list[str]) -> None:
        self.name = name
        own = words.index("--ros-args") if "--ros-args" in words else len(words)
        self.words, self.ros = words[:own], words[own:]
        self.parameters: dict[str, Any] = {}
        for path in files:
            for _, values in read_sections(path):
                self.parameters |= values

    def scenario(self) -> Scenario:
        name = self.words[1] if self.words[:1] == ["--scenario"] else None
        return Scenario.from_parameters({**gather(name, (), ()), **self.parameters})


@pytest.fixture
def launched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Launched:
    """A function that launches a file, and gives the exit status and what was started."""

    def run(file: str, count: int = 1, first: str = "sim", status: int = 0, actions: Any = (), **given: str) -> Any:
        from launch import LaunchDescription, LaunchService  # type: ignore[attr-defined]
        from launch.actions import IncludeLaunchDescription
        from launch.launch_description_sources import PythonLaunchDescriptionSource

        folder = tmp_path / f"{len([*tmp_path.iterdir()])}"
        folder.mkdir()
        for package, names in PROGRAMS.items():
            (folder / "share/ament_index/resource_index/packages").mkdir(parents=True, exist_ok=True)
            (folder / "share/ament_index/resource_index/packages" / package).touch()
            for name in names:
                path = folder / "lib" / package / name
                path.parent.mkdir(parents=True, exist_ok=True)
                what = {"python": sys.executable, "folder": folder, "count": count, "first": first, "status": status}
                path.write_text(STAND_IN.format(**what))
                path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("AMENT_PREFIX_PATH", f"{folder}{os.pathsep}{os.environ.get('AMENT_PREFIX_PATH', '')}")
        monkeypatch.setattr(sys, "argv", ["ros2", "launch", "lie_rigid_body", file])
        service = LaunchService(argv=[f"{name}:={value}" for name, value in given.items()], noninteractive=True)
        source = PythonLaunchDescriptionSource(str(LAUNCH / file))
        include = IncludeLaunchDescription(source, launch_arguments=given.items())
        service.include_launch_description(LaunchDescription([*actions, include]))
        ended = service.run()
        return ended, [Started(*json.loads(path.read_text())) for path in sorted(folder.glob("*.json"))]

    return run


def test_they_are_short() -> None:
    assert {name for name in FILES if len((LAUNCH / name).read_text().splitlines()) > 60} == set()


@with_launch
def test_a_node_is_given_its_parameters_as_such(launched: Launched) -> None:
    """So that a launch file that includes this one sees and sets them; an empty list has no type for launch_ros."""
    from launch_ros.actions import SetParameter

    given = {"scenario": "dzhanibekov", "rate": "200", "inertia": "[1, 2, 2.5]", "kicks": "[]", "world_frame": "map"}
    status, [sim] = launched("sim.launch.py", actions=[SetParameter(name="imu_rate", value=50.0)], **given)
    assert status == 0
    assert sim.words == ["--scenario", "dzhanibekov", "-p", "kicks:=[]"]
    assert sim.parameters == {"rate": 200.0, "inertia": [1.0, 2.0, 2.5], "world_frame": "map"}
    assert "imu_rate:=50.0" in sim.ros
    assert sim.scenario().rate == 200.0


@with_launch
def test_bodies_have_scenarios_frames_places_and_bags_of_their_own(launched: Launched) -> None:
    _, started = launched("bodies.launch.py", count=6, bodies="a:dzhanibekov,b:symmetric_top,c", record="true")
    sims = [each for each in started if each.name == "sim"]
    assert {each.words[1] for each in sims if each.words} == {"dzhanibekov", "symmetric_top"}
    for name in ("world_frame", "body_frame", "imu_frame", "record_path"):
        assert len({sim.parameters[name] for sim in sims}) == 3, name
    for sim in sims:
        sim.scenario()
    places = [each.words for each in started if each.name == "static_transform_publisher"]
    assert sorted(float(words[1]) for words in places) == [0.0, 2.5, 5.0]


@with_launch
def test_the_view_of_several_bodies_shows_each(launched: Launched) -> None:
    _, started = launched("bodies.launch.py", count=5, bodies="a,b", rviz="true")
    [view] = [each for each in started if each.name == "rviz2"]
    file = Path(view.words[view.words.index("--display-config") + 1])
    displays = yaml.safe_load(file.read_text())["Visualization Manager"]["Displays"]
    file.unlink()
    topics = {display["Topic"]["Value"] for display in displays if "Topic" in display}
    assert topics == {"/a/markers", "/a/pose", "/b/markers", "/b/pose"}


@with_launch
@pytest.mark.parametrize("status", [0, 1, 2])
def test_the_end_of_the_evaluator_is_that_of_the_launch(launched: Launched, status: int) -> None:
    given = {"max_after": "1s:3deg 10s:2deg", "duration": "60", "lockstep": "true", "parameters": "gain:=0.5"}
    ended, started = launched(
        "estimator.launch.py", count=3, first="evaluate", status=status, package="mine", executable="filter", **given
    )
    assert ended == bool(status)
    by_name = {each.name: each for each in started}
    asked = score_options.parse(by_name["evaluate"].words)
    assert (asked.max_after, asked.duration) == (["1s:3deg", "10s:2deg"], 60.0)
    scenario = by_name["sim"].scenario()
    assert scenario.sensors.imu is not None
    assert scenario.sensors.magnetometer is not None
    assert by_name["sim"].parameters["lockstep_nodes"] == ["evaluator"]
    assert by_name["filter"].parameters == {"gain": 0.5}


@with_launch
def test_a_simulator_that_fails_makes_the_launch_fail(launched: Launched) -> None:
    assert launched("sim.launch.py", status=2)[0] == 1


@with_launch
@pytest.mark.parametrize(
    ("file", "given"),
    [
        ("sim.launch.py", {"scenario": "dzanibekov"}),
        ("sim.launch.py", {"rate": "-1.0"}),
        ("sim.launch.py", {"rte": "1.0"}),
        ("bodies.launch.py", {"bodies": "a:dzhanibekov,a:symmetric_top"}),
        ("bodies.launch.py", {"bodies": "a/b:dzhanibekov"}),
        ("bodies.launch.py", {"bodies": "a:dzhanibekov,b:dzanibekov"}),
        ("bodies.launch.py", {"spacing": "wide"}),
        ("bodies.launch.py", {"record_path": "a.mcap"}),
        ("estimator.launch.py", {"package": "nowhere", "executable": "filter"}),
        ("estimator.launch.py", {"package": "mine"}),
        ("estimator.launch.py", {"max_rms": "1"}),
        ("estimator.launch.py", {"remappings": "imu", "package": "mine", "executable": "filter"}),
        ("estimator.launch.py", {"parameters": "gain=1", "package": "mine", "executable": "filter"}),
    ],
)
def test_what_is_wrong_is_refused_before_anything_is_started(
    launched: Launched, file: str, given: dict[str, str]
) -> None:
    assert launched(file, **given) == (1, [])


def test_arguments_of_a_launch_file_that_includes_this_one_are_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "robot", "robot.launch.py", "colour:=red"])
    launching.require_known("/launch/sim.launch.py", ["colour:=red"], ["scenario"])
