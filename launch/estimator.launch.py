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

from lie_rigid_body.ros import launching

PLAIN = {"use_mag": True, "publish_tf": False}
KNOWN = {
    "imu_filter_madgwick": ("imu_filter_madgwick_node", {"world_frame": "enu", **PLAIN}),
    "imu_complementary_filter": ("complementary_filter_node", PLAIN),
}
"""Filters by their packages: the executable, and parameters that are given unless others are."""
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
OPTIONS = ("max_rms", "max_after", "duration", "wait", "covariance_axes", "report", "plot")
"""Options of the evaluator."""


def generate_launch_description():
    """Describe the launch."""
    return launching.description(__file__, {**ARGUMENTS, **launching.options(OPTIONS)}, nodes)


def nodes(given):
    """Return the simulator, the filter and the evaluator, whose end is that of the rest."""
    known, usual = KNOWN.get(given["package"], ("", {}))
    executable = given["executable"] or known
    if not executable:
        raise ValueError(f"executable: give that of {given['package']}, as executable:=NAME")
    tested = launching.estimator(given, executable, usual)
    return [launching.bench(given), tested, launching.evaluator(given, OPTIONS)]
