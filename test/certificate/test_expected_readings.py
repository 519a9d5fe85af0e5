"""The readings that a scenario determines: a step beside at times, and the same wherever a replay begins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_bags import BODY, FORCE, NOISY, RATES
from test_certified_faults import EVERY, LATER

from lie_rigid_body.certificate.readings import Expected, Replay, Replays
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
        assert bool((residuals <= limits()).all()) == holds, recorded_


QUIET = Scenario.from_parameters({**BODY, **RATES, "motion": "closed_form", "sensor_seed": 3})
"""Without noise, bias and specific force, so that the readings are zeros of either sign."""


@pytest.fixture(scope="module", params=[SCENARIO, QUIET], ids=["noisy", "quiet"])
def simulated(request):
    simulation = Simulation(request.param)
    return simulation.segment, simulation.take_until(simulation.next_stamp_ns + 3_000_000_000, 10**6).sensors


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(0, 60), min_size=1, max_size=12), st.integers(1, 9))
def test_a_replay_gives_the_readings_of_the_simulation_wherever_it_begins(simulated, steps, width):
    """In any order, also where faults, walks and what is stuck began before."""
    segment, taken = simulated
    for name, samples in taken.items():
        replay, last = Replay(segment, name, 0.0, Replays()), len(samples) - 1
        for order in (steps, steps[::-1]):
            for first in (last * step // 60 for step in order):
                numbers = np.arange(first, min(first + width, last + 1))
                piece = replay.piece(numbers)
                assert piece is not None
                assert piece.first <= first
                for array, expected in piece.arrays.items():
                    value = expected.converter.read(expected.signal)[first - piece.first]
                    assert value.tobytes() == samples.arrays[array][first].tobytes(), (name, array, first)


def test_only_steps_of_walks_cost_work():
    simulation = Simulation(SCENARIO)
    for name, walks in (("imu", True), ("magnetometer", False), ("sun_sensor", False)):
        work = Replays()
        work.allow(work._left - 1000)
        replay = Replay(simulation.segment, name, 0.0, work)
        assert (replay.piece(np.array([5000])) is None) == walks
