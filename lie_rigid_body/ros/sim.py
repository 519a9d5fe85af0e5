"""The command line of ``sim``, the live node."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from lie_rigid_body import console
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.ros.arguments import Arguments, parse
from lie_rigid_body.ros.installation import require_ros


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
    given = parse(sys.argv[1:] if argv is None else argv)
    require_ros()
    _require_readable(given)
    from lie_rigid_body.ros.simulator import simulate  # only now: it needs ROS

    simulate(given, Interruption.current())
    return console.SUCCESS


def _require_readable(given: Arguments) -> None:
    """Check parameters given as ROS arguments, whose errors rclpy reports less clearly."""
    from lie_rigid_body.scenario.parameter_file import parse_assignment, read_sections

    for path in given.given_to_ros("--params-file"):
        read_sections(path, pipes=False)
    for text in given.given_to_ros("-p", "--param"):
        parse_assignment(text)
