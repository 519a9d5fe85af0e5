"""Checks of the launch files before they start anything: half of what was asked for is worse than nothing."""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.ros.installation import how_to_install
from lie_rigid_body.ros.sim import parse
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS
from lie_rigid_body.sensors import frame_parameters

_OF_LAUNCH: Final = ("launch-prefix", "launch-prefix-filter")


def descriptions() -> dict[str, str]:
    """Descriptions of the node's parameters by their names, which are those of launch arguments as well."""
    return {parameter.name: parameter.description for parameter in PARAMETERS}


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


def arguments_of_node(scenario: str, params_file: str, parameters: Mapping[str, str]) -> list[str]:
    """The arguments of the node's own command line, for what launch arguments give; empty: not given."""
    assignments = (("-p", f"{name}:={value}") for name, value in parameters.items() if value)
    options = (("--scenario", scenario), ("--params-file", params_file), *assignments)
    return [word for option, value in options if value for word in (option, value)]


def scenario_of_node(words: list[str], name: str, namespace: str) -> Scenario:
    """The scenario that a node will find in its arguments.

    Parameters
    ----------
    words : list of str
        As `arguments_of_node` gives them.
    name, namespace : str
        Of the node.

    Raises
    ------
    InputError
        If the node would refuse them.
    """
    given = parse(words)
    parameters = gather(given.scenario, given.params_file, given.assignments, name, f"/{namespace.strip('/')}")
    return Scenario.from_parameters(with_path(parameters))


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
