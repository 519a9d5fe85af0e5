"""The launch files find all that they need before they start anything, and hand on what they are given."""

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
from test_wording_of_ros import phrase

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.report import request
from lie_rigid_body.ros import launching
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import parse_assignment, scenario_files
from lie_rigid_body.scenario.parameter_table import PARAMETERS, read_parameters

LAUNCH = Path(__file__).parents[2] / "launch"
FILES = sorted(LAUNCH.glob("*.launch.py"))
NAMES = {parameter.name for parameter in PARAMETERS}
OF_ONE_NODE = {"world_frame", "body_frame", "imu_frame", "record_path", "publish_clock"}
ARGUMENTS = {
    "sim.launch.py": {"scenario", "params_file", "namespace", "name", "record", "rviz"} | NAMES,
    "bodies.launch.py": {"bodies", "params_file", "spacing", "record", "rviz"} | NAMES - OF_ONE_NODE,
    "estimator.launch.py": {
        *("package", "executable", "parameters", "estimator_params_file", "remappings", "estimate"),
        *("max_rms", "max_after", "duration", "wait", "covariance_axes", "report", "plot"),
        *("scenario", "params_file", "namespace", "lockstep"),
        *NAMES,
    },
}
WITH_VIEWS = ["sim.launch.py", "bodies.launch.py"]
ESTIMATOR = "estimator.launch.py"
EXECUTABLES = {
    "lie_rigid_body": "sim",
    "tf2_ros": "static_transform_publisher",
    "rviz2": "rviz2",
    "imu_filter_madgwick": "imu_filter_madgwick_node",
    "imu_complementary_filter": "complementary_filter_node",
    "mine": "filter",
}
OF_VIEWS = ["lie_rigid_body", "tf2_ros", "rviz2"]

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
        Shutdown=lambda reason: f"end everything: {reason}",
    )
    for name, module in stand_ins.items():
        monkeypatch.setitem(sys.modules, name, module)
    return lambda file: runpy.run_path(str(LAUNCH / file))["generate_launch_description"]()


class Context(dict[str, str]):
    """A launch context: the launch configurations, and the words of the command line."""

    def __init__(self, configurations: dict[str, str], argv: list[str]) -> None:
        super().__init__(configurations)
        self.argv = argv


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """The executables that the launch files may start, installed in two prefixes, by their packages."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'workspace'}:{tmp_path / 'jazzy'}")
    found = {}
    for package, executable in EXECUTABLES.items():
        prefix = "workspace" if package == "lie_rigid_body" else "jazzy"
        path = found[package] = tmp_path / prefix / "lib" / package / executable
        path.parent.mkdir(parents=True)
        path.touch(mode=0o755)
    found["lie_rigid_body"].with_name("evaluate").touch(mode=0o755)
    return found


@pytest.fixture
def launch(described: Callable[[str], Any], installed: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> Launch:
    """The nodes that a launch file starts, with its defaults where an argument is not given."""

    def nodes(file: str, **given: str) -> list[Node]:
        *declared, function = described(file)
        argv = [f"{name}:={value}" for name, value in given.items()]
        monkeypatch.setattr(sys, "argv", ["ros2", "launch", "lie_rigid_body", file, *argv])
        started: list[Node] = function(
            Context({name: settings["default_value"] for name, settings in declared} | given, argv)
        )
        return started

    return nodes


@pytest.mark.parametrize("file", ARGUMENTS)
def test_arguments_are_described_and_switches_have_two_values(file: str, described: Callable[[str], Any]) -> None:
    *declared, _ = described(file)
    assert {name for name, _ in declared} == ARGUMENTS[file]
    assert len(declared) == len(ARGUMENTS[file])
    assert all(settings["description"] for _, settings in declared)
    choices = {name: settings["choices"] for name, settings in declared if "choices" in settings}
    switches = ["lockstep"] if file == ESTIMATOR else ["record", "rviz"]
    assert choices == {name: ["true", "false"] for name in switches}


def test_what_is_given_reaches_the_node_and_nothing_else(launch: Launch, tmp_path: Path) -> None:
    [node] = launch("sim.launch.py")
    assert (node["package"], node["executable"]) == ("lie_rigid_body", "sim")
    assert (node["namespace"], node["name"], node["arguments"]) == ("", "lie_rigid_body", [])
    file = tmp_path / "p.yaml"
    file.write_text("/a/top: {ros__parameters: {rate: 20.0}}")
    given = {"scenario": "dzhanibekov", "params_file": str(file), "namespace": "a", "name": "top"}
    parameters = {"rate": "200.0", "inertia": "[1.0, 2.0, 3.0]", "record_path": "a.mcap", "body_frame": "a/base_link"}
    [node] = launch("sim.launch.py", record="true", **given, **parameters)
    assert (node["namespace"], node["name"]) == ("a", "top")
    own, assigned = node["arguments"][:4], node["arguments"][4:]
    assert own == ["--scenario", "dzhanibekov", "--params-file", str(file)]
    assert set(assigned[::2]) == {"-p"}
    assert set(assigned[1::2]) == {f"{name}:={value}" for name, value in parameters.items()}


def test_a_bag_is_named_after_node_and_time(launch: Launch) -> None:
    [node] = launch("sim.launch.py", namespace="/lab/a", record="true")
    [_, assignment] = node["arguments"]
    bag = r"lab_a_lie_rigid_body_\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d\.mcap"
    assert re.fullmatch(f"record_path:={bag}", assignment)


@pytest.mark.parametrize("given", [{}, {"world_frame": "map"}])
def test_rviz_looks_into_the_namespace(launch: Launch, given: dict[str, str]) -> None:
    _, view = launch("sim.launch.py", namespace="a", rviz="true", **given)
    assert (view["package"], view["executable"], view["namespace"]) == ("rviz2", "rviz2", "a")
    option, file, *rest = view["arguments"]
    assert option == "--display-config"
    assert rest == ["--fixed-frame", given.get("world_frame", "world")]
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
    assert [words_of(node).get("--scenario") for node in bodies] == ["dzhanibekov", "symmetric_top", None]
    parameters = [dict(map(parse_assignment, node["arguments"][1::2][-4:])) for node in bodies]
    for name in ("world_frame", "body_frame", "imu_frame", "record_path"):
        assert len({given[name] for given in parameters}) == 3, name
    for given in parameters:
        Scenario.from_parameters(read_parameters(given))


def test_parameters_are_for_every_body(launch: Launch) -> None:
    for node in of(launch("bodies.launch.py", bodies="a,b", rate="200.0"), "lie_rigid_body"):
        assert "rate:=200.0" in node["arguments"]


def test_default_bodies_are_scenarios_of_the_package(launch: Launch) -> None:
    bodies = of(launch("bodies.launch.py"), "lie_rigid_body")
    assert len(bodies) > 1
    assert {node["arguments"][1] for node in bodies} <= set(scenario_files())


def test_bodies_stand_side_by_side_in_one_world(launch: Launch) -> None:
    nodes = launch("bodies.launch.py", bodies="a,b,c", spacing="2")
    worlds = [f"{node['namespace']}/world" for node in of(nodes, "lie_rigid_body")]
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
    ("file", "given", "said"),
    [
        (
            "bodies.launch.py",
            {"bodies": "a:dzhanibekov,a:symmetric_top"},
            f"bodies: 'a:symmetric_top' .* {phrase('no body')}",
        ),
        ("bodies.launch.py", {"bodies": ":top"}, f"bodies: ':top' .* {phrase('no body')}"),
        ("bodies.launch.py", {"bodies": "a/b:top"}, f"bodies: 'a/b:top' .* {phrase('no body')}"),
        ("bodies.launch.py", {"bodies": "a:dzanibekov"}, "'dzanibekov'"),
        ("bodies.launch.py", {"spacing": "wide"}, f"spacing: 'wide' {phrase('no metres')}"),
        ("bodies.launch.py", {"params_file": "/nowhere.yaml"}, "/nowhere.yaml "),
        (
            "bodies.launch.py",
            {"record_path": "a.mcap"},
            phrase("no argument", file="bodies.launch.py", name="record_path"),
        ),
        ("sim.launch.py", {"scenario": "dzanibekov"}, "'dzanibekov'"),
        ("sim.launch.py", {"rate": "-1.0"}, "^rate: "),
        ("sim.launch.py", {"rte": "1.0"}, "rte:=1.0: "),
        (ESTIMATOR, {"package": "mine"}, phrase("no executable", package="mine")),
        (ESTIMATOR, {"max_rms": "1"}, "'1'"),
        (ESTIMATOR, {"covariance_axes": "map"}, "'map'"),
        (ESTIMATOR, {"max_after": "10s"}, "'10s'"),
        (ESTIMATOR, {"parameters": "gain=1"}, "gain=1"),
        (ESTIMATOR, {"remappings": "imu=data"}, f"remappings: 'imu=data' {phrase('no remapping')}"),
        (ESTIMATOR, {"imu_rate": "-1.0"}, "^imu_rate: "),
        (ESTIMATOR, {"rviz": "true"}, phrase("no argument", file=ESTIMATOR, name="rviz")),
    ],
)
def test_unusable_input_is_told_in_one_line(launch: Launch, file: str, given: dict[str, str], said: str) -> None:
    with pytest.raises(ValueError, match=said) as refusal:
        launch(file, **given)
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize("file", WITH_VIEWS)
@pytest.mark.parametrize("package", OF_VIEWS)
def test_nothing_is_started_before_everything_is_found(
    launch: Launch, installed: dict[str, Path], file: str, package: str
) -> None:
    if file == "sim.launch.py" and package == "tf2_ros":
        assert launch(file, rviz="true")  # which it does not need
        return
    installed[package].chmod(0o644)
    with pytest.raises(InputError):
        launch(file, rviz="true")
    if package == "rviz2":
        assert launch(file)


def test_arguments_of_a_launch_file_that_includes_this_one_are_its_own(
    launch: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "robot", "robot.launch.py", "colour:=red"])
    launching.require_known("/launch/sim.launch.py", ["colour:=red"], ["scenario"])
    assert launch("sim.launch.py", **{"launch-prefix": "nice"})  # an option of ros2 launch itself


@pytest.mark.parametrize("package", ["lie_rigid_body", "mine"])
def test_no_evaluation_is_started_before_everything_is_found(
    launch: Launch, installed: dict[str, Path], package: str
) -> None:
    installed[package].chmod(0o644)
    with pytest.raises(InputError):
        launch(ESTIMATOR, package="mine", executable="filter")


@pytest.mark.parametrize("file", WITH_VIEWS)
def test_when_one_part_ends_nothing_is_left_running(launch: Launch, file: str) -> None:
    nodes = launch(file, rviz="true")
    ended = SimpleNamespace(process_name="rviz2-3", returncode=0)
    failed = SimpleNamespace(process_name="rviz2-3", returncode=-6)
    for node in nodes:
        if node["package"] != "rviz2":
            assert node["on_exit"].startswith("end everything")
            continue
        assert node["on_exit"](ended, None) is None
        assert node["on_exit"](failed, None).startswith("end everything: ")


def test_filters_that_are_known_read_both_sensors_and_are_evaluated(launch: Launch) -> None:
    for package, parameters in (
        ("imu_filter_madgwick", {"world_frame": "enu", "use_mag": True, "publish_tf": False}),
        ("imu_complementary_filter", {"use_mag": True, "publish_tf": False}),
    ):
        sim, estimator, evaluator = launch(ESTIMATOR, package=package)
        assert [node["executable"] for node in (sim, estimator, evaluator)] == ["sim", EXECUTABLES[package], "evaluate"]
        assert (estimator["package"], estimator["parameters"], estimator["remappings"]) == (package, [parameters], [])
        assert evaluator["remappings"] == [("estimate", "imu/data")]
        scenario = launching.scenario_of_node(sim["arguments"], "lie_rigid_body", "")
        assert scenario.sensors.imu is not None
        assert scenario.sensors.magnetometer is not None
        given = scenario.parameters()
        assert (given["accelerometer_mode"], given["gyro_rate"]) == ("pivot_gravity", "integrated")


def test_any_filter_gets_its_parameters_topics_and_limits(launch: Launch, tmp_path: Path) -> None:
    file = tmp_path / "sensors.yaml"
    file.write_text("/**: {ros__parameters: {imu_rate: 20.0, accelerometer_mode: free_fall}}")
    own = {"package": "mine", "executable": "filter", "parameters": "gain:=0.5 field:='[1.0, 2.0]'"}
    topics = {"remappings": "imu:=imu/data_raw", "estimate": "/mine/pose", "namespace": "a"}
    limits = {
        "max_rms": "1deg",
        "max_after": "1s:3deg 10s:2deg",
        "duration": "60",
        "report": "a.html",
        "covariance_axes": "body",
    }
    sim, estimator, evaluator = launch(ESTIMATOR, params_file=str(file), **own, **topics, **limits)
    assert estimator["parameters"] == [{"gain": 0.5, "field": [1.0, 2.0]}]
    assert estimator["remappings"][0] == ("imu", "imu/data_raw")
    assert ("/imu/mag", "imu/mag") in estimator["remappings"]  # some filters ask for the names without namespace
    assert {node["namespace"] for node in (sim, estimator, evaluator)} == {"a"}
    assert sim["arguments"] == ["--scenario", "tumbling_cubesat", "--params-file", str(file)]  # it has an IMU
    assert evaluator["remappings"] == [("estimate", "/mine/pose")]
    asked = request.parse(evaluator["arguments"])
    assert (asked.max_rms, asked.max_after, asked.duration, asked.report, asked.covariance_axes) == (
        "1deg",
        ["1s:3deg", "10s:2deg"],
        60.0,
        "a.html",
        "body",
    )


def test_in_lock_step_the_simulator_waits_for_the_filter_and_the_evaluator(launch: Launch) -> None:
    def parameters_of(**given: str) -> dict[str, object]:
        sim, *_ = launch(ESTIMATOR, **given)
        return dict(map(parse_assignment, words_after(sim, "-p")))

    assert not [name for name in parameters_of() if name.startswith("lockstep")]
    found = parameters_of(lockstep="true", estimate="attitude", namespace="a", real_time_factor="0.0")
    assert found["lockstep_topic"] == "attitude"  # relative names, which the namespace is put before
    assert read_parameters(found)["lockstep_nodes"] == ("evaluator",)
    assert found["real_time_factor"] == 0.0
    found = parameters_of(lockstep="true", lockstep_nodes="[/recorder]", lockstep_timeout="2.0")
    assert read_parameters(found)["lockstep_nodes"] == ("/recorder",)
    assert found["lockstep_timeout"] == 2.0


def words_after(node: Node, option: str) -> list[str]:
    words = node["arguments"]
    return [word for before, word in zip(words[::2], words[1::2], strict=True) if before == option]


def test_the_end_of_the_evaluator_is_that_of_the_launch(launch: Launch) -> None:
    sim, estimator, evaluator = launch(ESTIMATOR)
    running, ending = SimpleNamespace(is_shutdown=False), SimpleNamespace(is_shutdown=True)

    def ended(status: int) -> SimpleNamespace:
        return SimpleNamespace(process_name="it-3", returncode=status)

    assert evaluator["on_exit"](ended(0), running).startswith("end everything: ")
    assert evaluator["on_exit"](ended(0), ending) is None
    # launch ends everything after an exception, with status 1
    for context in (running, ending):
        with pytest.raises(LieRigidBodyError):
            evaluator["on_exit"](ended(1), context)
        with pytest.raises(LieRigidBodyError):
            evaluator["on_exit"](ended(2), context)
    for node in (sim, estimator):
        assert node["on_exit"](ended(0), ending) is None
        with pytest.raises(LieRigidBodyError):
            node["on_exit"](ended(-6), running)


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros is not installed: PyPI does not have it")
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_it_loads_with_the_real_libraries(file: Path) -> None:
    description = runpy.run_path(str(file))["generate_launch_description"]()
    assert len(description.entities) == len(ARGUMENTS[file.name]) + 1
