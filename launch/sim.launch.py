"""Start the node:  ros2 launch lie_rigid_body sim.launch.py scenario:=dzhanibekov namespace:=top record_path:=top.mcap.

Only what is given is passed on; later wins: the node's defaults < scenario < params_file < record_path.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "lie_rigid_body"
ARGUMENTS = {
    "scenario": "a scenario of the package; 'ros2 run lie_rigid_body scenarios' lists them",
    "params_file": "a ROS 2 parameter file",
    "namespace": "goes before the names of the node, its topics and its services",
    "record_path": "the node also writes this MCAP file",
}


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    declared = [DeclareLaunchArgument(name, default_value="", description=text) for name, text in ARGUMENTS.items()]
    return LaunchDescription([*declared, OpaqueFunction(function=simulator)])


def simulator(context: LaunchContext) -> list[Node]:
    """Return the node, with what was given."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    options = {"scenario": "--scenario", "params_file": "--params-file"}
    arguments = [word for name, option in options.items() if given[name] for word in (option, given[name])]
    parameters = [{"record_path": given["record_path"]}] if given["record_path"] else []
    node = Node(
        package=PACKAGE,
        executable="sim",
        name=PACKAGE,
        namespace=given["namespace"],
        arguments=arguments,
        parameters=parameters,
        output="screen",
    )
    return [node]
