"""Enclosures of kicked motions against another method: Taylor's series of Euler's equations, arc by arc."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("flint", reason="python-flint is not installed")

from taylor import enclose_by_taylor

from lie_rigid_body.lie import quaternion
from lie_rigid_body.proof.kicked import EnclosedMotion

INERTIA = [1.0, 0.1, -0.05, 1.6, 0.2, 2.1]
START = [0.5, -0.5, 0.5, 0.5]
BEGINS_NS = [0, 1_200_000_000, 1_900_000_000, 4_000_000_000, 5_500_000_001]
RATES = [[0.3, -1.0, 0.2], [2.0, 0.1, -0.4], [0.0, 0.0, 0.0], [0.0, 0.0, 1.5], [-1.0, 1.0, 0.3]]


def test_arcs_are_those_of_taylors_series() -> None:
    truth = EnclosedMotion(INERTIA, START, BEGINS_NS, RATES)
    attitude = np.array(START)
    for before, after, rate in zip(BEGINS_NS, BEGINS_NS[1:], RATES, strict=False):
        turned = enclose_by_taylor(INERTIA, [0.0, 0.0, 0.0, 1.0], rate, after - before).attitude_xyzw
        attitude = quaternion.multiply(attitude, [float(x.mid()) for x in turned])
        assert truth.at(after - 1).attitude_error(attitude)[1] < 4e-9  # a nanosecond before the kick
        assert truth.at(after).attitude_error(attitude)[1] < 3e-15


def test_bounds_add_up_from_arc_to_arc() -> None:
    begins = [10**8 * k for k in range(400)]
    rates = np.random.default_rng(1).normal(size=(400, 3)).tolist()
    assert EnclosedMotion(INERTIA, START, begins, rates).at(begins[-1]).width < 1e-20
