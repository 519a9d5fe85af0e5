"""Start the node:  ros2 launch lie_rigid_body sim.launch.py scenario:=dzhanibekov namespace:=top rviz:=true.

Only what is given is passed on; later wins: the node's defaults < scenario < params_file < the other arguments.
Several bodies side by side: bodies.launch.py.
"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "lie_rigid_body"
ARGUMENTS = {
    "scenario": "a scenario of the package; 'ros2 run lie_rigid_body scenarios' lists them",
    "params_file": "a ROS 2 parameter file",
    "namespace": "goes before the names of the node, its topics and its services",
    "name": f"the node's name; {PACKAGE} if not given",
    "world_frame": "the inertial frame's name",
    "body_frame": "the body frame's name; two bodies in one /tf need two",
    "imu_frame": "the name of the sensors' frame",
    "record_path": "the node also writes this MCAP file",
}
SWITCHES = {
    "record": "the node also writes an MCAP file, in the present folder, named after the node and the time",
    "rviz": "start RViz as well; it is in the package rviz2",
}
PARAMETERS = ("world_frame", "body_frame", "imu_frame", "record_path")
RVIZ_FILE = Path(__file__).resolve().parents[1] / "config" / "rviz" / "lie_rigid_body.rviz"


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    given = [DeclareLaunchArgument(name, default_value="", description=text) for name, text in ARGUMENTS.items()]
    switches = [
        DeclareLaunchArgument(name, default_value="false", description=text, choices=["true", "false"])
        for name, text in SWITCHES.items()
    ]
    return LaunchDescription([*given, *switches, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes, with what was given."""
    given = {name: LaunchConfiguration(name).perform(context) for name in (*ARGUMENTS, *SWITCHES)}
    given["name"] = given["name"] or PACKAGE
    if given["record"] == "true" and not given["record_path"]:
        given["record_path"] = dated_bag(given["namespace"], given["name"])
    return [simulator(given), *([rviz(given)] if given["rviz"] == "true" else [])]


def simulator(given: dict[str, str]) -> Node:
    """Return the simulator."""
    options = {"scenario": "--scenario", "params_file": "--params-file"}
    parameters = {name: given[name] for name in PARAMETERS if given[name]}
    return Node(
        package=PACKAGE,
        executable="sim",
        name=given["name"],
        namespace=given["namespace"],
        arguments=[word for name, option in options.items() if given[name] for word in (option, given[name])],
        parameters=[parameters] if parameters else [],
        output="screen",
    )


def rviz(given: dict[str, str]) -> Node:
    """Return RViz, looking into the namespace."""
    fixed_frame = ["--fixed-frame", given["world_frame"]] if given["world_frame"] else []
    return Node(
        package="rviz2",
        executable="rviz2",
        namespace=given["namespace"],
        arguments=["--display-config", str(RVIZ_FILE), *fixed_frame],
        remappings=[("/markers", "markers"), ("/pose", "pose")],
    )


def dated_bag(namespace: str, name: str) -> str:
    """Return a bag's name, after the node and the time."""
    words = [word for word in (*namespace.split("/"), name) if word]
    return f"{'_'.join(words)}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"
