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

import re
import tempfile
from copy import deepcopy
from pathlib import Path

import yaml
from launch.actions import Shutdown
from launch_ros.actions import Node

from lie_rigid_body.ros import launching

ARGUMENTS = {
    "bodies": ("a:dzhanibekov,b:symmetric_top", "the bodies: NAME:SCENARIO,...; NAME alone has the node's defaults"),
    "params_file": ("", "a ROS 2 parameter file for all of them; in it, sections tell them apart: /a/lie_rigid_body"),
    "spacing": ("2.5", "from one body to the next along x, m"),
    "record": ("false", "each node also writes an MCAP file, in the present folder, named after its body and the time"),
    "rviz": ("false", "start RViz as well; it is in the package rviz2"),
}
OF_ONE_NODE = {*launching.frames(), "record_path", "publish_clock"}
PLACE = ("tf2_ros", "static_transform_publisher")
RVIZ_FILE = Path(__file__).resolve().parents[1] / "config" / "rviz" / "lie_rigid_body.rviz"


def generate_launch_description():
    """Describe the launch."""
    return launching.description(__file__, ARGUMENTS, nodes, launching.descriptions().keys() - OF_ONE_NODE)


def nodes(given):
    """Return the node of each body, its place in the common world, and RViz. When one ends, so does the rest."""
    bodies = {name: settings(name, scenario, given) for name, scenario in named_scenarios(given["bodies"]).items()}
    spacing = metres("spacing", given["spacing"])
    with_rviz = given["rviz"] == "true"
    launching.require_executables(("lie_rigid_body", "sim"), PLACE, *([("rviz2", "rviz2")] if with_rviz else []))
    found = []
    for number, (name, of_body) in enumerate(bodies.items()):
        place = ["--x", str(number * spacing), "--frame-id", "world", "--child-frame-id", f"{name}/world"]
        of_place = {"package": PLACE[0], "executable": PLACE[1], "name": "place", "namespace": name, "arguments": place}
        ended = Shutdown(reason=f"a part of {name} ended")
        found += [Node(**of_body, output="screen", on_exit=ended), Node(**of_place, on_exit=ended)]
    if with_rviz:
        arguments, on_exit = ["--display-config", view_of(bodies)], launching.shut_down_if_failed
        found.append(Node(package="rviz2", executable="rviz2", arguments=arguments, on_exit=on_exit))
    return found


def named_scenarios(text):
    """Return the scenario of every body, by the body's name."""
    found = {}
    for entry in text.split(","):
        name, _, scenario = entry.strip().partition(":")
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in found:
            raise ValueError(
                f"bodies: {entry!r} in {text!r} does not begin with a name of its own: give NAME:SCENARIO,... with "
                "names of letters, digits and underscores, each once"
            )
        found[name] = scenario
    return found


def metres(name, text):
    """Return a length, m."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name}: {text!r} is not a number: give metres, for example 2.5") from None


def settings(name, scenario, given):
    """Return the settings of the simulator of one body."""
    frames = {parameter: f"{name}/{frame}" for parameter, frame in launching.frames().items()}
    bag = {"record_path": launching.dated_bag(name)} if given["record"] == "true" else {}
    return launching.simulator({**given, **frames, **bag, "scenario": scenario}, namespace=name)[0]


def view_of(names):
    """Return the file of a view in which every body has the displays that the view of one body has."""
    view = yaml.safe_load(RVIZ_FILE.read_text(encoding="utf-8"))
    manager = view["Visualization Manager"]
    displays = []
    for display in manager["Displays"]:
        topic = display.get("Topic", {}).get("Value")
        displays += [of_body(name, display) for name in names] if topic in ("/markers", "/pose") else [display]
    manager["Displays"] = displays
    with tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False, encoding="utf-8") as file:
        yaml.safe_dump(view, file)
    return file.name


def of_body(name, display):
    """Return one body's own copy of a display."""
    own = deepcopy(display)
    own["Name"] = f"{display['Name']} {name}"
    own["Topic"]["Value"] = f"/{name}{display['Topic']['Value']}"
    return own
