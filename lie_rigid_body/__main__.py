"""``lie-rigid-body VERB …``: one name for every executable of the package.

Each verb is imported when it is called and not before. So the help answers at once, and nothing but ``sim`` needs ROS.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import NamedTuple

from lie_rigid_body import __version__, console

PROGRAM = "lie-rigid-body"


class Verb(NamedTuple):
    """A verb: the module of its ``main(argv) -> int``, and a summary."""

    module: str
    summary: str


VERBS = {
    "sim": Verb("lie_rigid_body.ros.sim", "run the live ROS 2 node"),
    "record": Verb("lie_rigid_body.cli.record", "write a bag, without ROS"),
    "check": Verb("lie_rigid_body.cli.check", "certify that a bag obeys the conservation laws"),
    "plot": Verb("lie_rigid_body.cli.plot", "draw a bag: body rate, drifts and polhode"),
    "evaluate": Verb("lie_rigid_body.cli.evaluate", "score and diagnose an attitude estimate in a bag"),
    "explain": Verb("lie_rigid_body.cli.explain", "tell what the mathematics says about a scenario"),
    "scenarios": Verb("lie_rigid_body.cli.scenarios", "list the scenarios that come with the package"),
}

ROS_PARTS = frozenset({"rclpy", "rcl_interfaces", "geometry_msgs", "std_msgs", "std_srvs"})


def usage() -> str:
    """Return the help text."""
    verbs = (f"  {name:10} {verb.summary}" for name, verb in VERBS.items())
    return "\n".join(
        [
            f"usage: {PROGRAM} VERB ...",
            "",
            "Torque-free rigid-body motion: live, recorded, certified.",
            "",
            *verbs,
            "",
            f"'{PROGRAM} VERB --help' explains one of them; '{PROGRAM} --version' tells the version.",
        ]
    )


def answer(text: str) -> int:
    """Print a text on stdout, and return the exit status."""

    def action() -> int:
        console.say(text)
        return console.SUCCESS

    return console.status_of(PROGRAM, action)


def refuse(message: str) -> int:
    """Print on one line of stderr what is wrong, and return the exit status for unusable input."""
    print(f"{PROGRAM}: {message}", file=sys.stderr)
    return console.UNUSABLE


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : sequence of str, optional
        The command line without the program's name; ``sys.argv[1:]`` when left out.

    Returns
    -------
    int
        The exit status: the verb's own, or 2 when no known verb is given.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if not arguments:
        print(usage(), file=sys.stderr)
        return console.UNUSABLE
    name, *rest = arguments
    if name in ("-h", "--help"):
        return answer(usage())
    if name == "--version":
        return answer(f"{PROGRAM} {__version__}")
    if name not in VERBS:
        return refuse(f"unknown verb {name!r}; known are {', '.join(VERBS)}; see '{PROGRAM} --help'")
    return run(name, rest)


def run(name: str, argv: list[str]) -> int:
    """Import the verb and call it."""
    try:
        verb: Callable[[list[str]], int] = import_module(VERBS[name].module).main
        return verb(argv)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in ROS_PARTS:
            raise
        return refuse(
            f"{name} needs ROS 2, and {error.name} is not installed; source a ROS 2 installation or, "
            "with Python 3.12 on Linux, pip install '.[ros]' in a clone; 'record' works without"
        )


if __name__ == "__main__":
    sys.exit(main())
