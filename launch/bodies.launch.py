"""Start several bodies:  ros2 launch lie_rigid_body bodies.launch.py bodies:=a:dzhanibekov,b:symmetric_top rviz:=true.

Each is a node in a namespace of its own, with frames of its own: two bodies that both called themselves base_link would
quarrel in /tf. The mass centre of each is the origin of its own world, as a/world. The frame `world` is their common
parent, in which they stand side by side, so that one sees them all.
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
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

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
OF_EACH_BODY = ("/markers", "/pose")


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    given = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    switches = [
        DeclareLaunchArgument(name, default_value="false", description=text, choices=["true", "false"])
        for name, text in SWITCHES.items()
    ]
    return LaunchDescription([*given, *switches, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes of all bodies, and of the view."""
    given = {name: LaunchConfiguration(name).perform(context) for name in (*ARGUMENTS, *SWITCHES)}
    bodies = named_scenarios(given["bodies"])
    spacing = metres("spacing", given["spacing"])
    return [
        *(simulator(name, scenario, given) for name, scenario in bodies.items()),
        *(place(name, number * spacing) for number, name in enumerate(bodies)),
        *([rviz(list(bodies))] if given["rviz"] == "true" else []),
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


def simulator(name: str, scenario: str, given: dict[str, str]) -> Node:
    """Return the simulator of one body."""
    params_file = given["params_file"]
    frames = {"world_frame": f"{name}/world", "body_frame": f"{name}/base_link", "imu_frame": f"{name}/imu_link"}
    bag = {"record_path": f"{name}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"} if given["record"] == "true" else {}
    return Node(
        package=PACKAGE,
        executable="sim",
        name=PACKAGE,
        namespace=name,
        arguments=[
            *(["--scenario", scenario] if scenario else []),
            *(["--params-file", params_file] if params_file else []),
        ],
        parameters=[frames | bag],
        output="screen",
    )


def place(name: str, x: float) -> Node:
    """Return what tells where the world of one body is."""
    return Node(
        package="tf2_ros",
        executable="static_transform_publisher",
        name="place",
        namespace=name,
        arguments=["--x", str(x), "--frame-id", "world", "--child-frame-id", f"{name}/world"],
    )


def rviz(names: list[str]) -> Node:
    """Return RViz, looking at all bodies."""
    view = rviz_view(yaml.safe_load(RVIZ_FILE.read_text(encoding="utf-8")), names)
    with tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False, encoding="utf-8") as file:
        yaml.safe_dump(view, file)
    return Node(package="rviz2", executable="rviz2", arguments=["--display-config", file.name])


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
