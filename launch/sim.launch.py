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

from lie_rigid_body.ros import launching

ARGUMENTS = {
    "scenario": ("", "a scenario of the package; 'ros2 run lie_rigid_body scenarios' lists them"),
    "params_file": ("", "a ROS 2 parameter file"),
    "namespace": ("", "goes before the names of the node, its topics and its services"),
    "name": ("lie_rigid_body", "the node's name"),
    "record": ("false", "the node also writes an MCAP file, in the present folder, named after the node and the time"),
    "rviz": ("false", "start RViz as well; it is in the package rviz2"),
}


def generate_launch_description():
    """Describe the launch."""
    return launching.description(__file__, ARGUMENTS, nodes)


def nodes(given):
    """Return the node, and RViz, which looks into its namespace. When the node ends, so does the rest."""
    simulator, scenario = launching.simulator(given)
    if given["rviz"] == "false":
        return [simulator]
    own = {"namespace": given["namespace"], "remappings": [("/markers", "markers"), ("/pose", "pose")]}
    return [simulator, launching.rviz(launching.RVIZ_FILE, "--fixed-frame", scenario.world_frame, **own)]
