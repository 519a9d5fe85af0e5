"""The command line of the node: its own options, and the arguments for ROS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from lie_rigid_body import console

DESCRIPTION: Final = "Run the live ROS 2 node."
EPILOG: Final = """
ROS arguments follow --ros-args: remapping (-r pose:=truth, -r __ns:=/a), parameters (-p rate:=200.0, or
--params-file FILE). They win over the options above. Ctrl-C ends the node, and finishes the bag of record_path.
If that bag can no longer be written, the node says so at once, goes on publishing, and ends with status 2.
"""


@dataclass(frozen=True)
class Arguments:
    """A command line, split.

    Parameters
    ----------
    scenario : str or None
    params_files, assignments : tuple of str
        Values of the node's own options, in the order given.
    ros : tuple of str
        Arguments for rclpy, with their ``--ros-args``; empty if there are none.
    """

    scenario: str | None
    params_files: tuple[str, ...]
    assignments: tuple[str, ...]
    ros: tuple[str, ...]

    def given_to_ros(self, *options: str) -> tuple[str, ...]:
        """The values that rclpy will read for an option, which may have several names."""
        return tuple(value for option, value in zip(self.ros, self.ros[1:], strict=False) if option in options)


def parse(argv: Sequence[str]) -> Arguments:
    """Read a command line, without the program's name."""
    own, ros = console.split_ros_arguments(argv)
    found = console.Parser("sim", DESCRIPTION, epilog=EPILOG, scenario=True).parse_args(own)
    return Arguments(found.scenario, tuple(found.params_file), tuple(found.assignments), tuple(ros))
