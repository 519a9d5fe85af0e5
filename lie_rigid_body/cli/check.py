"""``check``: a bag held against the conservation laws, without ROS."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lie_rigid_body import console
from lie_rigid_body.cli.bags import bags_of, is_folder_of_bags, progress_bar, size
from lie_rigid_body.cli.judgement import Judgement, judge_all, judge_bodies
from lie_rigid_body.errors import InputError, ParameterError
from lie_rigid_body.wording import listed, printable

if TYPE_CHECKING:
    from lie_rigid_body.certificate import Certificate
    from lie_rigid_body.certificate.proved import Proof
    from lie_rigid_body.certificate.residuals_over_time import ResidualsOverTime
    from lie_rigid_body.recording.bag_reader import Bag
    from lie_rigid_body.recording.samples import RecordedSegment


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    from lie_rigid_body.recording.bodies import topic_types

    topics = console.topic_names(given.topic, topic_types())
    inertia = None if given.inertia is None else _inertia(given.inertia)
    if given.report is not None:
        from lie_rigid_body.recording.bag_folders import files_of
        from lie_rigid_body.report import html_page

        files = (file for bag in given.bags for file in files_of(bag))
        html_page.require_room(given.report, files, overwrite=given.force)
    if len(given.bags) > 1 or is_folder_of_bags(given.bags[0]):
        return _several(given, inertia, topics)

    from lie_rigid_body.certificate import certify
    from lie_rigid_body.certificate.certification import passes
    from lie_rigid_body.certificate.proved import require_count
    from lie_rigid_body.certificate.residuals_over_time import ResidualsOverTime
    from lie_rigid_body.recording.bag_reader import Bag
    from lie_rigid_body.recording.samples import thinned_segments

    if given.prove is not None:
        require_count(given.prove)
    residuals = None if given.report is None else ResidualsOverTime()
    with progress_bar(given.bags) as bar:
        bodies = Bag.all_of(given.bags[0], bar.update, topics)
        whole = [body for body in bodies.values() if isinstance(body, Bag)]
        alone = len(bodies) == 1
        watch = residuals if alone else None
        of_the_page = 0 if watch is None else 2
        bar.total = size(given.bags[0]) * (1 + sum(passes(body, watch) for body in whole) + of_the_page)
        if alone:
            certificate = certify(whole[0], inertia, watch)
            pieces = thinned_segments(whole[0], inertia) if watch is not None and certificate.segments else []
        else:
            _refuse_proof(given)
            judgements = judge_bodies(given.bags[0], bodies, inertia)
    return _one(given, whole[0], certificate, inertia, residuals, pieces) if alone else _answer(given, judgements)


def _one(
    given: argparse.Namespace,
    bag: Bag,
    certificate: Certificate,
    inertia: list[float] | None,
    residuals: ResidualsOverTime | None,
    pieces: Sequence[RecordedSegment],
) -> int:
    """Answer with the certificate of the only body of the only bag."""
    from lie_rigid_body.cli import certificate_text, proof_text

    name = given.bags[0]
    proof = None if given.prove is None else _proof(bag, certificate, given.prove, inertia)
    proved = [] if proof is None else [proof_text.as_sentence(proof)]
    if residuals is not None:
        _write_page(given, certificate, residuals, pieces, proved)
    done = f"{given.report} is written" if given.report else ""
    if given.json:
        content = certificate_text.as_json(name, certificate)
        content |= {} if proof is None else {"proved": proof_text.as_json(proof)}
        console.say(json.dumps(content, indent=2), done)
    else:
        wrote = [f"wrote {printable(given.report)}"] if given.report else []
        console.say("\n".join([certificate_text.as_table(name, certificate), *proved, *wrote]), done)
    return console.SUCCESS if certificate.passed and (proof is None or proof.passed) else console.BROKEN


def _several(given: argparse.Namespace, inertia: list[float] | None, topics: Mapping[str, str]) -> int:
    """Judge all bags, also those in folders, whatever is wrong with one of them."""
    _refuse_proof(given)
    return _answer(given, judge_all(bags_of(given.bags), inertia, topics))


def _answer(given: argparse.Namespace, judgements: Sequence[Judgement]) -> int:
    """Answer with a table, and the largest exit status that one of them alone would have."""
    from lie_rigid_body.cli import judgements_text

    for judgement in judgements:
        if judgement.reason:
            console.complain(console.program("check"), judgement.reason)
    text = judgements_text.as_table(judgements)
    wrote = _write_overview(given, judgements)
    done = f"{given.report} is written" if wrote else ""
    console.say(json.dumps(judgements_text.as_json(judgements), indent=2) if given.json else text + wrote, done)
    return max(judgement.status for judgement in judgements)


def _write_overview(given: argparse.Namespace, judgements: Sequence[Judgement]) -> str:
    """Write the page of several certificates, if it is asked for and there are any; the line that says so."""
    certificates = [(judgement.name, judgement.certificate) for judgement in judgements if judgement.certificate]
    if given.report is None or not certificates:
        return ""
    from lie_rigid_body.cli.judgements_text import kind_of, uncovered
    from lie_rigid_body.cli.overview_page import certificates_page
    from lie_rigid_body.recording.output_file import write_file

    reasons = [judgement.reason for judgement in judgements if judgement.reason]
    title, what = f"Certificates of {listed(given.bags)}", kind_of(judgements)
    content = certificates_page(title, certificates, reasons, uncovered(judgements), what)
    write_file(given.report, content, overwrite=given.force)
    return f"\nwrote {printable(given.report)}"


def _refuse_proof(given: argparse.Namespace) -> None:
    if given.prove is not None:
        raise InputError(
            f"--prove {given.prove}: more than one body: give one bag, and of several bodies one by --topic pose:=/NAME"
        )


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
        content = page(given.bags[0], certificate, residuals, pieces, proved)
    write_file(given.report, content, overwrite=given.force)


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
