"""Every body, start and scenario that the strategies give is one that the package accepts, and they are varied."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, find, given, settings

from lie_rigid_body import RigidBody, Scenario, State, simulate
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.testing.strategies import attitudes, bodies, scenarios, sensor_grades, starts

FEW = settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])


@given(bodies(), starts(max_rate=3.0))
def test_bodies_and_starts(body, start):
    assert isinstance(body, RigidBody)
    assert isinstance(start, State)
    a, b, c = body.principal_moments
    assert 0.0 < a <= b <= c <= (a + b) * (1.0 + 1e-12)
    assert np.abs(start.body_rate).max() <= 3.0
    assert np.linalg.norm(start.attitude_xyzw) == pytest.approx(1.0, abs=1e-15)


@FEW
@given(scenarios(grades=["mems", "tactical"], rate=25.0))
def test_scenarios_simulate(scenario):
    assert isinstance(scenario, Scenario)
    assert scenario.sensor_grade in ("mems", "tactical")
    run = simulate(scenario, duration=0.1)
    assert np.isfinite(run.imu.gyro).all()
    assert len(run.t_ns) == 3


def test_they_are_varied():
    quick = settings(phases=[Phase.generate], database=None, max_examples=200)
    assert find(sensor_grades(), lambda grade: grade == "mems", settings=quick) == "mems"
    for strategy, condition in [
        (attitudes(), lambda q: abs(q[3]) < 0.1),
        (bodies(), lambda body: np.ptp(body.principal_moments) < 1e-9),
        (bodies(), lambda body: np.abs(body.inertia - np.diag(np.diag(body.inertia))).max() > 0.1),
    ]:
        find(strategy, condition, settings=quick)


WRONG_RATES: list[Any] = ["x", 10**400, -1.0, None]
WRONG_GRADES: list[Any] = [0, "", "mems", [], ["none"]]


@pytest.mark.parametrize(
    "strategy",
    [*(starts(max_rate=wrong) for wrong in WRONG_RATES), *(scenarios(grades=wrong) for wrong in WRONG_GRADES)],
)
def test_wrong_arguments_are_refused_when_an_example_is_drawn(strategy):
    with pytest.raises(InputError):
        find(strategy, lambda drawn: True)
