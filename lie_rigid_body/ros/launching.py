"""Launch files: their arguments, the settings of the nodes that they start, and checks before anything is started."""

from __future__ import annotations

import os
import shlex
import sys
import tempfile
from collections.abc import Callable, Collection, Iterable, Mapping
from datetime import datetime
from itertools import product
from pathlib import Path
from typing import Any, Final, TypeAlias

import yaml

from lie_rigid_body.evaluation import Limits
from lie_rigid_body.evaluation.consistency import require_axes
from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.parameters import Given
from lie_rigid_body.foundation.wording import suggestion
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.report import score_options
from lie_rigid_body.ros.installation import how_to_install
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import CONFIG, NODE_NAME, gather, parse_assignment
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS
from lie_rigid_body.sensors import frame_parameters

RVIZ_FILE: Final = CONFIG / "rviz" / "lie_rigid_body.rviz"
Texts: TypeAlias = Mapping[str, str]
"""Values of launch arguments, by their names."""
Settings: TypeAlias = dict[str, Any]
"""Settings of ``launch_ros.actions.Node``, by the names of its parameters."""
_OF_LAUNCH: Final = ("launch-prefix", "launch-prefix-filter")
_BENCH: Final = {
    "imu_rate": "100.0",
    "magnetometer_rate": "100.0",
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
}
"""Sensors of a simulator for a filter, where its scenario, its file and its arguments give no IMU."""
_RELATIVE: Final = [(f"/imu/{name}", f"imu/{name}") for name in ("data_raw", "mag", "data")]
"""Names that some filters have without a namespace, and what they have to be in one."""


def descriptions() -> dict[str, str]:
    """Descriptions of the node's parameters by their names, which are those of launch arguments as well."""
    return {parameter.name: parameter.description for parameter in PARAMETERS}


def description(
    file: str,
    arguments: Mapping[str, tuple[str, str]],
    nodes: Callable[[dict[str, str]], list[Settings]],
    parameters: Collection[str] = BY_NAME,
) -> Any:
    """The launch of some nodes, once all that they need is found.

    Parameters
    ----------
    file : str
        Path of the launch file.
    arguments : mapping of str to (str, str)
        Default and description of its arguments; one that is ``false`` is a switch.
    nodes : callable
        Gives the settings of ``launch_ros.actions.Node`` of each node for the values of all arguments. The launch ends
        with a node, whose exit status is its own, unless ``on_exit`` is among them.
    parameters : collection of str, optional
        Parameters of the simulator that are arguments as well, without a default.

    Returns
    -------
    launch.LaunchDescription
    """
    from launch import LaunchDescription  # type: ignore[attr-defined]  # else it is our folder of that name
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node

    known = {**arguments, **{name: ("", text) for name, text in descriptions().items() if name in parameters}}

    def started(context: Any) -> list[Any]:
        require_known(file, context.argv, known)
        settings = nodes({name: LaunchConfiguration(name).perform(context) for name in known})
        require_executables((each["package"], each["executable"]) for each in settings)
        return [Node(**{"output": "screen", "on_exit": end_with_status, **each}) for each in settings]

    switch = {"choices": ["true", "false"]}
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text, **(switch if default == "false" else {}))
        for name, (default, text) in known.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=started)])


def simulator(given: Texts) -> tuple[Settings, Scenario]:
    """Settings of the simulator by launch arguments, and its scenario.

    The scenario's name is an argument of its own command line. The rest are parameters, which win over it, and which
    other launch files see and set.

    Raises
    ------
    InputError
        If the simulator would refuse them.
    """
    name = given.get("name", NODE_NAME)
    namespace = given["namespace"]
    if given.get("record") == "true" and not given.get("record_path"):
        names = "_".join(filter(None, (*namespace.split("/"), name)))
        given = {**given, "record_path": f"{names}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"}
    own = {
        each: BY_NAME[each].read(parse_assignment(f"{each}:={given[each]}")[1]) for each in BY_NAME if given.get(each)
    }
    files = [given["params_file"]] if given["params_file"] else []
    values = gather(given["scenario"] or None, files, (), name, f"/{namespace.strip('/')}")
    scenario = Scenario.from_parameters(with_path({**values, **own}))
    plain = {each: list(value) if isinstance(value, tuple) else value for each, value in own.items()}
    words = ["--scenario", given["scenario"]] if given["scenario"] else []
    for each in [each for each, value in plain.items() if value == []]:  # for which launch_ros has no type
        words += ["-p", f"{each}:=[]"]
        del plain[each]
    settings = {"package": NODE_NAME, "executable": "sim", "name": name, "namespace": namespace}
    return {**settings, "arguments": words, "parameters": [*files, *([plain] if plain else [])]}, scenario


def frames() -> dict[str, str]:
    """The usual names of the frames of a node, by the parameters that name them."""
    return {name: str(BY_NAME[name].default) for name in {"world_frame", "body_frame", *frame_parameters()}}


def rviz(view: str | Path, *words: str, **settings: Any) -> Settings:
    """Settings of RViz, by the file of its view, words of its command line, and settings beside."""
    program = {"package": "rviz2", "executable": "rviz2", "arguments": ["--display-config", str(view), *words]}
    return {**program, "on_exit": fail_if_failed, **settings}


def view_of(namespaces: Collection[str]) -> str:
    """File of an RViz view in which the displays of topics of `RVIZ_FILE` are there for each namespace."""
    view = yaml.safe_load(RVIZ_FILE.read_text(encoding="utf-8"))
    manager = view["Visualization Manager"]
    of_topics = [display for display in manager["Displays"] if "Topic" in display]
    manager["Displays"] = [display for display in manager["Displays"] if "Topic" not in display]
    for namespace, display in product(namespaces, of_topics):
        topic = {**display["Topic"], "Value": f"/{namespace}{display['Topic']['Value']}"}
        manager["Displays"].append({**display, "Name": f"{display['Name']} {namespace}", "Topic": topic})
    with tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False, encoding="utf-8") as file:
        yaml.safe_dump(view, file)
    return file.name


def bench(given: Texts) -> Settings:
    """Settings of the simulator for a filter, with sensors where none are given; each part of a test is needed."""
    if given["lockstep"] == "true":
        given = _with_usual(given, {"lockstep_topic": given["estimate"], "lockstep_nodes": "[evaluator]"})
    settings, scenario = simulator(given)
    if scenario.sensors.imu is None:
        settings, _ = simulator(_with_usual(given, _BENCH))
    return {**settings, "on_exit": fail_unless_shut_down}


def _with_usual(given: Texts, usual: Texts) -> dict[str, str]:
    return {**given, **{name: given[name] or value for name, value in usual.items()}}


def estimator(given: Texts, executable: str, usual: Given) -> Settings:
    """Settings of a filter, with parameters that are given unless others are."""
    own = dict(parse_assignment(word) for word in shlex.split(given["parameters"]))
    return {
        "package": given["package"],
        "executable": executable,
        "namespace": given["namespace"],
        "parameters": [part for part in (usual, given["estimator_params_file"], own) if part],
        "remappings": [*(tuple(word.split(":=")) for word in given["remappings"].split()), *_RELATIVE],
        "on_exit": fail_unless_shut_down,
    }


def options(names: Collection[str]) -> dict[str, tuple[str, str]]:
    """Launch arguments of some options of the evaluator, with underscores in their names."""
    rows = {words[-1].lstrip("-").replace("-", "_"): how for words, how in score_options.ARGUMENTS}
    return {name: ("", rows[name]["help"] % rows[name]) for name in names}


def evaluator(given: Texts, options: Iterable[str]) -> Settings:
    """Settings of the evaluator, by those of its options that are given; several values have spaces between them."""
    Limits.parse(given["max_rms"] or None, tuple(given["max_after"].split()))
    require_axes(given["covariance_axes"] or "world")
    words = [f"--{name.replace('_', '-')}={value}" for name in options for value in shlex.split(given[name])]
    settings = {"package": NODE_NAME, "executable": "evaluate", "name": "evaluator", "namespace": given["namespace"]}
    return {**settings, "arguments": words, "remappings": [("estimate", given["estimate"])]}


def require_known(file: str, argv: Iterable[str], known: Collection[str]) -> None:
    """Refuse launch arguments that a launch file does not have, as launch itself passes over them in silence.

    Parameters
    ----------
    file : str
        Path of the launch file.
    argv : iterable of str
        The launch arguments of the command line, ``name:=value`` each. Where that names another launch file, which
        includes this one, they are none of its business.
    known : collection of str

    Raises
    ------
    InputError
    """
    name = Path(file).name
    if all(Path(word).name != name for word in sys.argv):
        return
    for word in argv:
        argument = word.partition(":=")[0]
        if argument not in (*known, *_OF_LAUNCH):
            raise InputError(f"{word}: {name} has no argument {argument!r}: {suggestion(argument, known, 'arguments')}")


def require_executables(wanted: Iterable[tuple[str, str]]) -> None:
    """Look for executables where ``ros2 run`` does.

    Parameters
    ----------
    wanted : iterable of (str, str)
        Package and executable.

    Raises
    ------
    InputError
        Naming the first that is not there.
    """
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    for package, executable in wanted:
        if not any(os.access(Path(prefix, "lib", package, executable), os.X_OK) for prefix in prefixes):
            raise InputError(
                f"{executable} of the package {package} is not there: nothing was started; source its workspace, or "
                f"{how_to_install(package)}"
            )


def fail_unless_shut_down(event: Any, context: Any) -> None:
    """Fail when a part ends by itself: launch ends the rest, and its exit status is 1.

    Parameters
    ----------
    event : launch.events.process.ProcessExited
    context : launch.LaunchContext

    Raises
    ------
    LieRigidBodyError
    """
    if not context.is_shutdown:
        raise LieRigidBodyError(f"{event.process_name} ended with status {event.returncode}: the rest is ended as well")


def fail_if_failed(event: Any, context: Any) -> None:
    """`fail_unless_shut_down` of a view, which the user may close: the rest goes on."""
    if event.returncode:
        fail_unless_shut_down(event, context)


def end_with_status(event: Any, context: Any) -> object | None:
    """End everything with a part whose exit status, if above 0, makes that of launch 1, also after Ctrl-C.

    Parameters
    ----------
    event : launch.events.process.ProcessExited
    context : launch.LaunchContext

    Returns
    -------
    launch.actions.Shutdown or None

    Raises
    ------
    LieRigidBodyError
    """
    from launch.actions import Shutdown

    if event.returncode:
        raise LieRigidBodyError(f"{event.process_name} ended with status {event.returncode}")
    return None if context.is_shutdown else Shutdown()
