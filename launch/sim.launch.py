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

"""Start the node:  ros2 launch lie_rigid_body sim.launch.py scenario:=dzhanibekov namespace:=top rviz:=true.

Every parameter of the node is an argument, as in rate:=200.0. Only what is given is passed on; later wins: the node's
defaults < scenario < params_file < parameters. Several bodies side by side: bodies.launch.py.
"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from lie_rigid_body.ros import launching

PACKAGE = "lie_rigid_body"
ARGUMENTS = {
    "scenario": "a scenario of the package; 'ros2 run lie_rigid_body scenarios' lists them",
    "params_file": "a ROS 2 parameter file",
    "namespace": "goes before the names of the node, its topics and its services",
    "name": f"the node's name; {PACKAGE} if not given",
}
SWITCHES = {
    "record": "the node also writes an MCAP file, in the present folder, named after the node and the time",
    "rviz": "start RViz as well; it is in the package rviz2",
}
RVIZ_FILE = Path(__file__).resolve().parents[1] / "config" / "rviz" / "lie_rigid_body.rviz"


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    given = [
        DeclareLaunchArgument(name, default_value="", description=text)
        for name, text in {**ARGUMENTS, **launching.descriptions()}.items()
    ]
    switches = [
        DeclareLaunchArgument(name, default_value="false", description=text, choices=["true", "false"])
        for name, text in SWITCHES.items()
    ]
    return LaunchDescription([*given, *switches, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes, with what was given, once all that they need is found."""
    known = (*ARGUMENTS, *SWITCHES, *launching.descriptions())
    launching.require_known(__file__, context.argv, known)
    given = {name: LaunchConfiguration(name).perform(context) for name in known}
    given["name"] = given["name"] or PACKAGE
    if given["record"] == "true" and not given["record_path"]:
        given["record_path"] = dated_bag(given["namespace"], given["name"])
    parameters = {name: given[name] for name in launching.descriptions()}
    words = launching.arguments_of_node(given["scenario"], given["params_file"], parameters)
    world_frame = launching.scenario_of_node(words, given["name"], given["namespace"]).world_frame
    with_rviz = given["rviz"] == "true"
    launching.require_executables((PACKAGE, "sim"), *([("rviz2", "rviz2")] if with_rviz else []))
    return [simulator(given, words), *([rviz(given["namespace"], world_frame)] if with_rviz else [])]


def simulator(given: dict[str, str], words: list[str]) -> Node:
    """Return the simulator. When it ends, so does the rest."""
    return Node(
        package=PACKAGE,
        executable="sim",
        name=given["name"],
        namespace=given["namespace"],
        arguments=words,
        output="screen",
        on_exit=Shutdown(reason="the simulator ended"),
    )


def rviz(namespace: str, world_frame: str) -> Node:
    """Return RViz, looking into the namespace."""
    return Node(
        package="rviz2",
        executable="rviz2",
        namespace=namespace,
        arguments=["--display-config", str(RVIZ_FILE), "--fixed-frame", world_frame],
        remappings=[("/markers", "markers"), ("/pose", "pose")],
        on_exit=launching.shut_down_if_failed,
    )


def dated_bag(namespace: str, name: str) -> str:
    """Return a bag's name, after the node and the time."""
    words = [word for word in (*namespace.split("/"), name) if word]
    return f"{'_'.join(words)}_{datetime.now():%Y-%m-%d_%H-%M-%S}.mcap"
