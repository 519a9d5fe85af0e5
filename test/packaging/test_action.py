"""The GitHub Action: its script runs verbs, and writes what they find into the summary; the workflow part is read."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from lie_rigid_body import simulate

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location("action", ROOT / "scripts" / "action.py")
assert _spec is not None
assert _spec.loader is not None
action: Any = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(action)


def test_a_score_is_compared_with_that_of_the_base_branch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    run = simulate(duration=5.0, rate=20.0)
    truth, near, far = (tmp_path / f"{name}.tum" for name in ("truth", "near", "far"))
    for path, angle in ((truth, 0.0), (near, 0.01), (far, 0.02)):
        turned = run.attitude().at(run.t_ns) + np.array([0.0, 0.0, angle / 2.0, 0.0])
        columns = [run.t_ns / 1e9, np.zeros((len(run.t_ns), 3)), turned]
        np.savetxt(path, np.column_stack(columns), fmt="%.9f")
    base, here = str(tmp_path / "base.json"), str(tmp_path / "here.json")
    given = [str(truth), "--max-rms", "0.8deg", "--estimate"]
    assert action.main("evaluate", base, "", *given, str(near)) == 0
    assert action.main("evaluate", here, base, *given, str(far)) == 1
    first, second = (tmp_path / "summary.md").read_text().split("### ")[1:]
    scores = [json.loads(Path(path).read_text())["total_deg"]["rms"] for path in (base, here)]
    assert f"| total error, RMS (deg) | {scores[0]:.4g} |\n" in first
    cells = [scores[1], scores[0]]
    row = f"| total error, RMS (deg) | {cells[0]:.4g} | {cells[1]:.4g} | {cells[0] - cells[1]:+.3g} |"
    assert row in second
    assert ": passed" in first
    assert ": failed" in second
    assert action.main("evaluate", here, base, str(truth), "--estimate", str(tmp_path / "none.tum")) == 2
    assert "no answer" in (tmp_path / "summary.md").read_text()
    capfd.readouterr()


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
