"""Runs of several seeds keep to the memory that is allowed, and no array of a run can be changed."""

from __future__ import annotations

import itertools
import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import InputError, Run
from untyped import simulate


@pytest.mark.parametrize(
    "given",
    [
        {"duration": 1e8},
        {"duration": 60.0, "imu_rate": 1e9},
        {"duration": 60.0, "imu_rate": 100.0, "seeds": range(1_000_000)},
        {"duration": 1.0, "seeds": itertools.count()},
        {"duration": 1.0, "rate": 1000.0, "memory_limit": 10_000},
    ],
)
def test_more_than_fits_is_refused_before_anything_is_computed(given):
    tracemalloc.start()
    with pytest.raises(InputError, match="memory_limit"):
        simulate("tumbling_cubesat", **given)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6


@pytest.mark.parametrize(("seeds", "jitter"), [(3, 0.0), (6, 0.05)])
def test_what_is_allowed_keeps_to_the_limit(seeds, jitter):
    """Also where other numbers of readings arrive, so that the runs share only the truth."""
    given = {"duration": 1.0, "rate": 1000.0, "imu_rate": 1000.0, "magnetometer_rate": 500.0, "sensor_grade": "mems"}
    given |= {"motion": "closed_form", "imu_latency_jitter": jitter}
    with pytest.raises(InputError, match="memory_limit") as caught:
        simulate("tumbling_cubesat", memory_limit=2**20, seeds=range(seeds), **given)
    simulate("tumbling_cubesat", seeds=range(seeds), **given)  # what is loaded at the first use is not counted
    limit = int(str(caught.value).partition("which take ")[2].partition(":")[0])
    tracemalloc.start()
    runs = simulate("tumbling_cubesat", memory_limit=limit, seeds=range(seeds), **given)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(runs) == seeds
    assert peak < limit


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
