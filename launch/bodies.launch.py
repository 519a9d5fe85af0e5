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
parent, in which they stand side by side. Parameters of the node are arguments, for all bodies: rate:=200.0.
"""

from lie_rigid_body.ros import launching

ARGUMENTS = {
    "bodies": ("a:dzhanibekov,b:symmetric_top", "the bodies: NAME:SCENARIO,...; NAME alone has the node's defaults"),
    "params_file": ("", "a ROS 2 parameter file for all of them; in it, sections tell them apart: /a/lie_rigid_body"),
    "spacing": ("2.5", "from one body to the next along x, m"),
    "record": ("false", "each node also writes an MCAP file, in the present folder, named after its body and the time"),
    "rviz": ("false", "start RViz as well; it is in the package rviz2"),
}
OF_ONE_NODE = {*launching.frames(), "record_path", "publish_clock"}


def generate_launch_description():
    """Describe the launch."""
    return launching.description(__file__, ARGUMENTS, nodes, launching.descriptions().keys() - OF_ONE_NODE)


def nodes(given):
    """Return the node of each body, its place in the common world, and RViz. When one ends, so does the rest."""
    bodies = dict(entry.strip().partition(":")[::2] for entry in given["bodies"].split(","))
    if len(bodies) <= given["bodies"].count(",") or not all(name.isidentifier() for name in bodies):
        raise ValueError(f"bodies: {given['bodies']!r}: give NAME:SCENARIO,... with names like variables, each once")
    spacing = metres("spacing", given["spacing"])
    found = [launching.rviz(launching.view_of(bodies))] if given["rviz"] == "true" else []
    for number, (name, scenario) in enumerate(bodies.items()):
        frames = {parameter: f"{name}/{frame}" for parameter, frame in launching.frames().items()}
        simulator, _ = launching.simulator({**given, **frames, "scenario": scenario, "namespace": name})
        place = ["--x", str(number * spacing), "--frame-id", "world", "--child-frame-id", f"{name}/world"]
        program = {"package": "tf2_ros", "executable": "static_transform_publisher", "namespace": name}
        found += [simulator, {**program, "name": "place", "arguments": place}]
    return found


def metres(name, text):
    """Return a length, m."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name}: {text!r} is not a number: give metres, for example 2.5") from None
