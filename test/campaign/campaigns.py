"""What the tests of campaigns share: campaigns of six short runs, and what is read of their folders."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.campaign.journal import RESUMED
from lie_rigid_body.foundation.errors import BagError, InputError
from said import refusals

# not loaded here: the process that only collects these tests does without
NEEDS_DASK = pytest.mark.skipif(
    not all(map(find_spec, ("cryptography", "distributed", "pyarrow"))),
    reason="cryptography, distributed or pyarrow is not installed",
)
CAMPAIGN = """
runs: 6
seed: 7
duration: 0.25
scenario: tumbling_cubesat
parameters: {rate: 100.0, imu_rate: 100.0}
vary:
  initial_attitude_xyzw: {distribution: uniform_rotation}
  initial_body_rate: {distribution: direction, norm: {distribution: uniform, low: 0.01, high: 0.5}}
  inertia: {distribution: box, mass: 8.0, edges: [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]}
  gyro_noise_density: {distribution: loguniform, low: 1e-5, high: 1.0e-3}
  motion: {distribution: choice, values: [moving_chart, closed_form]}
  sensor_seed: {distribution: run}
"""
ESTIMATED = CAMPAIGN + "estimator: estimator_of_a_campaign:from_truth\n"
ESTIMATOR = """
def from_truth(run):
    if dict(run.scenario.sensor_parameters)["sensor_seed"] == 2:
        raise RuntimeError("it is lost")
    return run.truth.attitude_xyzw
"""
SCORES = ["total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s"]


def written(folder: Path, text: str = ESTIMATED) -> Path:
    path = folder / "campaign.yaml"
    path.write_text(text)
    return path


def table_of(out: Path) -> Any:
    from pyarrow import parquet

    return parquet.read_table(out / "runs.parquet")


def bytes_of(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((out / "bags").iterdir())}


def finished(out: Path) -> list[int]:
    journal = out / "runs.jsonl"
    lines = journal.read_text().split("\n")[1:-1] if journal.exists() else []
    return [json.loads(line)["run"] for line in lines]


refused = refusals(
    {
        BagError: {
            "not written": f"cannot be written: {{why}}: .*{RESUMED}",
            "not read": "runs.jsonl cannot be read: {why}",
            "no file": "runs.jsonl is no regular file: move it away, or give another folder",
            "moved": "was deleted or moved meanwhile",
            "another user": "another user's",
            "no row": "byte [0-9]+ begins no row of this campaign",
            "changed bags": rf"{{count}} of {{of}} bags were deleted or changed meanwhile \({{which}}\): .*{RESUMED}",
        },
        InputError: {"distribution": "^{name}", "another campaign": "holds the runs of another campaign or version"},
    }
)
"""Errors that other tests name."""
WITHOUT_A_WORKER = "no worker at {address}: waiting for one; Ctrl-C ends it"
"""What is said while a scheduler has none."""
