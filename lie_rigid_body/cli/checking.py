"""The work of ``check``: the certificate of one bag, or the verdicts on many."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from lie_rigid_body import console
from lie_rigid_body.certificate import Certificate, certify
from lie_rigid_body.certificate.certification import passes
from lie_rigid_body.certificate.law_result import ResidualsOverTime
from lie_rigid_body.certificate.proved import Proof, prove, require_count
from lie_rigid_body.cli.bags import progress_bar, size
from lie_rigid_body.cli.judging import judge_all, judge_bodies
from lie_rigid_body.errors import InputError
from lie_rigid_body.recording.bag_files import bags_in, files_of, is_one_bag
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.samples import thinned_segments
from lie_rigid_body.report import certificate_text, html_page, overview
from lie_rigid_body.report.certificate_page import page
from lie_rigid_body.report.drawing import answer
from lie_rigid_body.wording import listed


def check(given: argparse.Namespace, inertia: list[float] | None, topics: Mapping[str, str]) -> int:
    """Certify what the arguments name, and return the exit status.

    Parameters
    ----------
    given : argparse.Namespace
    inertia : list of float or None
        To be used in place of the declared one, kg m².
    topics : mapping of str to str
        Topics that are called otherwise, by their relative names.
    """
    if given.report is not None:
        files = (file for bag in given.bags for file in files_of(bag))
        html_page.require_room(given.report, files, overwrite=given.force)
    if len(given.bags) == 1 and not is_folder_of_bags(given.bags[0]):
        return _check_one(given, inertia, topics)
    _refuse_proof(given)
    return _answer(given, judge_all(bags_of(given.bags), inertia, topics))


def is_folder_of_bags(name: str) -> bool:
    """Whether an argument is a folder that is not one bag itself."""
    return Path(name).is_dir() and not is_one_bag(Path(name))


def bags_of(names: Sequence[str]) -> list[str]:
    """Bags that the arguments name, each once; folders of bags are searched."""
    found: dict[Path, str] = {}
    for name in names:
        for bag in bags_in(Path(name)) if is_folder_of_bags(name) else [name]:
            found.setdefault(Path(bag).resolve(), str(bag))
    return list(found.values())


def _check_one(given: argparse.Namespace, inertia: list[float] | None, topics: Mapping[str, str]) -> int:
    """Certify each body of the only bag."""
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
    with np.errstate(all="ignore"):  # recorded numbers may be anything
        files = {} if residuals is None else {given.report: page(name, certificate, residuals, pieces, proof)}
    data = certificate_text.as_json(name, certificate, proof)
    text = json.dumps(data, indent=2) if given.json else certificate_text.as_table(name, certificate, proof)
    answer(text, files, overwrite=given.force, named=not given.json)
    return console.SUCCESS if certificate.passed and (proof is None or proof.passed) else console.BROKEN


def _answer(given: argparse.Namespace, verdicts: Sequence[overview.Verdict]) -> int:
    """Answer with a table, and the largest exit status that one of the verdicts alone would have."""
    for verdict in verdicts:
        if verdict.reason:
            console.complain(console.program("check"), verdict.reason)
    has_page = given.report is not None and any(verdict.certificate for verdict in verdicts)
    content = overview.page_of_verdicts(f"Certificates of {listed(given.bags)}", verdicts) if has_page else b""
    text = json.dumps(overview.as_json(verdicts), indent=2) if given.json else overview.as_table(verdicts)
    answer(text, {given.report: content} if has_page else {}, overwrite=given.force, named=not given.json)
    return max(verdict.status for verdict in verdicts)


def _refuse_proof(given: argparse.Namespace) -> None:
    if given.prove is not None:
        raise InputError(
            f"--prove {given.prove}: more than one body: give one bag, and of several bodies one by --topic pose:=/NAME"
        )


def _proof(bag: Bag, certificate: Certificate, count: int, inertia: list[float] | None) -> Proof:
    return Proof(tuple(console.progress(prove(bag, certificate, count, inertia), unit=" samples")))
