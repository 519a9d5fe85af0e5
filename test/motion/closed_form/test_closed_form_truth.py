from __future__ import annotations

from decimal import Decimal

import pytest
from closed_form_reference import attitude_error, context, multiply, rate_error

from lie_rigid_body import ClosedForm
from lie_rigid_body.foundation.errors import InputError
from reference import truth_cases

CASES = truth_cases()
ATTITUDE_BOUND = 2e-15
RATE_BOUND = 1e-15


@pytest.mark.parametrize("name", CASES)
def test_the_closed_form_is_the_truth_to_round_off_at_every_time(name: str):
    body, start, points = CASES[name]
    states = ClosedForm(body, start).at([point.t_ns for point in points])
    for point, attitude, rate in zip(points, states.attitude_xyzw, states.body_rate, strict=True):
        truth = [Decimal(c) for c in point.attitude_xyzw]
        # the file does not promise the lift
        with context():
            if multiply([-truth[0], -truth[1], -truth[2], truth[3]], [Decimal(float(c)) for c in attitude])[3] < 0:
                truth = [-c for c in truth]
        assert attitude_error(truth, attitude) < ATTITUDE_BOUND
        assert rate_error([Decimal(c) for c in point.body_rate], rate) < RATE_BOUND


@pytest.mark.parametrize("t_ns", [0.5, [1.0, 2.0], "1", [[1, 2]], None, [True, False]])
def test_times_that_are_not_integers_are_refused(t_ns):
    body, start, _ = CASES["asymmetric"]
    with pytest.raises(InputError):
        ClosedForm(body, start).at(t_ns)
