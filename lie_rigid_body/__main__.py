"""``lie-rigid-body VERB …``: one name for every executable of the package.

Each verb is imported when it is called and not before. So the help answers at once, and nothing but ``sim`` and the
live ``evaluate`` needs ROS.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Final

from lie_rigid_body import __version__
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.system import console

PROGRAM = "lie-rigid-body"


VERBS = {
    "sim": "run the live ROS 2 node",
    "record": "write a bag, without ROS",
    "check": "certify that a bag obeys the conservation laws",
    "recover": "rescue what is whole of a bag that was cut off",
    "plot": "draw a bag: body rate, drifts and polhode",
    "evaluate": "score and diagnose an attitude estimate, in a bag or live",
    "explain": "tell what the mathematics says about a scenario",
    "scenarios": "list the scenarios that come with the package",
    "campaign": "record and certify many runs drawn at random",
    "inspect": "say what is wrong with a log of sensors, without truth",
    "diagnose": "say what is wrong with an attitude filter, by repairing it",
    "league": "rank an attitude filter among known ones, over the same cases",
}
"""Verbs and what they do."""
EXTRAS = {
    "campaign": ("pyarrow",),
    "cluster": ("distributed", "pyarrow"),
    "fast": ("numba",),
    "proof": ("flint",),
    "report": ("plotly",),
    "ros": ("rclpy",),
}
"""Extras of the package, and the modules that each brings."""
_UNSAID: Final = logging.NullHandler()
"""Handler of what libraries log."""


def usage() -> str:
    """Return the help text."""
    verbs = (f"  {name:10} {summary}" for name, summary in VERBS.items())
    return "\n".join(
        [
            f"usage: {PROGRAM} VERB ...",
            "",
            "Torque-free rigid-body motion: live, recorded, certified.",
            "",
            *verbs,
            "",
            f"'{PROGRAM} VERB --help' explains one of them; '{PROGRAM} --version' tells the version and the extras.",
        ]
    )


def version() -> str:
    """Return the version, and which extras are installed."""
    extras = (
        f"  {name:10} "
        + ("installed" if all(map(find_spec, modules)) else f"not installed: pip install '{PROGRAM}[{name}]'")
        for name, modules in EXTRAS.items()
    )
    return "\n".join([f"{PROGRAM} {__version__}", "extras:", *extras])


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
    return console.status_of(PROGRAM, lambda: _main(arguments), to_the_end=argv is None)


def _main(arguments: list[str]) -> int:
    if not arguments:
        raise InputError(f"give a verb: {', '.join(VERBS)}; '{PROGRAM} --help' explains them")
    name, *rest = arguments
    if name in VERBS:
        return evaluate(rest) if name == "evaluate" else run(name, rest)
    if name not in ("-h", "--help", "--version"):
        raise InputError(f"unknown verb {name!r}; known are {', '.join(VERBS)}; see '{PROGRAM} --help'")
    console.say(version() if name == "--version" else usage())
    return console.SUCCESS


def run(name: str, argv: list[str]) -> int:
    """Import the verb and call it."""
    from lie_rigid_body.report.score_options import is_live

    live = name == "sim" or (name == "evaluate" and is_live(argv))
    if not live:  # a verb's own lines tell what went wrong, and what libraries log would stand between them
        logging.getLogger().addHandler(_UNSAID)
    verb: Callable[[list[str]], int] = import_module(f"lie_rigid_body.{'ros' if live else 'cli'}.{name}").main
    return verb(argv)


def evaluate(argv: Sequence[str] | None = None) -> int:
    """Run ``evaluate`` with the given arguments, or those of the process: live where no bag is given."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    return console.status_of(console.program("evaluate"), lambda: run("evaluate", arguments), to_the_end=argv is None)


if __name__ == "__main__":
    sys.exit(main())
