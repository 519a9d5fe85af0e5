# Copyright 2026 Seed 2b615e39 maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Start several bodies:  ros2 launch lie_rigid_body bodies.launch.py bodies:=a:dzhanibekov,b:symmetric_top rviz:=true.

Each is a node in a namespace of its own, with frames of its own: two bodies that both called themselves base_link would
quarrel in /tf. The mass centre of each is the origin of its own world, as a/world. The frame `world` is their common
parent, in which they stand side by side, so that one sees them all. Parameters of the node are arguments, for all
bodies: rate:=200.0.
"""

from __future__ import annotations

import re
import tempfile
from copy import deepcopy
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from lie_rigid_body.ros import launching

PACKAGE = "lie_rigid_body"
ARGUMENTS = {
    "bodies": ("a:dzhanibekov,b:symmetric_top", "the bodies: NAME:SCENARIO,...; NAME alone has the node's defaults"),
    "params_file": ("", "a ROS 2 parameter file for all of them; in it, sections tell them apart: /a/lie_rigid_body"),
    "spacing": ("2.5", "from one body to the next along x, m"),
}
SWITCHES = {
    "record": "each node also writes an MCAP file, in the present folder, named after its body and the time",
    "rviz": "start RViz as well; it is in the package rviz2",
}
RVIZ_FILE = Path(__file__).resolve().parents[1] / "config" / "rviz" / "lie_rigid_body.rviz"
TRANSFORM = ("tf2_ros", "static_transform_publisher")
OF_EACH_BODY = ("/markers", "/pose")
OF_ONE_NODE = {*launching.frames(), "record_path", "publish_clock"}
PARAMETERS = {name: text for name, text in launching.descriptions().items() if name not in OF_ONE_NODE}


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    texts = {**ARGUMENTS, **{name: ("", text) for name, text in PARAMETERS.items()}}
    given = [
        DeclareLaunchArgument(name, default_value=default, description=text) for name, (default, text) in texts.items()
    ]
    switches = [
        DeclareLaunchArgument(name, default_value="false", description=text, choices=["true", "false"])
        for name, text in SWITCHES.items()
    ]
    return LaunchDescription([*given, *switches, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes of all bodies, and of the view, once all that they need is found."""
    known = (*ARGUMENTS, *SWITCHES, *PARAMETERS)
    launching.require_known(__file__, context.argv, known)
    given = {name: LaunchConfiguration(name).perform(context) for name in known}
    bodies = {name: words(name, scenario, given) for name, scenario in named_scenarios(given["bodies"]).items()}
    for name, arguments in bodies.items():
        launching.scenario_of_node(arguments, PACKAGE, name)  # or its refusal
    spacing = metres("spacing", given["spacing"])
    with_rviz = given["rviz"] == "true"
    launching.require_executables((PACKAGE, "sim"), TRANSFORM, *([("rviz2", "rviz2")] if with_rviz else []))
    return [
        *(simulator(name, arguments) for name, arguments in bodies.items()),
        *(place(name, number * spacing) for number, name in enumerate(bodies)),
        *([rviz(list(bodies))] if with_rviz else []),
    ]


def named_scenarios(text: str) -> dict[str, str]:
    """Return the scenario of every body, by the body's name."""
    found: dict[str, str] = {}
    for entry in text.split(","):
        name, _, scenario = entry.strip().partition(":")
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in found:
            raise ValueError(
                f"bodies: {entry!r} in {text!r} does not begin with a name of its own: give NAME:SCENARIO,... with "
                "names of letters, digits and underscores, each once"
            )
        found[name] = scenario
    return found


def metres(name: str, text: str) -> float:
    """Return a length, m."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name}: {text!r} is not a number: give metres, for example 2.5") from None


def words(name: str, scenario: str, given: dict[str, str]) -> list[str]:
    """Return the arguments of the simulator of one body."""
    parameters = {parameter: given[parameter] for parameter in PARAMETERS}
    parameters |= {parameter: f"{name}/{frame}" for parameter, frame in launching.frames().items()}
    if given["record"] == "true":
        parameters["record_path"] = f"{name}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"
    return launching.arguments_of_node(scenario, given["params_file"], parameters)


def simulator(name: str, arguments: list[str]) -> Node:
    """Return the simulator of one body. When it ends, so does the rest."""
    return Node(
        package=PACKAGE,
        executable="sim",
        name=PACKAGE,
        namespace=name,
        arguments=arguments,
        output="screen",
        on_exit=Shutdown(reason=f"the simulator of {name} ended"),
    )


def place(name: str, x: float) -> Node:
    """Return what tells where the world of one body is."""
    return Node(
        package=TRANSFORM[0],
        executable=TRANSFORM[1],
        name="place",
        namespace=name,
        arguments=["--x", str(x), "--frame-id", "world", "--child-frame-id", f"{name}/world"],
        on_exit=Shutdown(reason=f"the place of {name} is no longer published"),
    )


def rviz(names: list[str]) -> Node:
    """Return RViz, looking at all bodies."""
    view = rviz_view(yaml.safe_load(RVIZ_FILE.read_text(encoding="utf-8")), names)
    with tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False, encoding="utf-8") as file:
        yaml.safe_dump(view, file)
    arguments = ["--display-config", file.name]
    return Node(package="rviz2", executable="rviz2", arguments=arguments, on_exit=launching.shut_down_if_failed)


def rviz_view(view: dict[str, Any], names: list[str]) -> dict[str, Any]:
    """Return a view in which every body has the displays that the view of one body has."""
    manager = view["Visualization Manager"]
    displays = []
    for display in manager["Displays"]:
        if display.get("Topic", {}).get("Value") in OF_EACH_BODY:
            displays += [display_of(name, display) for name in names]
        else:
            displays.append(display)
    manager["Displays"] = displays
    return view


def display_of(name: str, display: dict[str, Any]) -> dict[str, Any]:
    """Return one body's own copy of a display."""
    own = deepcopy(display)
    own["Name"] = f"{display['Name']} {name}"
    own["Topic"]["Value"] = f"/{name}{display['Topic']['Value']}"
    return own
