"""``check``: bags held against the conservation laws, without ROS."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lie_rigid_body import console
from lie_rigid_body.cli.bags import bags_of, is_folder_of_bags, progress_bar, size
from lie_rigid_body.errors import InputError, ParameterError
from lie_rigid_body.wording import listed, printable

if TYPE_CHECKING:
    from lie_rigid_body.certificate import Certificate
    from lie_rigid_body.certificate.proved import Proof
    from lie_rigid_body.recording.bag_reader import Bag
    from lie_rigid_body.report.overview import Verdict


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    from lie_rigid_body.recording.bodies import TYPES

    topics = console.topic_names(given.topic, TYPES)
    inertia = None if given.inertia is None else _inertia(given.inertia)
    if given.report is not None:
        from lie_rigid_body.recording.bag_folders import files_of
        from lie_rigid_body.report import html_page

        files = (file for bag in given.bags for file in files_of(bag))
        html_page.require_room(given.report, files, overwrite=given.force)
    if len(given.bags) == 1 and not is_folder_of_bags(given.bags[0]):
        return _check_one(given, inertia, topics)
    from lie_rigid_body.cli.judging import judge_all

    _refuse_proof(given)
    return _answer(given, judge_all(bags_of(given.bags), inertia, topics))


def _check_one(given: argparse.Namespace, inertia: list[float] | None, topics: Mapping[str, str]) -> int:
    """Certify each body of the only bag."""
    from lie_rigid_body.certificate import certify
    from lie_rigid_body.certificate.certification import passes
    from lie_rigid_body.certificate.proved import require_count
    from lie_rigid_body.certificate.residuals_over_time import ResidualsOverTime
    from lie_rigid_body.certificate.segments import thinned_segments
    from lie_rigid_body.cli.judging import judge_bodies
    from lie_rigid_body.recording.bag_reader import Bag

    if given.prove is not None:
        require_count(given.prove)
    name, residuals = given.bags[0], None if given.report is None else ResidualsOverTime()
    with progress_bar(given.bags) as bar:
        bodies = Bag.all_of(name, bar.update, topics)
        whole = [body for body in bodies.values() if isinstance(body, Bag)]
        if len(bodies) > 1:
            _refuse_proof(given)
            bar.total = size(name) * (1 + sum(passes(body) for body in whole))
            verdicts = judge_bodies(name, bodies, inertia)
        else:
            bar.total = size(name) * (1 + passes(whole[0], residuals) + 2 * (residuals is not None))
            certificate = certify(whole[0], inertia, residuals)
            has_samples = residuals is not None and certificate.segments
            pieces = thinned_segments(whole[0], inertia) if has_samples else []
    if len(bodies) > 1:
        return _answer(given, verdicts)
    proof = None if given.prove is None else _proof(whole[0], certificate, given.prove, inertia)
    if residuals is not None:
        import numpy as np

        from lie_rigid_body.report.certificate_page import page

        with np.errstate(all="ignore"):  # recorded numbers may be anything
            _write_page(given, page(name, certificate, residuals, pieces, proof))
    from lie_rigid_body.report import certificate_text

    if given.json:
        _say(given, json.dumps(certificate_text.as_json(name, certificate, proof), indent=2), written=True)
    else:
        _say(given, certificate_text.as_table(name, certificate, proof), written=True)
    return console.SUCCESS if certificate.passed and (proof is None or proof.passed) else console.BROKEN


def _answer(given: argparse.Namespace, verdicts: Sequence[Verdict]) -> int:
    """Answer with a table, and the largest exit status that one of the verdicts alone would have."""
    from lie_rigid_body.report import overview

    for verdict in verdicts:
        if verdict.reason:
            console.complain(console.program("check"), verdict.reason)
    written = given.report is not None and any(verdict.certificate for verdict in verdicts)
    if written:
        from lie_rigid_body.report.overview_page import verdicts_page

        _write_page(given, verdicts_page(f"Certificates of {listed(given.bags)}", verdicts))
    text = json.dumps(overview.as_json(verdicts), indent=2) if given.json else overview.as_table(verdicts)
    _say(given, text, written=written)
    return max(verdict.status for verdict in verdicts)


def _write_page(given: argparse.Namespace, content: bytes) -> None:
    from lie_rigid_body.recording.output_file import write_file

    write_file(given.report, content, overwrite=given.force)


def _say(given: argparse.Namespace, text: str, *, written: bool) -> None:
    """Print the answer, and the name of the page where one was written."""
    written = written and given.report is not None
    wrote = f"\nwrote {printable(given.report)}" if written and not given.json else ""
    console.say(text + wrote, done=f"{given.report} is written" if written else "")


def _refuse_proof(given: argparse.Namespace) -> None:
    if given.prove is not None:
        raise InputError(
            f"--prove {given.prove}: more than one body: give one bag, and of several bodies one by --topic pose:=/NAME"
        )


def _proof(bag: Bag, certificate: Certificate, count: int, inertia: list[float] | None) -> Proof:
    from tqdm import tqdm

    from lie_rigid_body.certificate.proved import Proof, prove

    samples = prove(bag, certificate, count, inertia)
    return Proof(tuple(tqdm(samples, unit=" samples", file=sys.stderr, disable=None, leave=False)))


def _parser() -> console.Parser:
    parser = console.Parser("check", "Certify that a bag obeys the laws of torque-free motion, and how exactly.")
    parser.add_argument(
        "bags",
        metavar="BAG",
        type=console.path,
        nargs="+",
        help="an MCAP file, a folder that 'ros2 bag record' made, or a folder of such bags, also in folders below it",
    )
    parser.add_argument("--json", action="store_true", help="print the certificate for programs")
    parser.add_argument(
        "--inertia",
        metavar="a,b,c",
        help="3 principal moments or 6 tensor entries to use in place of the declared ones",
    )
    console.add_topic_argument(parser)
    parser.add_argument(
        "--prove",
        metavar="N",
        type=int,
        help="enclose the true motion at N samples spread over the bag, and at the worst ones, in ball arithmetic "
        "(needs python-flint)",
    )
    parser.add_argument(
        "--report",
        metavar="OUT.html",
        type=console.path,
        help="write laws, drifts and the motion in 3-D as one page (needs plotly)",
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
