"""Text on the terminal: body, motion, topics and commands to listen with at the node's start, and a line at its end."""

from __future__ import annotations

import shlex
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from lie_rigid_body.mechanics import RigidBody
from lie_rigid_body.mechanics.top import kind_of_top
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.wording import counted


@dataclass(frozen=True)
class Names:
    """Full names of the node, its topics and its reset service, as remapped.

    Parameters
    ----------
    node, pose, twist, scenario, reset : str
    domain : int
        The ROS domain.
    sensors : tuple of str
        Full names of the topics of the sensors that are on, and of their faults.
    """

    node: str
    pose: str
    twist: str
    scenario: str
    reset: str
    domain: int
    sensors: tuple[str, ...] = ()


def announcement(scenario: Scenario, names: Names, record_path: str) -> str:
    """The text, several lines without a last line end.

    Parameters
    ----------
    scenario : Scenario
    names : Names
    record_path : str
        The bag that the node records; empty: none.
    """
    twist = "TwistStamped" if scenario.stamped_twist else "Twist"
    lines = [
        f"{names.node} simulates a torque-free rigid body",
        f"  body      {shape(scenario.body())}, inertia {_numbers(scenario.inertia)} kg m²",
        f"  start     body rate {_numbers(scenario.initial_body_rate)} rad/s, "
        f"attitude {_numbers(scenario.initial_attitude_xyzw)} (x y z w)",
        f"  motion    {_motion(scenario)}",
        f"publishes {scenario.rate:g} times a second, in ROS domain {names.domain}",
        f"  {names.pose}  PoseStamped in {scenario.world_frame}",
        f"  {names.twist}  {twist} in {scenario.body_frame}",
        f"  {names.scenario}  the whole scenario, latched",
        *([f"  {' '.join(names.sensors)}  of the sensors"] if names.sensors else []),
        *([f"records {record_path}"] if record_path else []),
        "listen and reset from another terminal",
        *(f"  {command}" for command in commands(names)),
        "Ctrl-C ends it.",
    ]
    return "\n".join(lines)


def farewell(node: str, punctuality: Punctuality) -> str:
    """The line at the end: how many samples were sent, and how many of them late."""
    late = f"{punctuality.missed} of them late, by up to {punctuality.worst_ns / 1e6:.3g} ms"
    sent = counted(punctuality.sent, "sample")
    return f"{node} ends: {sent} sent, {late if punctuality.missed else 'none of them late'}"


def commands(names: Names) -> list[str]:
    """Commands for another terminal, to listen and to reset: those of ``ros2`` where it is installed, else `listen`."""
    domain = f"ROS_DOMAIN_ID={names.domain} " if names.domain else ""
    if shutil.which("ros2"):
        return [
            f"{domain}ros2 topic echo {names.pose}",
            f"{domain}ros2 service call {names.reset} std_srvs/srv/Trigger",
        ]
    listen = f"{domain}{_python()} -m lie_rigid_body.ros.listen"
    return [f"{listen} --pose {names.pose}", f"{listen} --reset {names.reset}"]


def _python() -> str:
    """The command for the Python of this process: its name if the PATH leads to it, else its full path."""
    found = shutil.which("python")
    return "python" if found and Path(found) == Path(sys.executable) else shlex.quote(sys.executable)


def shape(body: RigidBody) -> str:
    """The body's kind of top in words."""
    kind = kind_of_top(body)
    return f"{kind} symmetric top" if kind in ("oblate", "prolate") else f"{kind} top"


def _motion(scenario: Scenario) -> str:
    if scenario.motion == "closed_form":
        return "closed_form, the exact solution"
    return f"{scenario.motion}, stepper {scenario.method}, steps of at most {scenario.max_step:g} s"


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
