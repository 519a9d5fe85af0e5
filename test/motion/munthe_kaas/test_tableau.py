"""A tableau holds its own order conditions: wrong coefficients cannot be built."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from lie_rigid_body.groups.group_moving_chart import runge_kutta_step
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT, ChainTableau


@pytest.mark.parametrize("tableau", [EULER, MIDPOINT])
def test_no_tableau_is_better_than_it_claims(tableau):
    with pytest.raises(ValueError, match="Σ"):
        ChainTableau(tableau.name, tableau.order + 1, tableau.a, tableau.b)


@pytest.mark.parametrize("position", range(4))
def test_a_changed_weight_is_caught(position):
    weights = list(CLASSICAL.b)
    weights[position] += Fraction(1, 1000)
    with pytest.raises(ValueError, match="Σb"):
        ChainTableau("broken", 4, CLASSICAL.a, tuple(weights))


@pytest.mark.parametrize("tableau", [EULER, MIDPOINT, CLASSICAL])
def test_stepper_integrates_polynomials_of_its_order_exactly(tableau):
    """y' = (t^(p-1), 1) with t carried along: a method of order p has no error but round-off."""
    p = tableau.order
    end = runge_kutta_step(tableau, lambda y: np.array([y[1] ** (p - 1), 1.0]), np.zeros(2), 0.7)
    assert end[0] == pytest.approx(0.7**p / p, rel=1e-15)
