"""What the tests of campaigns share: campaigns of six short runs, and what is read of their folders."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

# not loaded here: the process that only collects these tests does without
NEEDS_PARQUET = pytest.mark.skipif(not find_spec("pyarrow"), reason="pyarrow is not installed")
NEEDS_DASK = pytest.mark.skipif(not find_spec("distributed"), reason="distributed is not installed")
CAMPAIGN = """
runs: 6
seed: 7
duration: 0.25
scenario: tumbling_cubesat
parameters: {rate: 100.0, imu_rate: 100.0, attitude_sensor_rate: 100.0}
vary:
  initial_attitude_xyzw: {distribution: uniform_rotation}
  initial_body_rate: {distribution: direction, norm: {distribution: uniform, low: 0.01, high: 0.5}}
  inertia: {distribution: box, mass: 8.0, edges: [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]}
  gyro_noise_density: {distribution: loguniform, low: 1e-5, high: 1.0e-3}
  motion: {distribution: choice, values: [moving_chart, closed_form]}
  sensor_seed: {distribution: run}
  epoch_ns: {distribution: run}
"""
"""Its estimators know the number of a run from the stamps, and the attitude from a sensor without an error."""
ESTIMATED = CAMPAIGN + "estimator: estimator_of_a_campaign:right\n"
ESTIMATOR = """
def right(run):
    if run.t_ns[0] == 2:
        raise RuntimeError("it is lost")
    return run.attitude_sensor.t_ns, run.attitude_sensor.attitude_xyzw
"""
LOST = "the filter failed, estimator_of_a_campaign.py line 4: RuntimeError: it is lost: correct that first"
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
    return sorted(int(path.stem) for path in (out / "runs").glob("*.json"))
