"""Checks of the launch files before they start anything: half of what was asked for is worse than nothing."""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.ros.installation import how_to_install
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import NODE_NAME, gather, parse_assignment
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS
from lie_rigid_body.sensors import frame_parameters

_OF_LAUNCH: Final = ("launch-prefix", "launch-prefix-filter")


def descriptions() -> dict[str, str]:
    """Descriptions of the node's parameters by their names, which are those of launch arguments as well."""
    return {parameter.name: parameter.description for parameter in PARAMETERS}


def description(
    file: str,
    arguments: Mapping[str, tuple[str, str]],
    nodes: Callable[[dict[str, str]], list[Any]],
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
        Gives the nodes for the values of all arguments.
    parameters : collection of str, optional
        Parameters of the simulator that are arguments as well, without a default.

    Returns
    -------
    launch.LaunchDescription
    """
    from launch import LaunchDescription  # type: ignore[attr-defined]  # else it is our folder of that name
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch.substitutions import LaunchConfiguration

    known = {**arguments, **{name: ("", text) for name, text in descriptions().items() if name in parameters}}

    def started(context: Any) -> list[Any]:
        require_known(file, context.argv, known)
        return nodes({name: LaunchConfiguration(name).perform(context) for name in known})

    switch = {"choices": ["true", "false"]}
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text, **(switch if default == "false" else {}))
        for name, (default, text) in known.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=started)])


def simulator(given: Mapping[str, str], name: str = NODE_NAME, namespace: str = "") -> tuple[dict[str, Any], Scenario]:
    """Settings of the simulator for ``launch_ros.actions.Node`` by launch arguments, and its scenario.

    The scenario's name is an argument of its own command line. The rest are parameters, which win over it, and which
    other launch files see and set.

    Raises
    ------
    InputError
        If the simulator would refuse them.
    """
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


def dated_bag(namespace: str, name: str = "") -> str:
    """Name of a bag, after the node and the time."""
    words = [word for word in (*namespace.split("/"), name) if word]
    return f"{'_'.join(words)}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"


def frames() -> dict[str, str]:
    """The usual names of the frames of a node, by the parameters that name them."""
    return {name: str(BY_NAME[name].default) for name in sorted({"world_frame", "body_frame", *frame_parameters()})}


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
            near = difflib.get_close_matches(argument, known, n=1)
            hint = f"did you mean {near[0]}? " if near else ""
            raise InputError(f"{word}: {name} has no argument {argument!r}: {hint}--show-args lists those that it has")


def require_executables(*wanted: tuple[str, str]) -> None:
    """Look for executables where ``ros2 run`` does.

    Parameters
    ----------
    *wanted : tuple of (str, str)
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


def shut_down_if_failed(event: Any, context: object) -> object | None:
    """End everything when a view fails; one that was closed leaves the rest running.

    Parameters
    ----------
    event : launch.events.process.ProcessExited
    context : launch.LaunchContext

    Returns
    -------
    launch.actions.Shutdown or None
    """
    from launch.actions import Shutdown

    return Shutdown(reason=f"{event.process_name} failed") if event.returncode else None


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


def end_with_status(event: Any, context: Any) -> object | None:
    """End everything with the evaluator; its exit status above 0 makes that of launch 1.

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
        why = "a limit is broken" if event.returncode == 1 else "there was nothing to score"
        raise LieRigidBodyError(f"{event.process_name} ended with status {event.returncode}: {why}")
    return None if context.is_shutdown else Shutdown(reason="the evaluation is complete")
