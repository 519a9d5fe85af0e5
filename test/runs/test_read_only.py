"""A run is scored by arrays that nobody changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import Run, simulate


def test_no_array_of_a_run_can_be_written(tmp_path: Path) -> None:
    """An estimator that shifts its stamps in place would shift those that its estimate is scored by."""
    sensors: dict[str, Any] = {
        f"{name}_rate": 20.0 for name in ("imu", "magnetometer", "attitude_sensor", "sun_sensor")
    }
    made = simulate(duration=0.5, imu_orientation=True, **sensors)
    made.to_bag(tmp_path / "a.mcap")
    for run in (made, Run.from_bag(tmp_path / "a.mcap"), *simulate(duration=0.5, seeds=range(2), **sensors)):
        parts = (run, run.imu, run.magnetometer, run.attitude_sensor, run.sun)
        arrays = [array for part in parts for array in vars(part).values() if isinstance(array, np.ndarray)]
        assert len(arrays) >= 1 + 6 + 3 + 4 + 3
        for array in (*arrays, run.truth.attitude_xyzw, run.truth.body_rate):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
    of_a_caller = np.arange(10)
    replace(made, t_ns=of_a_caller)
    of_a_caller[0] = 1
