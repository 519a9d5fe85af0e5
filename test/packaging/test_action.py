"""The GitHub Action: its script runs verbs, and writes what they find into the summary; the workflow part is read."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from lie_rigid_body import simulate

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("total", "heading", "inclination")
_spec = importlib.util.spec_from_file_location("action", ROOT / "scripts" / "action.py")
assert _spec is not None
assert _spec.loader is not None
action: Any = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(action)


STEP = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))["runs"]["steps"][1]


@pytest.fixture
def summary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "summary.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(path))
    return path


def test_a_score_is_compared_with_that_of_the_base_branch(tmp_path: Path, summary: Path) -> None:
    """By the line of action.yml itself, with a file whose name has a space."""
    run = simulate(duration=5.0, rate=20.0)
    truth, near, far = (tmp_path / f"{name}.tum" for name in ("the truth", "near", "far"))
    for path, angle in ((truth, 0.0), (near, 0.01), (far, 0.02)):
        turned = run.attitude().at(run.t_ns) + np.array([0.0, 0.0, angle / 2.0, 0.0])
        columns = [run.t_ns / 1e9, np.zeros((len(run.t_ns), 3)), turned]
        np.savetxt(path, np.column_stack(columns), fmt="%.9f")
    base, here = tmp_path / "base.json", tmp_path / "here.json"

    def status(answer: Path, base: Path | str, estimate: Path) -> int:
        given = {
            "VERB": "evaluate",
            "ANSWER": str(answer),
            "BASE": str(base),
            "ARGUMENTS": f"'{truth}' --max-rms 0.8deg --estimate {estimate}",
            "GITHUB_ACTION_PATH": str(ROOT),
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        }
        return subprocess.run(["bash", "-c", STEP["run"]], env={**os.environ, **given}, check=False).returncode

    assert status(base, "", near) == 0
    assert status(here, base, far) == 1
    first, second = summary.read_text().split("### ")[1:]
    scores = [json.loads(path.read_text())["total_deg"]["rms"] for path in (base, here)]
    assert f"| total error, RMS (deg) | {scores[0]:.4g} |\n" in first
    cells = [scores[1], scores[0]]
    row = f"| total error, RMS (deg) | {cells[0]:.4g} | {cells[1]:.4g} | {cells[0] - cells[1]:+.3g} |"
    assert row in second
    assert ": passed" in first
    assert ": failed" in second
    assert status(here, base, tmp_path / "none.tum") == 2
    third = summary.read_text().split("### ")[3]
    assert ": no answer" in third
    assert "none.tum" in third.partition("```text")[2]


@pytest.mark.parametrize(
    "base", ["{}", "[]", "3", "garbage", "\xff", '{"mistakes": [], "probes": []}', '{"estimates": [{}]}', '{"rows": 1}']
)
def test_what_is_no_answer_of_the_verb_is_no_base(
    tmp_path: Path, summary: Path, monkeypatch: pytest.MonkeyPatch, base: str
) -> None:
    content = {"topic": "a", "findings": [], **{f"{kind}_deg": {"rms": 1.5} for kind in KINDS}}
    (tmp_path / "base.json").write_bytes(base.encode("latin-1"))

    def run(verb: str, answer: str, arguments: str) -> tuple[int, str, str]:
        Path(answer).write_text(json.dumps(content))
        return 0, "", ""

    monkeypatch.setattr(action, "run", run)
    assert action.main("evaluate", str(tmp_path / "here.json"), str(tmp_path / "base.json"), "x") == 0
    assert "Base not readable" in summary.read_text()
    assert "| total error, RMS (deg) | 1.5 |" in summary.read_text()


def test_where_there_is_no_answer_the_reason_is_in_the_summary(
    tmp_path: Path, summary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = tmp_path / "here.json"
    assert action.main("league", str(answer), "", "'my filter") == 2
    assert "No closing quotation" in summary.read_text()
    killed = tmp_path / "killed"
    killed.write_text("#!/bin/sh\nkill -9 $$\n")
    killed.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(killed))
    answer.write_text(json.dumps({"rows": []}))  # of a step before
    assert action.main("league", str(answer), "", "") == 128 + 9
    assert "signal 9" in summary.read_text().split("### ")[2]
    killed.write_text("#!/bin/sh\necho 'no module' >&2\nexit 1\n")
    assert action.main("league", str(answer), "", "") == 1
    third = summary.read_text().split("### ")[3]
    assert ": no answer" in third
    assert "no module" in third


def test_answers_of_the_other_verbs_have_their_tables() -> None:
    diagnosis = {"mistakes": [{"code": "gyro_units"}], "probes": [{"code": "follows", "passed": False}]}
    now = dict(action.of_diagnosis(diagnosis))
    assert now == {"mistakes": "gyro_units", "probe follows": "failed"}
    before = {"mistakes": "none", "probe follows": "failed", "probe slow": "passed"}
    assert action.table(now, before)[2:] == [
        "| mistakes | gyro_units | none | changed |",
        "| probe follows | failed | failed |  |",
        "| probe slow | | passed | gone |",
    ]
    rows = {"rows": [{"name": "mine", "overall": 1.25, "rank": 7}]}
    assert dict(action.of_rows(rows)) == {"mine: overall (deg)": 1.25, "mine: rank": 7}


def test_the_league_prints_what_the_action_reads(tmp_path: Path) -> None:
    from lie_rigid_body.cli.league import main

    assert main(["--json", str(tmp_path / "league.json")]) == 0
    assert len(action.numbers("league", tmp_path / "league.json")) > 20


def test_its_inputs_are_those_of_the_script_and_of_the_page() -> None:
    described = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
    page = (ROOT / "docs" / "how-to" / "action.md").read_text(encoding="utf-8")
    assert [name for name in described["inputs"] if f"`{name}`" not in page] == []
    [_, step] = described["runs"]["steps"]
    assert set(step["env"].values()) == {f"${{{{ inputs.{name} }}}}" for name in described["inputs"]}
    assert "scripts/action.py" in step["run"]
