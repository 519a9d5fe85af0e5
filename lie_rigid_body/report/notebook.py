"""What a notebook shows of a result: its sentence, and tables."""

from __future__ import annotations

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.evaluation.score import Score, verdict
from lie_rigid_body.report import certificates, filters, html_page, scores
from lie_rigid_body.report.html_page import escaped
from lie_rigid_body.runs import Run


def html(result: Score | Certificate | FilterDiagnosis | Run) -> str:
    """HTML of a result that tells what a person wants to know first, without a picture."""
    match result:
        case Score():
            found = [f"{finding.code}: {finding.message}" for finding in result.findings]
            sentences, parts = [*verdict(result), scores.summary(result), *found], scores.tables(result)
        case Certificate():
            sentences, parts = (
                [certificates.verdict(result)],
                [certificates.law_table((law, None) for law in result.laws)],
            )
        case FilterDiagnosis():
            probes = [((p.code, "passed" if p.passed else "FAILED", p.message), p.passed) for p in result.probes]
            sentences, parts = (
                result.sentences,
                [filters.mistakes(result), html_page.table(("probe", "", ""), probes)],
            )
        case Run(t_s=t_s):
            span = f"{t_s[-1] - t_s[0]:.6g} s from {t_s[0]:.13g} s on" if len(t_s) else "nothing"
            sentences, parts = [f"Run of {span}"], [_arrays(result)]
    first, *others = map(escaped, sentences)
    return "".join([f"<p><strong>{first}</strong></p>", *(f"<p>{text}</p>" for text in others), *parts])


def _arrays(run: Run) -> str:
    """Table of the arrays of a run."""
    rows = [("truth", str(len(run.t_ns)), "t_ns, attitude_xyzw, body_rate")] if run.truth else []
    rows += [
        (
            name,
            str(len(readings.t_ns)),
            ", ".join(array for array, values in vars(readings).items() if values is not None),
        )
        for name, readings in run.sensors.items()
    ]
    return html_page.table(("", "samples", "arrays"), [(row, True) for row in rows])
