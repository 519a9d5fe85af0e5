"""The work of ``check``: the certificate of one bag, or the verdicts on many, found by parallel processes."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from threading import TIMEOUT_MAX
from typing import Final, TypeAlias

from lie_rigid_body.certificate.certification import Certificate, certify
from lie_rigid_body.certificate.proved import Proof, prove, require_count
from lie_rigid_body.command_line import topic_names
from lie_rigid_body.evaluation.statistics import in_unit
from lie_rigid_body.foundation.errors import BagError, InputError, LieRigidBodyError, ParameterError
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.mechanics import RigidBody
from lie_rigid_body.recording.bag_files import bags_in, files_of, is_one_bag
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.topic_discovery import TOPIC_TYPES
from lie_rigid_body.report import certificates
from lie_rigid_body.report.outputs import emit, require_outputs
from lie_rigid_body.report.overview import Verdict, Verdicts, as_json, as_table, page_of_verdicts
from lie_rigid_body.report.recorded_motion import ResidualsOverTime, recorded_segments
from lie_rigid_body.system import console
from lie_rigid_body.system.bounded_input import real
from lie_rigid_body.system.interpreters import Interpreter, Interpreters
from lie_rigid_body.system.portable import cores, real_path

_KILLED: Final = "the process that read it was killed, perhaps for its memory: free some, and check it alone"

Judged: TypeAlias = Callable[[Bag], Certificate]
"""A function that makes the certificate of a bag."""


def check(given: argparse.Namespace) -> int:
    """Certify what the arguments name, and return the exit status."""
    topics = topic_names(given.topic, TOPIC_TYPES)
    inertia = None if given.inertia is None else _inertia(given.inertia)
    max_attitude = None if given.max_attitude is None else _angle(given.max_attitude)
    judged = partial(certify, inertia=inertia, max_attitude=max_attitude)
    files = (file for bag in given.bags for file in files_of(bag))
    is_one = len(given.bags) == 1 and not _is_folder_of_bags(given.bags[0])
    require_outputs(given, files, "json", "report", with_film=is_one)
    if not is_one:
        _refuse_proof(given)
        return _answer(given, judge_all(_bags_of(given.bags), judged, topics))
    if given.prove is not None:
        require_count(given.prove)
    name = given.bags[0]
    residuals = ResidualsOverTime()
    with console.progress_of_bags(given.bags) as bar:
        bodies = Bag.all_of(name, bar.update, topics)
        first, *others = bodies.values()
        if others or isinstance(first, BagError):
            _refuse_proof(given)
            bar.total = console.bytes_of(name) * (1 + sum(isinstance(body, Bag) for body in bodies.values()))
            verdicts = judge_bodies(name, bodies, judged)
            bar.close()
            return _answer(given, verdicts)
        bar.total = console.bytes_of(name) * (2 + bool(given.report))
        certificate = judged(first, watch=residuals)
        pieces = recorded_segments(first, certificate) if given.report and certificate.segments else []
    proof = None
    if given.prove is not None:
        proved = prove(first, certificate, given.prove, max_attitude)
        proof = Proof(tuple(console.progress(proved, unit=" samples")))
    return emit(
        given,
        {given.report: lambda: certificates.page(name, certificate, residuals, pieces, proof)},
        lambda: certificates.as_table(name, certificate, proof),
        lambda: certificates.as_json(name, certificate, proof),
        passed=certificate.passed and (proof is None or proof.passed),
    )


def _inertia(text: str) -> list[float]:
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


def _angle(text: str) -> float:
    """The angle, rad, that an option gives."""
    try:
        return math.radians(in_unit(text, "an angle such as 1deg"))
    except InputError as error:
        raise InputError(f"--max-attitude: {error}") from None


def _is_folder_of_bags(name: str) -> bool:
    """Whether an argument is a folder that is not one bag itself."""
    return Path(name).is_dir() and not is_one_bag(Path(name))


def _bags_of(names: Sequence[str]) -> list[str]:
    """Bags that the arguments name, each once; folders of bags are searched."""
    found: dict[Path, str] = {}
    for name in names:
        for bag in bags_in(Path(name)) if _is_folder_of_bags(name) else [name]:
            found.setdefault(real_path(Path(bag)), str(bag))
    return list(found.values())


def _refuse_proof(given: argparse.Namespace) -> None:
    if given.prove is not None:
        raise InputError(
            f"--prove {given.prove}: more than one body: give one bag, and of several bodies one by --topic pose:=/NAME"
        )


def _answer(given: argparse.Namespace, verdicts: Verdicts) -> int:
    """Answer with a table, and the largest exit status that one of the verdicts alone would have."""
    for verdict in verdicts:
        if verdict.reason:
            console.complain(console.program("check"), verdict.reason)
    path = given.report if any(verdict.certificate for verdict in verdicts) else None
    emit(
        given,
        {path: lambda: page_of_verdicts(f"Certificates of {listed(given.bags)}", verdicts)},
        lambda: as_table(verdicts),
        lambda: as_json(verdicts),
    )
    return max(verdict.status for verdict in verdicts)


def judge_all(bags: Sequence[str], judged: Judged = certify, topics: Mapping[str, str] | None = None) -> list[Verdict]:
    """Judge bags by as many processes as there are cores; the verdicts come in the order of the bags.

    Parameters
    ----------
    bags : sequence of str
    judged : callable, optional
        Makes the certificate of a bag.
    topics : mapping of str to str, optional
        Topics that are called otherwise, by their relative names.
    """

    def asked(interpreter: Interpreter, bag: str) -> list[Verdict]:
        try:
            return interpreter.ask(partial(judge, judged, topics or {}, bag), TIMEOUT_MAX)  # type: ignore[no-any-return]
        except EOFError:
            return [Verdict(bag, None, None, f"{bag}: {_KILLED}")]

    with closing(Interpreters(min(cores(), len(bags)))) as pool:
        found = console.progress(pool.map(asked, bags), total=len(bags), unit=" bags")
        return [verdict for verdicts in found for verdict in verdicts]


def judge(judged: Judged, topics: Mapping[str, str], bag: str) -> list[Verdict]:
    """Judge all bodies of a bag; whatever is wrong with the bag is its verdict."""
    try:
        return judge_bodies(bag, Bag.all_of(bag, lambda count: None, topics), judged)
    except Exception as error:
        return [_unusable(bag, None, error)]


def judge_bodies(bag: str, bodies: Mapping[str, Bag | BagError], judged: Judged) -> list[Verdict]:
    """Judge the bodies of a bag, as `Bag.all_of` finds them; what is wrong with one is its verdict."""
    return [_of_body(bag, name if len(bodies) > 1 else None, found, judged) for name, found in bodies.items()]


def _of_body(bag: str, body: str | None, found: Bag | BagError, judged: Judged) -> Verdict:
    try:
        if isinstance(found, BagError):
            raise found
        return Verdict(bag, body, judged(found))
    except Exception as error:
        return _unusable(bag, body, error)


def _unusable(bag: str, body: str | None, error: Exception) -> Verdict:
    console.trace()
    reason = console.explanation(error)
    return Verdict(bag, body, None, reason if isinstance(error, LieRigidBodyError) else f"{bag}: {reason}")
