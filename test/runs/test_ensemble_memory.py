"""Simulated runs keep to the memory that a caller allows, and refuse more before anything is computed."""

from __future__ import annotations

import itertools
import tracemalloc
from typing import Any

import pytest

from lie_rigid_body import InputError, simulate


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
    with pytest.raises(InputError, match=r"memory_limit .* is too little for .* give a larger memory_limit"):
        simulate("tumbling_cubesat", **given)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6


@pytest.mark.parametrize(("seeds", "jitter"), [(3, 0.0), (6, 0.05)])
def test_what_is_allowed_keeps_to_the_limit(seeds, jitter):
    """Also where other numbers of readings arrive, so that the runs share only the truth."""
    given: dict[str, Any] = {
        "duration": 4.0,
        "rate": 1000.0,
        "imu_rate": 1000.0,
        "magnetometer_rate": 500.0,
        "sensor_grade": "mems",
        "imu_latency_jitter": jitter,
    }
    with pytest.raises(InputError, match="which take ") as refused:
        simulate("tumbling_cubesat", memory_limit=2**20, seeds=range(seeds), **given)
    simulate("tumbling_cubesat", seeds=range(seeds), **given)  # what is loaded at the first use is not counted
    limit = int(str(refused.value).partition("which take ")[2].partition(":")[0])
    tracemalloc.start()
    runs = simulate("tumbling_cubesat", memory_limit=limit, seeds=range(seeds), **given)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(runs) == seeds
    assert peak < limit


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"seeds": 5}, "seeds 5 are no numbers in a row"),
        ({"seeds": []}, "seeds are none"),
        ({"memory_limit": 1.5}, "memory_limit 1.5 is not a number of bytes"),
        ({"record_path": "x.mcap"}, r"call to_bag\('x.mcap'\) of the run"),
        ({"scenario": "nope"}, "^scenario 'nope' is unknown"),
    ],
)
def test_what_makes_no_run_is_one_line(given, message):
    with pytest.raises(InputError, match=message):
        simulate(**{"scenario": "tumbling_cubesat", "duration": 1.0, **given})
