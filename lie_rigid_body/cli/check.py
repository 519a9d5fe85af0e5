"""``check``: a bag held against the conservation laws, without ROS."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Final

from lie_rigid_body import console
from lie_rigid_body.errors import InputError, ParameterError

BROKEN: Final = 1


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    inertia = None if given.inertia is None else _inertia(given.inertia)

    from lie_rigid_body.certificate import certify
    from lie_rigid_body.cli import certificate_text
    from lie_rigid_body.recording.bag_reader import read_bag

    certificate = certify(read_bag(given.bag), inertia)
    if given.json:
        console.say(json.dumps(certificate_text.as_json(given.bag, certificate), indent=2, ensure_ascii=False))
    else:
        console.say(certificate_text.as_table(given.bag, certificate))
    return console.SUCCESS if certificate.passed else BROKEN


def _parser() -> console.Parser:
    parser = console.Parser("check", "Certify that a bag obeys the laws of torque-free motion, and how exactly.")
    parser.add_argument("bag", metavar="BAG", help="an MCAP file, or a folder that 'ros2 bag record' made")
    parser.add_argument("--json", action="store_true", help="print the certificate for programs")
    parser.add_argument(
        "--inertia",
        metavar="a,b,c",
        help="3 principal moments or 6 tensor entries to use in place of the declared ones",
    )
    return parser


def _inertia(text: str) -> list[float]:
    from lie_rigid_body.mechanics import RigidBody

    try:
        numbers = [float(part) for part in text.split(",")]
        RigidBody(numbers)
    except ParameterError as error:
        raise InputError(f"--inertia {text}: {error}") from None
    except ValueError:
        raise InputError(f"--inertia {text}: not numbers between commas; give for example --inertia 1,2,3") from None
    return numbers
