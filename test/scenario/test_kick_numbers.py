"""Kicks at random follow the laws that are promised, and are the same for ever."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from lie_rigid_body import Campaign, Scenario, random_kicks
from lie_rigid_body.foundation.errors import InputError

LEAST_P = 1e-4
"""Of the Kolmogorov–Smirnov test: the draws are the same in every run, so it fails always or never."""
SECONDS, INTERVAL, RATE, REST = 2700.0, 3.0, 2.5, 0.25


def test_intervals_sizes_directions_and_rests_follow_their_laws() -> None:
    kicks = np.array(random_kicks(SECONDS, INTERVAL, RATE, REST, seed=4)).reshape(-1, 4)
    assert len(Scenario(kicks=kicks.ravel(), kick_period=SECONDS).kick_schedule()) == len(kicks)
    assert kicks[-1, 0] < SECONDS
    assert stats.kstest(np.diff(kicks[:, 0], prepend=0.0), stats.uniform(0.5 * INTERVAL, INTERVAL).cdf).pvalue > LEAST_P
    moves = kicks[:, 1:].any(axis=1)
    assert stats.binomtest(int((~moves).sum()), len(kicks), REST).pvalue > LEAST_P
    sizes = np.linalg.norm(kicks[moves, 1:], axis=1)
    assert stats.kstest(sizes, stats.uniform(0.3 * RATE, 0.7 * RATE).cdf).pvalue > LEAST_P
    for axis in (1, 2, 3):
        assert stats.kstest(kicks[moves, axis] / sizes, stats.uniform(-1.0, 2.0).cdf).pvalue > LEAST_P


FIRST = [1.1965686415867867, 0.5842153777684265, -0.030131203552239232, -0.5791923640876252]
"""Written down once: it must be the same with every version of every library."""


def test_kicks_are_the_same_for_ever_and_a_longer_list_begins_with_a_shorter_one() -> None:
    assert random_kicks(3.0, rest_probability=0.0, seed=7)[:4] == FIRST
    long = random_kicks(100.0, seed=7)
    assert long[: len(random_kicks(30.0, seed=7))] == random_kicks(30.0, seed=7)
    assert random_kicks(1e-9) == []
    for seed in (0, 8, 2**63 - 1):
        assert random_kicks(100.0, seed=seed) != long


@pytest.mark.parametrize(
    "given",
    [
        {"duration": 0.0},
        {"duration": 5000.0},
        {"duration": 9.0, "interval": 0.0},
        {"duration": 9.0, "rate": -1.0},
        {"duration": 9.0, "rest_probability": 1.1},
        {"duration": 9.0, "seed": 0.5},
    ],
)
def test_what_makes_no_list_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(InputError) as refused:
        random_kicks(**given)
    assert "\n" not in str(refused.value)


def test_runs_of_a_campaign_have_kicks_of_their_own_as_long_as_they_last() -> None:
    kicks = {"distribution": "random_kicks", "interval": 0.5, "rate": 1.5, "rest_probability": 0.0}
    campaign = Campaign(runs=40, seed=7, duration=20.0, vary={"kicks": kicks})
    drawn = [campaign.scenario_of(run).kicks for run in range(40)]
    assert len(set(drawn)) == 40
    assert all(19.0 < one[-4] < 20.0 for one in drawn)
    assert Campaign(runs=2, seed=7, duration=30.0, vary={"kicks": kicks}).drawn(1)["kicks"][:100] == list(
        drawn[1][:100]
    )
    with pytest.raises(InputError, match="1000"):
        Campaign(runs=1, seed=7, duration=600.0, vary={"kicks": kicks}).scenario_of(0)
    with pytest.raises(InputError, match=r"^vary\.kicks: rest_probability"):
        Campaign(runs=1, seed=7, duration=6.0, vary={"kicks": {**kicks, "rest_probability": 2}})
