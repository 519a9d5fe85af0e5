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
For imu_filter_madgwick and imu_complementary_filter the executable and what makes them use both sensors are known.
Every parameter of the simulator is an argument. With lockstep:=true the simulator waits for the filter's answers, so
that the score does not depend on how busy the machine is; real_time_factor:=0.0 is then as fast as the filter.
When one part dies, so does the rest, and the exit status is 1.
"""

from __future__ import annotations

import shlex
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from lie_rigid_body.evaluation import Limits
from lie_rigid_body.evaluation.consistency import require_axes
from lie_rigid_body.ros import launching
from lie_rigid_body.scenario.parameter_file import parse_assignment

PACKAGE = "lie_rigid_body"
KNOWN: dict[str, tuple[str, dict[str, Any]]] = {
    "imu_filter_madgwick": (
        "imu_filter_madgwick_node",
        {"world_frame": "enu", "use_mag": True, "publish_tf": False},
    ),
    "imu_complementary_filter": ("complementary_filter_node", {"use_mag": True, "publish_tf": False}),
}
"""Filters by their packages: the executable, and parameters that are given unless others are."""
ABSOLUTE = {f"/imu/{name}": f"imu/{name}" for name in ("data_raw", "mag", "data")}
"""Names that some filters have without a namespace, and what they have to be in one."""
BENCH = {
    "imu_rate": "100.0",
    "magnetometer_rate": "100.0",
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
}
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


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    texts = {**ARGUMENTS, **{name: ("", text) for name, text in {**OPTIONS, **launching.descriptions()}.items()}}
    choices = {"lockstep": {"choices": ["true", "false"]}}
    given = [
        DeclareLaunchArgument(name, default_value=default, description=text, **choices.get(name, {}))
        for name, (default, text) in texts.items()
    ]
    return LaunchDescription([*given, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the simulator, the filter and the evaluator, once all that they need is found."""
    known = (*ARGUMENTS, *OPTIONS, *launching.descriptions())
    launching.require_known(__file__, context.argv, known)
    given = {name: LaunchConfiguration(name).perform(context) for name in known}
    words = simulator_words(given)
    Limits.parse(given["max_rms"] or None, tuple(given["max_after"].split()))
    require_axes(given["covariance_axes"] or "world")
    filter_node = estimator(given)
    launching.require_executables(
        (PACKAGE, "sim"), (PACKAGE, "evaluate"), (given["package"], executable(given["package"], given["executable"]))
    )
    return [simulator(given, words), filter_node, evaluator(given)]


def simulator_words(given: dict[str, str]) -> list[str]:
    """Return the arguments of the simulator, with sensors where none are given."""
    parameters = {name: given[name] for name in launching.descriptions()}
    if given["lockstep"] == "true":
        parameters["lockstep_topic"] = parameters["lockstep_topic"] or given["estimate"]
        parameters["lockstep_nodes"] = parameters["lockstep_nodes"] or "[evaluator]"
    words = launching.arguments_of_node(given["scenario"], given["params_file"], parameters)
    if launching.scenario_of_node(words, PACKAGE, given["namespace"]).sensors.imu is None:
        parameters = {**BENCH, **{name: value for name, value in parameters.items() if value}}
        words = launching.arguments_of_node(given["scenario"], given["params_file"], parameters)
        launching.scenario_of_node(words, PACKAGE, given["namespace"])  # or its refusal
    return words


def simulator(given: dict[str, str], words: list[str]) -> Node:
    """Return the simulator."""
    return Node(
        package=PACKAGE,
        executable="sim",
        name=PACKAGE,
        namespace=given["namespace"],
        arguments=words,
        on_exit=launching.fail_unless_shut_down,
    )


def executable(package: str, name: str) -> str:
    """Return the filter's executable."""
    if name or package in KNOWN:
        return name or KNOWN[package][0]
    raise ValueError(f"executable: that of {package} is not known: give executable:=NAME, one of its lib/{package}")


def estimator(given: dict[str, str]) -> Node:
    """Return the filter."""
    package, file = given["package"], given["estimator_params_file"]
    usual = KNOWN.get(package, ("", {}))[1]
    own = dict(parse_assignment(word) for word in shlex.split(given["parameters"]))
    remappings = [pair("remappings", word) for word in given["remappings"].split()]
    return Node(
        package=package,
        executable=executable(package, given["executable"]),
        namespace=given["namespace"],
        parameters=[part for part in (usual, file, own) if part],
        remappings=[*remappings, *(ABSOLUTE.items() if given["namespace"] else ())],
        output="screen",
        on_exit=launching.fail_unless_shut_down,
    )


def pair(argument: str, word: str) -> tuple[str, str]:
    """Return both sides of FROM:=TO."""
    left, separator, right = word.partition(":=")
    if not (left and separator and right):
        raise ValueError(f"{argument}: {word!r} is not FROM:=TO: give for example imu:=imu/data_raw")
    return left, right


def evaluator(given: dict[str, str]) -> Node:
    """Return the evaluator, whose end is that of the rest."""
    words = []
    for name in OPTIONS:
        for value in given[name].split() if name == "max_after" else filter(None, [given[name]]):
            words += [f"--{name.replace('_', '-')}", value]
    return Node(
        package=PACKAGE,
        executable="evaluate",
        name="evaluator",
        namespace=given["namespace"],
        arguments=words,
        remappings=[("estimate", given["estimate"])],
        output="screen",
        on_exit=launching.end_with_status,
    )
