"""The mode ``cases`` of the benchmark of diagnoses: which functions it takes, and how it judges what is named."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import diagnosis
from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Note, Probe


def found(*codes: str, or_else: tuple[str, ...] = (), failed: str = "", note: str = "") -> FilterDiagnosis:
    mistakes = tuple(Mistake(code, "", "", 90.0, 0.0, or_else) for code in codes)
    probes = (Probe(failed, False, "", 1.0),) * bool(failed)
    notes = (Note(note, "", 0.0),) * bool(note)
    return FilterDiagnosis(mistakes, probes, notes, 1, 90.0, 0.1)


@pytest.mark.parametrize(
    ("said", "expected", "verdict"),
    [
        (found(), [], "right"),
        (found(failed="converges"), [], "right"),
        (found("gyro_axes"), [], "wrong"),
        (found("gyro_axes"), ["gyro_axes"], "right"),
        (found("gyro_axes", "ned_world"), ["gyro_axes"], "wrong"),
        (found("gyro_axes", or_else=("body_axes",)), ["body_axes"], "or_else"),
        (found("gyro_axes", or_else=("time_step",)), ["body_axes"], "wrong"),
        (found(), ["gyro_axes"], "nothing"),
        (found(failed="follows"), ["gyro_axes"], "symptom"),
        (found(failed="slow"), ["slow"], "right"),
        (found(note="first_attitude"), ["first_attitude"], "right"),
    ],
)
def test_a_case_is_judged_by_what_is_named(said: FilterDiagnosis, expected: list[str], verdict: str) -> None:
    assert diagnosis.verdict(said, expected) == verdict


def test_cases_are_public_functions_of_a_run_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setenv("PYTHONPATH", "")
    (tmp_path / "filters_here.py").write_text(
        "from math import sin\n"
        "def right(run): ...\n"
        "def with_gain(run, gain=1.0): ...\n"
        "def _own(run): ...\n"
        "def helper(run, gain): ...\n"
        "def angle(x): ...\n",
        encoding="utf-8",
    )
    assert diagnosis.functions_of(tmp_path) == ["filters_here:right", "filters_here:with_gain"]
