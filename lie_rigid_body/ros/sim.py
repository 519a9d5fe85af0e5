"""The command line of ``sim``, the live node: its own options, and the arguments for ROS."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from lie_rigid_body.command_line import Parser, split_ros_arguments
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

EPILOG: Final = """
ROS arguments follow --ros-args: remapping (-r pose:=truth, -r __ns:=/a), parameters (-p rate:=200.0, or
--params-file FILE). They win over the options above. Ctrl-C ends the node, and finishes the bag of record_path.
If that bag can no longer be written, the node says so at once, goes on publishing, and ends with status 2.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT, SIGTERM or SIGHUP.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0 when asked to end, 2 when the input is unusable or the bag could not be written to its end.
    """
    return console.status_of(console.program("sim"), lambda: _main(argv), to_the_end=argv is None)


def _main(argv: Sequence[str] | None) -> int:
    given = parse(argv)
    require_ros()
    _require_readable(given.ros)
    from lie_rigid_body.ros.node import simulate  # only now: it needs ROS

    simulate(given, Interruption.current())
    return console.SUCCESS


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read a command line, without the program's name.

    Returns
    -------
    argparse.Namespace
        The options of a scenario, and as ``ros`` the arguments for rclpy, with their
        ``--ros-args``; empty if there are none.
    """
    own, ros = split_ros_arguments(argv)
    parser = Parser("sim", "Run the live ROS 2 node.", epilog=EPILOG, scenario=True)
    return parser.parse_args(own, argparse.Namespace(ros=ros))


def given_to_ros(ros: Sequence[str], *options: str) -> list[str]:
    """The values that rclpy will read for an option, which may have several names."""
    return [value for option, value in pairwise(ros) if option in options]


def _require_readable(ros: Sequence[str]) -> None:
    """Check parameters given as ROS arguments, whose errors rclpy reports less clearly."""
    from lie_rigid_body.scenario.parameter_file import parse_assignment, read_sections

    for path in given_to_ros(ros, "--params-file"):
        read_sections(path, pipes=False)
    for text in given_to_ros(ros, "-p", "--param"):
        parse_assignment(text)
