"""HTML that a notebook shows of a result: its answer without pictures."""

from __future__ import annotations

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.evaluation.score import Score
from lie_rigid_body.inspection import Inspection
from lie_rigid_body.report import certificates, filters, inspections, scores
from lie_rigid_body.report.answer import Parts, Sentences, Table, as_html
from lie_rigid_body.runs import Run


def html(result: Score | Certificate | FilterDiagnosis | Inspection | Run) -> str:
    """HTML of a result."""
    match result:
        case Score():
            parts = scores.parts(None, result)
        case Certificate():
            parts = certificates.parts(result)
        case FilterDiagnosis():
            parts = filters.parts_of_diagnosis(result)
        case Inspection():
            parts = inspections.parts_of_inspection(result)
        case Run():
            parts = _of_run(result)
    return "".join(as_html(parts, pictures=False))


def _of_run(run: Run) -> Parts:
    """Time that a run covers, and the arrays that it has."""
    t_s = run.t_s
    span = f"{t_s[-1] - t_s[0]:.6g} s from {t_s[0]:.13g} s on" if len(t_s) else "nothing"
    rows = [("truth", str(len(run.t_ns)), "t_ns, attitude_xyzw, body_rate")] if run.truth else []
    for name, readings in run.sensors.items():
        arrays = ", ".join(array for array, values in vars(readings).items() if values is not None)
        rows.append((name, str(len(readings.t_ns)), arrays))
    return [Sentences([f"Run of {span}."]), Table(("", "samples", "arrays"), rows)]
