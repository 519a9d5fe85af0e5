"""The launch files hand on what they are given, and end together: `words_of_launch` has what they start and refuse."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from launched import LAUNCH, Node, described, launched, stand_ins

from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.report import score_options
from lie_rigid_body.ros import launching
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import parse_assignment, scenario_files
from lie_rigid_body.scenario.parameter_table import read_parameters

FILES = sorted(LAUNCH.glob("*.launch.py"))
ESTIMATOR = "estimator.launch.py"
RUNNING, ENDING = SimpleNamespace(is_shutdown=False), SimpleNamespace(is_shutdown=True)

Launch = Callable[..., list[Node]]


@pytest.fixture
def launch(tmp_path: Path) -> Launch:
    return lambda file, **given: launched(file, tmp_path, **given)


def of(nodes: list[Node], package: str) -> list[Node]:
    return [node for node in nodes if node["package"] == package]


def parameters_of(node: Node) -> dict[str, object]:
    """The parameters that a simulator is given, as it reads them."""
    words = node["arguments"]
    return dict(parse_assignment(word) for before, word in zip(words[::2], words[1::2], strict=True) if before == "-p")


def topics(view: dict[str, Any]) -> set[str]:
    displays = view["Visualization Manager"]["Displays"]
    return {display["Topic"]["Value"] for display in displays if "Topic" in display}


def test_rviz_shows_every_body_in_its_namespace(launch: Launch) -> None:
    _, view = launch("sim.launch.py", namespace="a", rviz="true")
    shown = topics(yaml.safe_load(Path(view["arguments"][1]).read_text(encoding="utf-8")))
    # a relative name is the node's, in its namespace
    assert dict(view["remappings"]) == {topic: topic.removeprefix("/") for topic in shown}
    [view] = of(launch("bodies.launch.py", bodies="a,b", rviz="true"), "rviz2")
    file = Path(view["arguments"][1])
    drawn = yaml.safe_load(file.read_text(encoding="utf-8"))
    file.unlink()
    assert topics(drawn) == {"/a/markers", "/a/pose", "/b/markers", "/b/pose"}
    assert drawn["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"


def test_bodies_have_scenarios_frames_and_bags_of_their_own(launch: Launch) -> None:
    default = of(launch("bodies.launch.py"), "lie_rigid_body")
    assert {node["arguments"][1] for node in default} <= set(scenario_files())
    nodes = of(launch("bodies.launch.py", bodies="a:dzhanibekov, b:symmetric_top,c", record="true"), "lie_rigid_body")
    parameters = [parameters_of(node) for node in nodes]
    for name in ("world_frame", "body_frame", "imu_frame", "record_path"):
        assert len({given[name] for given in parameters}) == 3, name
    for given in parameters:
        Scenario.from_parameters(read_parameters(given))


def test_arguments_of_a_launch_file_that_includes_this_one_are_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "robot", "robot.launch.py", "colour:=red"])
    launching.require_known("/launch/sim.launch.py", ["colour:=red"], ["scenario"])


def test_filters_and_evaluators_read_what_they_are_given(launch: Launch) -> None:
    sim, *_ = launch(ESTIMATOR, package="imu_filter_madgwick")
    scenario = launching.scenario_of_node(sim["arguments"], "lie_rigid_body", "")
    assert scenario.sensors.imu is not None
    assert scenario.sensors.magnetometer is not None
    *_, evaluator = launch(ESTIMATOR, package="imu_filter_madgwick", max_after="1s:3deg 10s:2deg", duration="60")
    asked = score_options.parse(evaluator["arguments"])
    assert (asked.max_after, asked.duration) == (["1s:3deg", "10s:2deg"], 60.0)
    locked, *_ = launch(ESTIMATOR, package="imu_filter_madgwick", lockstep="true")
    assert read_parameters(parameters_of(locked))["lockstep_nodes"] == ("evaluator",)


def ended(status: int) -> SimpleNamespace:
    return SimpleNamespace(process_name="it-3", returncode=status)


@pytest.mark.parametrize("file", ["sim.launch.py", "bodies.launch.py"])
def test_when_one_part_ends_nothing_is_left_running(launch: Launch, file: str) -> None:
    for node in launch(file, rviz="true"):
        if node["package"] != "rviz2":
            assert node["on_exit"].startswith("end everything")
            continue
        with stand_ins():
            assert node["on_exit"](ended(0), None) is None
            assert node["on_exit"](ended(-6), None).startswith("end everything: ")


def test_the_end_of_the_evaluator_is_that_of_the_launch(launch: Launch) -> None:
    sim, estimator, evaluator = launch(ESTIMATOR, package="imu_filter_madgwick")
    with stand_ins():
        assert evaluator["on_exit"](ended(0), RUNNING).startswith("end everything: ")
        assert evaluator["on_exit"](ended(0), ENDING) is None
        for context in (RUNNING, ENDING):  # launch ends everything after an exception, with status 1
            for status in (1, 2):
                with pytest.raises(LieRigidBodyError):
                    evaluator["on_exit"](ended(status), context)
        for node in (sim, estimator):
            assert node["on_exit"](ended(0), ENDING) is None
            with pytest.raises(LieRigidBodyError):
                node["on_exit"](ended(-6), RUNNING)


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros is not installed: PyPI does not have it")
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_it_loads_with_the_real_libraries(file: Path) -> None:
    description = runpy.run_path(str(file))["generate_launch_description"]()
    assert len(description.entities) == len(described(file.name))
