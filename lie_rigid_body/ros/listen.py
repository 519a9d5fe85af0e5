"""The command line of ``python -m lie_rigid_body.ros.listen``, for places where there is no ros2 command."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Final

from lie_rigid_body.command_line import Parser, argument
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

PROGRAM: Final = "python -m lie_rigid_body.ros.listen"
NODE: Final = "/lie_rigid_body"
CALLS: Final = {
    "reset": "reset the motion, and end",
    "pause": "let time stand still, and end",
    "resume": "let time go on, and end",
    "step": "while paused send one sample, and end",
}
"""Services that have an option of their own, each with its line in the help."""


def main(argv: Sequence[str] | None = None) -> int:
    """Print poses until Ctrl-C, or ask the node for one thing.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0, 2 when the input is unusable or there is no answer, 130 when interrupted before an answer.
    """
    return console.status_of(PROGRAM, lambda: _main(argv), to_the_end=argv is None)


def _main(argv: Sequence[str] | None) -> int:
    given = _parser().parse_args(argv)
    require_ros()
    from lie_rigid_body.ros.client import ask  # only now: it needs ROS

    ask(given, CALLS, Interruption.current())
    return console.SUCCESS


def _parser() -> Parser:
    parser = Parser(
        "listen",
        "Print the poses that the node publishes, or ask the node for one thing.",
        argument("--pose", metavar="TOPIC", default="/pose", help="the topic to listen to; /pose if not given"),
        either=(
            *(
                argument(f"--{name}", metavar="SERVICE", nargs="?", const=f"{NODE}/{name}", help=what)
                for name, what in CALLS.items()
            ),
            argument(
                "--scenario",
                metavar="TOPIC",
                nargs="?",
                const=f"{NODE}/scenario",
                help="print the latched scenario, and end",
            ),
            argument("--get", metavar="NAME", help="print a parameter, and end"),
            argument("--set", metavar="NAME:=VALUE", help="set a parameter, and end"),
        ),
    )
    parser.prog = PROGRAM
    parser.add_argument("--node", metavar="NAME", default=NODE, help=f"whose parameters; {NODE} if not given")
    return parser


if __name__ == "__main__":
    sys.exit(main())
