"""The command line of the node: its own options, and those for ROS."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from lie_rigid_body import console

_BEGIN: Final = "--ros-args"
_END: Final = "--"

DESCRIPTION: Final = "Run the live ROS 2 node."
EPILOG: Final = """
ROS arguments follow --ros-args: remapping (-r pose:=truth, -r __ns:=/a), parameters (-p rate:=200.0, or
--params-file FILE). They win over the options above. Ctrl-C ends the node, and finishes the bag of record_path.
If that bag can no longer be written, the node says so and ends with status 2.
"""


@dataclass(frozen=True)
class Arguments:
    """What the user asked for.

    Parameters
    ----------
    scenario : str or None
    params_files, assignments : tuple of str
        The node's own options.
    ros : tuple of str
        Arguments for rclpy, with their ``--ros-args``.
    """

    scenario: str | None
    params_files: tuple[str, ...]
    assignments: tuple[str, ...]
    ros: tuple[str, ...]

    @property
    def ros_params_files(self) -> tuple[str, ...]:
        """The parameter files that rclpy will read."""
        return self._values_of("--params-file")

    @property
    def ros_assignments(self) -> tuple[str, ...]:
        """The assignments that rclpy will read."""
        return self._values_of("-p", "--param")

    def _values_of(self, *options: str) -> tuple[str, ...]:
        return tuple(value for option, value in zip(self.ros, self.ros[1:], strict=False) if option in options)


def parse(argv: Sequence[str]) -> Arguments:
    """Read a command line, without the program's name."""
    own, ros = split(argv)
    parser = console.Parser("sim", DESCRIPTION)
    parser.epilog = EPILOG
    console.add_scenario_arguments(parser)
    found = parser.parse_args(own)
    return Arguments(found.scenario, tuple(found.params_file), tuple(found.assignments), tuple(ros))


def split(argv: Iterable[str]) -> tuple[list[str], list[str]]:
    """A command line's own part, and its ROS part: what lies between ``--ros-args`` and ``--`` or the end."""
    own: list[str] = []
    ros: list[str] = []
    target = own
    for argument in argv:
        if argument == _BEGIN:
            target = ros
        if target is ros and argument == _END:
            target = own
            continue
        if argument != _BEGIN:
            target.append(argument)
    return own, [_BEGIN, *ros] if ros else []
