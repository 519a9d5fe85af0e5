"""The launch files load, and hand on what they are given and nothing else."""

from __future__ import annotations

import re
import runpy
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
import yaml

from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import scenario_files
from lie_rigid_body.scenario.parameter_table import read_parameters

LAUNCH = Path(__file__).parents[2] / "launch"
FILES = sorted(LAUNCH.glob("*.launch.py"))
ARGUMENTS = {
    "sim.launch.py": {
        *("scenario", "params_file", "namespace", "name", "world_frame", "body_frame", "imu_frame"),
        *("record", "record_path", "rviz"),
    },
    "bodies.launch.py": {"bodies", "params_file", "spacing", "record", "rviz"},
}

Node = dict[str, Any]
Launch = Callable[..., list[Node]]


def modules_with(**names: object) -> dict[str, ModuleType]:
    """Stand-ins for the launch libraries, which PyPI does not have."""
    found = {}
    for name in ("launch", "launch.actions", "launch.substitutions", "launch_ros", "launch_ros.actions"):
        found[name] = ModuleType(name)
        found[name].__dict__.update(names)
    return found


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    """What a launch file describes, by its name."""
    stand_ins = modules_with(
        LaunchContext=object,
        LaunchDescription=lambda actions: actions,
        DeclareLaunchArgument=lambda name, **settings: (name, settings),
        OpaqueFunction=lambda function: function,
        LaunchConfiguration=lambda name: SimpleNamespace(perform=lambda context: context[name]),
        Node=lambda **settings: settings,
    )
    for name, module in stand_ins.items():
        monkeypatch.setitem(sys.modules, name, module)
    return lambda file: runpy.run_path(str(LAUNCH / file))["generate_launch_description"]()


@pytest.fixture
def launch(described: Callable[[str], Any]) -> Launch:
    """The nodes that a launch file starts, with its defaults where an argument is not given."""

    def nodes(file: str, **given: str) -> list[Node]:
        *declared, function = described(file)
        started: list[Node] = function({name: settings["default_value"] for name, settings in declared} | given)
        return started

    return nodes


@pytest.mark.parametrize("file", ARGUMENTS)
def test_arguments_are_described_and_switches_have_two_values(file: str, described: Callable[[str], Any]) -> None:
    *declared, _ = described(file)
    assert {name for name, _ in declared} == ARGUMENTS[file]
    assert all(settings["description"] for _, settings in declared)
    choices = {name: settings["choices"] for name, settings in declared if "choices" in settings}
    assert choices == {"record": ["true", "false"], "rviz": ["true", "false"]}


@pytest.mark.parametrize(
    ("given", "arguments", "parameters", "names"),
    [
        ({}, [], [], ("", "lie_rigid_body")),
        (
            {
                "scenario": "dzhanibekov",
                "params_file": "p.yaml",
                "namespace": "a",
                "name": "top",
                "record_path": "a.mcap",
                "record": "true",
                "body_frame": "a/base_link",
            },
            ["--scenario", "dzhanibekov", "--params-file", "p.yaml"],
            [{"record_path": "a.mcap", "body_frame": "a/base_link"}],
            ("a", "top"),
        ),
    ],
)
def test_what_is_given_reaches_the_node(
    launch: Launch,
    given: dict[str, str],
    arguments: list[str],
    parameters: list[dict[str, str]],
    names: tuple[str, str],
) -> None:
    [node] = launch("sim.launch.py", **given)
    assert (node["package"], node["executable"]) == ("lie_rigid_body", "sim")
    assert (node["arguments"], node["parameters"]) == (arguments, parameters)
    assert (node["namespace"], node["name"]) == names


def test_a_bag_is_named_after_node_and_time(launch: Launch) -> None:
    [node] = launch("sim.launch.py", namespace="/lab/a", record="true")
    [parameters] = node["parameters"]
    assert re.fullmatch(r"lab_a_lie_rigid_body_\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d\.mcap", parameters["record_path"])


@pytest.mark.parametrize("given", [{}, {"world_frame": "map"}])
def test_rviz_looks_into_the_namespace(launch: Launch, given: dict[str, str]) -> None:
    _, view = launch("sim.launch.py", namespace="a", rviz="true", **given)
    assert (view["package"], view["executable"], view["namespace"]) == ("rviz2", "rviz2", "a")
    option, file, *rest = view["arguments"]
    assert option == "--display-config"
    assert rest == (["--fixed-frame", "map"] if given else [])
    shown = set(topics(yaml.safe_load(Path(file).read_text(encoding="utf-8"))))
    assert shown == {"/markers", "/pose"}
    # a relative name is the node's, in its namespace
    assert dict(view["remappings"]) == {topic: topic.removeprefix("/") for topic in shown}


def topics(view: dict[str, Any]) -> list[str]:
    displays = view["Visualization Manager"]["Displays"]
    return [display["Topic"]["Value"] for display in displays if "Topic" in display]


def of(nodes: list[Node], package: str) -> list[Node]:
    return [node for node in nodes if node["package"] == package]


def test_bodies_have_namespaces_scenarios_and_frames_of_their_own(launch: Launch) -> None:
    bodies = of(launch("bodies.launch.py", bodies="a:dzhanibekov, b:symmetric_top,c", record="true"), "lie_rigid_body")
    assert [node["namespace"] for node in bodies] == ["a", "b", "c"]
    assert [node["arguments"] for node in bodies] == [
        ["--scenario", "dzhanibekov"],
        ["--scenario", "symmetric_top"],
        [],
    ]
    parameters = [parameters for node in bodies for parameters in node["parameters"]]
    for name in ("world_frame", "body_frame", "imu_frame", "record_path"):
        assert len({given[name] for given in parameters}) == 3, name
    for given in parameters:
        Scenario.from_parameters(read_parameters(given))


def test_default_bodies_are_scenarios_of_the_package(launch: Launch) -> None:
    bodies = of(launch("bodies.launch.py"), "lie_rigid_body")
    assert len(bodies) > 1
    assert {node["arguments"][1] for node in bodies} <= set(scenario_files())


def test_bodies_stand_side_by_side_in_one_world(launch: Launch) -> None:
    nodes = launch("bodies.launch.py", bodies="a,b,c", spacing="2")
    worlds = [node["parameters"][0]["world_frame"] for node in of(nodes, "lie_rigid_body")]
    places = [words_of(node) for node in of(nodes, "tf2_ros")]
    assert [place["--child-frame-id"] for place in places] == worlds
    assert {place["--frame-id"] for place in places} == {"world"}
    assert [float(place["--x"]) for place in places] == [0.0, 2.0, 4.0]
    assert len({(node["namespace"], node["name"]) for node in of(nodes, "tf2_ros")}) == 3


def words_of(node: Node) -> dict[str, str]:
    words = node["arguments"]
    return dict(zip(words[::2], words[1::2], strict=True))


def test_rviz_shows_every_body(launch: Launch) -> None:
    [view] = of(launch("bodies.launch.py", bodies="a,b", rviz="true"), "rviz2")
    file = Path(view["arguments"][1])
    shown = yaml.safe_load(file.read_text(encoding="utf-8"))
    file.unlink()
    assert sorted(topics(shown)) == ["/a/markers", "/a/pose", "/b/markers", "/b/pose"]
    assert shown["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"


@pytest.mark.parametrize(
    "given",
    [{"bodies": "a:dzhanibekov,a:symmetric_top"}, {"bodies": ":top"}, {"bodies": "a/b:top"}, {"spacing": "wide"}],
)
def test_unusable_input_is_told_in_one_line(launch: Launch, given: dict[str, str]) -> None:
    [(name, text)] = given.items()
    with pytest.raises(ValueError, match=rf"{name}: .* give") as refusal:
        launch("bodies.launch.py", **given)
    assert re.split(",", text)[-1] in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros is not installed: PyPI does not have it")
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_it_loads_with_the_real_libraries(file: Path) -> None:
    description = runpy.run_path(str(file))["generate_launch_description"]()
    assert len(description.entities) == len(ARGUMENTS[file.name]) + 1
