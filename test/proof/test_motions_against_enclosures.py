"""The default stepper against proved enclosures, which owe nothing to the package's arithmetic."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("flint", reason="python-flint is not installed")

from regimes import REGIMES, motion

from lie_rigid_body import MovingChart
from lie_rigid_body.certificate.limits import max_attitude_error
from lie_rigid_body.proof import enclose
from lie_rigid_body.scenario import Scenario


def scenario_of(drawn, **parameters):
    inertia = drawn.inertia if drawn.inertia.ndim == 1 else drawn.body.inertia[np.triu_indices(3)]
    drawn_parameters = {
        "inertia": inertia.tolist(),
        "initial_attitude_xyzw": drawn.attitude_xyzw.tolist(),
        "initial_body_rate": drawn.rate.tolist(),
    }
    return Scenario.from_parameters({**drawn_parameters, **parameters})


@pytest.mark.parametrize(
    ("steps", "regime"),
    [
        *((1_000, regime) for regime in REGIMES),
        (10_000, "near_separatrix"),
        *(pytest.param(100_000, regime, marks=pytest.mark.slow) for regime in REGIMES),
    ],
)
def test_the_default_stepper_is_proved_to_keep_its_certificate(steps, regime):
    drawn = motion(regime, steps)
    scenario = scenario_of(drawn, max_step=0.01, rate=10.0)
    stamps = np.linspace(0, steps / 1000, 4).astype(np.int64)[1:] * 10**10
    states = MovingChart(scenario.body(), scenario.start(), method=scenario.method, max_step=scenario.max_step).at(
        stamps
    )
    for t_ns, attitude in zip(stamps, states.attitude_xyzw, strict=True):
        assert enclose(*drawn, int(t_ns)).attitude_error(attitude)[1] <= 0.1 * max_attitude_error(scenario)
