"""The readings that a scenario determines: a step beside at times, and the same wherever a replay begins."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_bags import BODY, EVERY, FORCE, LATER, NOISY, RATES

from lie_rigid_body.certificate import readings
from lie_rigid_body.certificate.readings import Expected, Replay
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors.signal import Converter
from lie_rigid_body.simulation import Simulation

SCENARIO = Scenario.from_parameters({**BODY, **RATES, **FORCE, **NOISY, **EVERY, **LATER, "motion": "closed_form"})


def test_a_step_is_allowed_only_where_the_truth_may_be_on_either_side():
    step = Converter(0.5, 2.0)
    signal = np.array([[0.2499999, 0.2, 3.0]])
    expected = Expected(signal, np.full((1, 1), 1e-6), step)
    for recorded_, holds in (
        ([0.0, 0.0, 2.0], True),
        ([0.5, 0.0, 2.0], True),
        ([0.25, 0.0, 2.0], False),
        ([-0.5, 0.0, 2.0], False),
        ([0.0, 0.5, 2.0], False),
        ([0.0, 0.0, 2.5], False),
        ([0.0, np.nan, 2.0], False),
    ):
        residuals, limits = expected.residuals(np.array([recorded_]))
        assert bool((residuals <= limits).all()) == holds, recorded_


QUIET = Scenario.from_parameters({**BODY, **RATES, "motion": "closed_form", "sensor_seed": 3})
"""Without noise, bias and specific force, so that the readings are zeros of either sign."""


@pytest.fixture(scope="module", params=[SCENARIO, QUIET], ids=["noisy", "quiet"])
def simulated(request):
    simulation = Simulation(request.param)
    return simulation.segment, simulation.take_until(simulation.next_stamp_ns + 3_000_000_000, 10**6).sensors


def test_a_replay_gives_the_readings_of_the_simulation(simulated, monkeypatch):
    """In blocks of any size, also where faults, walks and what is stuck began before."""
    monkeypatch.setattr(readings, "REPLAY_BLOCK", 37)
    segment, taken = simulated
    for name, samples in taken.items():
        replay, last = Replay(segment, name), len(samples) - 1
        while replay.next <= last:
            block = replay.block(replay.next, min(last, replay.next + 49))
            for array, expected in block.arrays.items():
                wanted = samples.arrays[array][block.first : block.end].reshape(len(block.times_ns), -1)
                assert expected.values.tobytes() == wanted.tobytes(), (name, array, block.first)
