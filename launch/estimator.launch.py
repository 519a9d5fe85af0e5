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

"""Evaluate an attitude filter live:  ros2 launch lie_rigid_body estimator.launch.py package:=imu_filter_madgwick.

Starts the simulator with an IMU and a magnetometer, the filter, and the evaluator, which says the score at the end:
after duration:=60.0 of simulated time, or at Ctrl-C. The exit status is 0 if every limit, as max_rms:=1deg, is kept.
Every parameter of the simulator is an argument. With lockstep:=true it waits for the filter's answers: then the score
does not depend on how busy the machine is. When one part dies, so does the rest, and the exit status is 1.
"""

import shlex

from launch_ros.actions import Node

from lie_rigid_body.evaluation import Limits
from lie_rigid_body.evaluation.consistency import require_axes
from lie_rigid_body.ros import launching
from lie_rigid_body.scenario.parameter_file import parse_assignment

PLAIN = {"use_mag": True, "publish_tf": False}
KNOWN = {
    "imu_filter_madgwick": ("imu_filter_madgwick_node", {"world_frame": "enu", **PLAIN}),
    "imu_complementary_filter": ("complementary_filter_node", PLAIN),
}
"""Filters by their packages: the executable, and parameters that are given unless others are."""
ABSOLUTE = {f"/imu/{name}": f"imu/{name}" for name in ("data_raw", "mag", "data")}
"""Names that some filters have without a namespace, and what they have to be in one."""
BENCH = {"imu_rate": "100.0", "magnetometer_rate": "100.0", "gyro_rate": "integrated"}
BENCH["accelerometer_mode"] = "pivot_gravity"
"""Sensors of the simulator where its scenario, its file and the arguments give no IMU."""
ARGUMENTS = {
    "package": ("imu_filter_madgwick", "the filter's package"),
    "executable": ("", f"the filter's executable; known of {' and '.join(KNOWN)}"),
    "parameters": ("", "the filter's parameters, as in 'gain:=0.05 use_mag:=false'"),
    "estimator_params_file": ("", "a ROS 2 parameter file for the filter"),
    "remappings": ("", "the filter's topics, as in 'imu:=imu/data_raw attitude:=imu/data'"),
    "estimate": ("imu/data", "the topic of the filter's attitude, of any type that evaluate takes"),
    "scenario": ("tumbling_cubesat", "a scenario of the package; 'ros2 run lie_rigid_body scenarios' lists them"),
    "params_file": ("", "a ROS 2 parameter file for the simulator"),
    "namespace": ("", "goes before the names of all nodes, their topics and services"),
    "lockstep": ("false", "whether the simulator waits for the filter's answer to each reading"),
}
OPTIONS = {
    "max_rms": "largest RMS of the error, as in 1deg",
    "max_after": "largest error after a time, as in 10s:2deg; several with spaces between them",
    "duration": "end when the estimate spans so many seconds",
    "wait": "end when no estimate could be compared for so many seconds",
    "covariance_axes": "what the estimate's covariance is about: world, or body",
    "report": "write score, findings and picture as one page into this file, .html",
    "plot": "draw the errors over time into this file, .png",
}
"""Options of the evaluator, with underscores."""


def generate_launch_description():
    """Describe the launch."""
    options = {name: ("", text) for name, text in OPTIONS.items()}
    return launching.description(__file__, {**ARGUMENTS, **options}, nodes)


def nodes(given):
    """Return the simulator, the filter and the evaluator, whose end is that of the rest."""
    Limits.parse(given["max_rms"] or None, tuple(given["max_after"].split()))
    require_axes(given["covariance_axes"] or "world")
    parts = (simulator(given), estimator(given), evaluator(given))
    launching.require_executables(*((part["package"], part["executable"]) for part in parts))
    return [Node(**part) for part in parts]


def simulator(given):
    """Return the settings of the simulator, with sensors where none are given."""
    if given["lockstep"] == "true":
        given = {**given, "lockstep_topic": given["lockstep_topic"] or given["estimate"]}
        given["lockstep_nodes"] = given["lockstep_nodes"] or "[evaluator]"
    settings, scenario = launching.simulator(given, namespace=given["namespace"])
    if scenario.sensors.imu is None:
        bench = {name: given[name] or value for name, value in BENCH.items()}
        settings, _ = launching.simulator({**given, **bench}, namespace=given["namespace"])
    return {**settings, "on_exit": launching.fail_unless_shut_down}


def estimator(given):
    """Return the settings of the filter."""
    executable, usual = KNOWN.get(given["package"], ("", {}))
    executable = given["executable"] or executable
    if not executable:
        package = given["package"]
        raise ValueError(f"executable: that of {package} is not known: give executable:=NAME, one of its lib/{package}")
    own = dict(parse_assignment(word) for word in shlex.split(given["parameters"]))
    remappings = [pair("remappings", word) for word in given["remappings"].split()]
    return {
        "package": given["package"],
        "executable": executable,
        "namespace": given["namespace"],
        "parameters": [part for part in (usual, given["estimator_params_file"], own) if part],
        "remappings": [*remappings, *(ABSOLUTE.items() if given["namespace"] else ())],
        "output": "screen",
        "on_exit": launching.fail_unless_shut_down,
    }


def pair(argument, word):
    """Return both sides of FROM:=TO."""
    left, separator, right = word.partition(":=")
    if not (left and separator and right):
        raise ValueError(f"{argument}: {word!r} is not FROM:=TO: give for example imu:=imu/data_raw")
    return left, right


def evaluator(given):
    """Return the settings of the evaluator."""
    words = []
    for name in OPTIONS:
        for value in given[name].split() if name == "max_after" else filter(None, [given[name]]):
            words += [f"--{name.replace('_', '-')}", value]
    return {
        "package": "lie_rigid_body",
        "executable": "evaluate",
        "name": "evaluator",
        "namespace": given["namespace"],
        "arguments": words,
        "remappings": [("estimate", given["estimate"])],
        "output": "screen",
        "on_exit": launching.end_with_status,
    }
