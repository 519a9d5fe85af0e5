"""``check``: bags held against the conservation laws, without ROS."""

from __future__ import annotations

from collections.abc import Sequence

from lie_rigid_body import console
from lie_rigid_body.errors import InputError, ParameterError


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    from lie_rigid_body.recording.bodies import topic_types

    topics = console.topic_names(given.topic, topic_types())
    inertia = None if given.inertia is None else _inertia(given.inertia)

    from lie_rigid_body.cli.checking import check

    return check(given, inertia, topics)


def _parser() -> console.Parser:
    return console.Parser(
        "check",
        "Certify that a bag obeys the laws of torque-free motion, and how exactly.",
        console.argument(
            "bags",
            metavar="BAG",
            type=console.path,
            nargs="+",
            help="an MCAP file, a folder that 'ros2 bag record' made, or a folder of such bags, also in folders "
            "below it",
        ),
        console.argument("--json", action="store_true", help="print the certificate for programs"),
        console.argument(
            "--inertia",
            metavar="a,b,c",
            help="3 principal moments or 6 tensor entries to use in place of the declared ones",
        ),
        console.TOPIC,
        console.argument(
            "--prove",
            metavar="N",
            type=int,
            help="enclose the true motion at N samples spread over the bag, and at the worst ones, in ball arithmetic "
            "(needs python-flint)",
        ),
        console.argument(
            "--report",
            metavar="OUT.html",
            type=console.path,
            help="write laws, drifts and the motion in 3-D as one page (needs plotly)",
        ),
        console.argument("--force", action="store_true", help="replace OUT.html if it exists"),
    )


def _inertia(text: str) -> list[float]:
    from lie_rigid_body.bounded_input import real
    from lie_rigid_body.mechanics import RigidBody

    try:
        numbers = [real(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--inertia {text}: not numbers between commas; give for example --inertia 1,2,3") from None
    if len(numbers) not in (3, 6):
        raise InputError(f"--inertia {text}: {len(numbers)} numbers: give 3 principal moments or 6 tensor entries")
    try:
        RigidBody(numbers)
    except ParameterError as error:
        raise InputError(f"--inertia {text}: {error}") from None
    return numbers
