"""Text on the terminal: body, motion, topics and commands to listen with at the node's start, and a line at its end."""

from __future__ import annotations

import shlex
import shutil
import sys
from collections.abc import Mapping

from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.mechanics import RigidBody
from lie_rigid_body.mechanics.top import kind_of_top
from lie_rigid_body.messages.batch import POSE, TWIST, sensor_topics
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.facts import facts


def announcement(scenario: Scenario, names: Mapping[str, str], domain: int, record_path: str) -> str:
    """The text, several lines without a last line end.

    Parameters
    ----------
    scenario : Scenario
    names : mapping of str to str
        Full names of topics and of the reset service, as remapped, by their relative names; of ``~``, the node.
    domain : int
        The ROS domain.
    record_path : str
        The bag that the node records; empty: none.
    """
    sensors = " ".join(names[topic] for topic in sensor_topics(scenario.sensors))
    twist = "TwistStamped" if scenario.stamped_twist else "Twist"
    kind = "path" if scenario.path() else f"{'kicked' if scenario.kicks else 'torque-free'} rigid body"
    lines = [
        f"{names['~']} simulates a {kind}",
        *([] if scenario.path() else _body_and_start(scenario)),
        f"  motion      {_motion(scenario)}",
        *(f"  {name:<11} {phrase}" for name, phrase in facts(scenario).items()),
        f"publishes {scenario.rate:g} times a second, in ROS domain {domain}",
        f"  {names[POSE]}  PoseStamped in {scenario.world_frame}",
        f"  {names[TWIST]}  {twist} in {scenario.body_frame}",
        f"  {names['~/scenario']}  the whole scenario, latched",
        *([f"  {sensors}  of the sensors"] if sensors else []),
        *([f"records {record_path}"] if record_path else []),
        "listen and reset from another terminal",
        *(f"  {command}" for command in commands(names, domain)),
        "Ctrl-C ends it.",
    ]
    return "\n".join(lines)


def farewell(node: str, punctuality: Punctuality) -> str:
    """The line at the end: how many samples of the truth were sent, and how many of them late."""
    late = f"{punctuality.missed} of them late, by up to {punctuality.worst_ns / 1e6:.3g} ms"
    sent = counted(punctuality.sent, "truth sample")
    return f"{node} ends: {sent} sent, {late if punctuality.missed else 'none of them late'}"


def commands(names: Mapping[str, str], domain: int) -> list[str]:
    """Commands for another terminal, to listen and to reset: those of ``ros2`` where it is installed, else `listen`.

    The Python of this process has its full path, as another terminal may be in another environment.
    """
    prefix = f"ROS_DOMAIN_ID={domain} " if domain else ""
    if shutil.which("ros2"):
        return [
            f"{prefix}ros2 topic echo {names[POSE]}",
            f"{prefix}ros2 service call {names['~/reset']} std_srvs/srv/Trigger",
        ]
    listen = f"{prefix}{shlex.quote(sys.executable)} -m lie_rigid_body.ros.listen"
    return [f"{listen} --pose {names[POSE]}", f"{listen} --reset {names['~/reset']}"]


def shape(body: RigidBody) -> str:
    """The body's kind of top in words."""
    kind = kind_of_top(body)
    return f"{kind} symmetric top" if kind in ("oblate", "prolate") else f"{kind} top"


def _body_and_start(scenario: Scenario) -> list[str]:
    """Lines about the body and its start."""
    return [
        f"  body        {shape(scenario.body())}, inertia {_numbers(scenario.inertia)} kg m²",
        f"  start       body rate {_numbers(scenario.initial_body_rate)} rad/s, "
        f"attitude {_numbers(scenario.initial_attitude_xyzw)} (x y z w)",
    ]


def _motion(scenario: Scenario) -> str:
    if path := scenario.path():
        return f"path, through {len(path)} knots, of {path.last_ns / NS:.6g} s"
    if scenario.motion == "closed_form":
        return "closed_form, the exact solution"
    return f"{scenario.motion}, stepper {scenario.method}, steps of at most {scenario.longest_step:.3g} s"


def _numbers(values: Vector) -> str:
    return " ".join(f"{value:g}" for value in values)
