"""What a notebook shows of a result: its sentence, and tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import singledispatch
from html import escape

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.score import verdict
from lie_rigid_body.report import certificates, diagnoses, html_page, scores
from lie_rigid_body.runs import Run


@singledispatch
def html(result: object) -> str:
    """HTML of a result that tells what a person wants to know first, without a picture."""
    raise NotImplementedError


@html.register
def _(score: Score) -> str:
    found = [f"{finding.code}: {finding.message}" for finding in score.findings]
    return _shown([*verdict(score), scores.summary(score), *found], scores.tables(score))


@html.register
def _(certificate: Certificate) -> str:
    return _shown(
        [certificates.verdict(certificate)], [certificates.law_table((law, None) for law in certificate.laws)]
    )


@html.register
def _(found: FilterDiagnosis) -> str:
    probes = [((p.code, "passed" if p.passed else "FAILED", p.message), p.passed) for p in found.probes]
    return _shown(found.sentences, [diagnoses.mistakes(found), html_page.table(("probe", "", ""), probes)])


@html.register
def _(run: Run) -> str:
    rows = [("truth", str(len(run.t_ns)), "t_ns, attitude_xyzw, body_rate")] if run.truth else []
    for name, readings in run.sensors.items():
        told = [array for array, values in vars(readings).items() if values is not None]
        rows.append((name, str(len(readings.t_ns)), ", ".join(told)))
    span = f"{run.t_s[-1] - run.t_s[0]:.6g} s from {run.t_s[0]:.13g} s on" if len(run.t_ns) else "nothing"
    return _shown([f"Run of {span}"], [html_page.table(("", "samples", "arrays"), [(row, True) for row in rows])])


def _shown(sentences: Sequence[str], parts: Iterable[str]) -> str:
    """Sentences, the first in bold, above parts."""
    first, *others = (escape(sentence) for sentence in sentences)
    return "".join([f"<p><strong>{first}</strong></p>", *(f"<p>{text}</p>" for text in others), *parts])
