"""``check``: a bag held against the conservation laws, without ROS."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.cli.bag_progress import open_bag
from lie_rigid_body.errors import InputError, ParameterError

if TYPE_CHECKING:
    from lie_rigid_body.certificate import Certificate
    from lie_rigid_body.certificate.proved import Proof
    from lie_rigid_body.certificate.residuals_over_time import ResidualsOverTime
    from lie_rigid_body.certificate.segments import RecordedSegment
    from lie_rigid_body.recording.bag_reader import Bag

BROKEN: Final = 1


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    inertia = None if given.inertia is None else _inertia(given.inertia)

    from lie_rigid_body.certificate import certify
    from lie_rigid_body.certificate.proved import require_count
    from lie_rigid_body.certificate.residuals_over_time import ResidualsOverTime
    from lie_rigid_body.certificate.segments import thinned_segments
    from lie_rigid_body.cli import certificate_text, html_page, proof_text

    if given.prove is not None:
        require_count(given.prove)
    if given.report is not None:
        html_page.require_room(given.report, overwrite=given.force)
    residuals = None if given.report is None else ResidualsOverTime()
    with open_bag(given.bag, passes=3 if residuals is None else 5) as bag:
        certificate = certify(bag, inertia, residuals)
        pieces = thinned_segments(bag, inertia) if residuals is not None and certificate.segments else []
    proof = None if given.prove is None else _proof(bag, certificate, given.prove, inertia)
    proved = [] if proof is None else [proof_text.as_sentence(proof)]
    if residuals is not None:
        _write_page(given, certificate, residuals, pieces, proved)
    done = f"{given.report} is written" if given.report else ""
    if given.json:
        content = certificate_text.as_json(given.bag, certificate)
        content |= {} if proof is None else {"proved": proof_text.as_json(proof)}
        console.say(json.dumps(content, indent=2), done)
    else:
        wrote = [f"wrote {given.report}"] if given.report else []
        console.say("\n".join([certificate_text.as_table(given.bag, certificate), *proved, *wrote]), done)
    return console.SUCCESS if certificate.passed and (proof is None or proof.passed) else BROKEN


def _write_page(
    given: argparse.Namespace,
    certificate: Certificate,
    residuals: ResidualsOverTime,
    pieces: Sequence[RecordedSegment],
    proved: Sequence[str],
) -> None:
    import numpy as np

    from lie_rigid_body.cli.certificate_page import page
    from lie_rigid_body.recording.output_file import write_file

    with np.errstate(all="ignore"):  # recorded numbers may be anything
        content = page(given.bag, certificate, residuals, pieces, proved)
    write_file(given.report, content, overwrite=given.force)


def _proof(bag: Bag, certificate: Certificate, count: int, inertia: list[float] | None) -> Proof:
    from tqdm import tqdm

    from lie_rigid_body.certificate.proved import Proof, prove

    samples = prove(bag, certificate, count, inertia)
    return Proof(tuple(tqdm(samples, unit=" samples", file=sys.stderr, disable=None, leave=False)))


def _parser() -> console.Parser:
    parser = console.Parser("check", "Certify that a bag obeys the laws of torque-free motion, and how exactly.")
    parser.add_argument("bag", metavar="BAG", help="an MCAP file, or a folder that 'ros2 bag record' made")
    parser.add_argument("--json", action="store_true", help="print the certificate for programs")
    parser.add_argument(
        "--inertia",
        metavar="a,b,c",
        help="3 principal moments or 6 tensor entries to use in place of the declared ones",
    )
    parser.add_argument(
        "--prove",
        metavar="N",
        type=int,
        help="enclose the true motion at N samples spread over the bag, and at the worst ones, in ball arithmetic "
        "(needs python-flint)",
    )
    parser.add_argument(
        "--report", metavar="OUT.html", help="write laws, drifts and the motion in 3-D as one page (needs plotly)"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.html if it exists")
    return parser


def _inertia(text: str) -> list[float]:
    from lie_rigid_body.mechanics import RigidBody

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--inertia {text}: not numbers between commas; give for example --inertia 1,2,3") from None
    if len(numbers) not in (3, 6):
        raise InputError(f"--inertia {text}: {len(numbers)} numbers: give 3 principal moments or 6 tensor entries")
    try:
        RigidBody(numbers)
    except ParameterError as error:
        raise InputError(f"--inertia {text}: {error}") from None
    return numbers
