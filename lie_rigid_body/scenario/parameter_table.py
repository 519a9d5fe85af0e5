"""The table of all parameters: for the node, parameter files, the command line and the documentation."""

from __future__ import annotations

from typing import Final

from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, Given, Parameter, Value, read_table
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.kicks import KICK_NUMBERS, MAX_KICKS
from lie_rigid_body.motion.moving_chart import DEFAULT_MAX_STEP, DEFAULT_METHOD
from lie_rigid_body.motion.path import KNOT_NUMBERS, MAX_KNOTS
from lie_rigid_body.sensors import SENSORS, graded
from lie_rigid_body.sensors.parameters import harmonics_parameters, not_negative, numbers, seed

MAX_TRANSLATION: Final = 1e9
"""Largest size of positions, m, and velocities, m/s, on each axis, and the largest period of kicks, s."""

OWN: Final = (
    Parameter(
        "inertia",
        "double_array",
        (1.0, 2.0, 3.0),
        "Inertia about the mass centre, kg m²: 3 principal moments along the body axes, or ixx ixy ixz iyy iyz izz.",
        lengths=(3, 6),
    ),
    numbers(
        "initial_attitude_xyzw",
        (0.0, 0.0, 0.0, 1.0),
        "Unit quaternion, scalar last, taking body vectors to world vectors at the start.",
    ),
    numbers("initial_body_rate", (0.01, 1.0, 0.01), "Angular velocity in the body frame at the start, rad/s."),
    Parameter(
        "rate",
        "double",
        100.0,
        "Samples per second, from one in eleven days to one per nanosecond.",
        minimum=1e-6,
        maximum=1e9,
    ),
    Parameter(
        "motion",
        "string",
        "moving_chart",
        "How the state moves: moving_chart integrates Euler's equations, closed_form evaluates the exact solution, "
        "path follows the poses of path_file.",
        choices=("moving_chart", "closed_form", "path"),
    ),
    Parameter("method", "string", DEFAULT_METHOD, "Stepper of the moving chart.", choices=tuple(METHODS)),
    not_negative(
        "max_step",
        "Largest step of the moving chart, s; 0: as long as the method allows (dmv20: a turn of ¼ rad; others: 1 ms).",
        DEFAULT_MAX_STEP,
        1e6,
    ),
    Parameter(
        "kicks",
        "double_array",
        (),
        "Kicks, four numbers each: time, s since the start, and the body rate right after it, rad/s; zeros: a rest.",
        lengths=range(0, KICK_NUMBERS * MAX_KICKS + 1, KICK_NUMBERS),
    ),
    not_negative(
        "kick_period",
        "Time after which the kicks come again, s, longer than the time of the last one; 0: they come once.",
        maximum=MAX_TRANSLATION,
    ),
    Parameter(
        "translation",
        "string",
        "none",
        "How the mass centre moves: none, it rests at initial_position; thrown, it falls freely; carried, it sways.",
        choices=("none", "thrown", "carried"),
    ),
    *(
        Parameter(
            f"initial_{of}",
            "double_array",
            (0.0, 0.0, 0.0),
            f"{of.capitalize()} of the mass centre in the world frame at the start, {unit}.",
            lengths=(3,),
            minimum=-MAX_TRANSLATION,
            maximum=MAX_TRANSLATION,
        )
        for of, unit in (("position", "m"), ("velocity", "m/s"))
    ),
    *harmonics_parameters(
        "sway", "the acceleration of the carried mass centre along each axis of the world", (0.2, 2.0)
    ),
    seed("sway_seed", "Seed of the frequencies and phases of the sway."),
    Parameter(
        "path_file",
        "string",
        "",
        "Poses that the motion path goes through: TUM (t x y z qx qy qz qw, s), EuRoC CSV, t_ns,x,y,z,w, or a bag.",
    ),
    not_negative(
        "path_interval",
        "Poses of path_file that are nearer than that, s, are averaged into one knot of the path; 0: each is one.",
        0.03,
        1e6,
    ),
    Parameter(
        "path_knots",
        "double_array",
        (),
        "Knots of the path: time, s since the first pose, position, m, attitude x y z w each; empty: of path_file.",
        lengths=range(0, KNOT_NUMBERS * MAX_KNOTS + 1, KNOT_NUMBERS),
        minimum=-MAX_TRANSLATION,
        maximum=MAX_TRANSLATION,
    ),
    Parameter("world_frame", "string", "world", "Name of the inertial frame of the pose."),
    Parameter("body_frame", "string", "base_link", "Name of the body frame of the twist."),
    Parameter("stamped_twist", "bool", True, "Publish TwistStamped (true) or bare Twist (false)."),
    Parameter(
        "epoch_ns",
        "int",
        0,
        "Stamp of the first sample, ns; 0 in the node means the time of start.",
        minimum=0,
        maximum=MAX_EPOCH_NS,
    ),
    Parameter("record_path", "string", "", "The node also writes this MCAP file; empty: it writes none.", scope="node"),
    Parameter(
        "real_time_factor",
        "double",
        1.0,
        "How fast the node's samples follow one another: 2 is twice as fast as time passes, 0 as fast as possible.",
        minimum=0.0,
        maximum=1e6,
        scope="node",
    ),
    Parameter("publish_clock", "bool", False, "The node publishes /clock, in step with its samples.", scope="node"),
    Parameter("paused", "bool", False, "The node starts paused, before its first sample.", scope="node"),
    Parameter(
        "publish_tf",
        "bool",
        True,
        "The node publishes /tf and /tf_static, where the package tf2_msgs is installed.",
        scope="node",
    ),
    Parameter(
        "marker_rate",
        "double",
        20.0,
        "Pictures of the body per second of the steady clock, for RViz and Foxglove, while somebody looks; 0: none.",
        minimum=0.0,
        maximum=1000.0,
        scope="node",
    ),
    Parameter(
        "lockstep_topic",
        "string",
        "",
        "The node waits for the estimate of each IMU reading on this topic before it sends what follows; empty: never.",
        scope="node",
    ),
    Parameter(
        "lockstep_nodes",
        "string_array",
        (),
        "Nodes beside the filter, as an evaluator, that must have their subscriptions before lock-step begins.",
        scope="node",
    ),
    Parameter(
        "lockstep_timeout",
        "double",
        10.0,
        "Longest wait for an answer in lock-step, s; then the node says so and ends.",
        minimum=1e-3,
        maximum=1e6,
        scope="node",
    ),
)
"""Parameters of a scenario and of the live node, except for those of sensors."""

BY_NAME: Final = {**{parameter.name: parameter for parameter in OWN}, **SENSORS.parameters}
"""Parameters by name, in the order in which they are shown."""
PARAMETERS: Final = tuple(BY_NAME.values())
"""All parameters, in the order of `BY_NAME`."""


def read_parameters(given: Given) -> dict[str, Value]:
    """Every parameter's value: the given ones in their own types, those of their grade, the rest at their defaults.

    Parameters
    ----------
    given : mapping of str to object

    Returns
    -------
    dict of str to value

    Raises
    ------
    ParameterError
        If a name is unknown or a value is not of its parameter's type, length, range or choice.
    """
    return read_table(PARAMETERS, graded(given))
