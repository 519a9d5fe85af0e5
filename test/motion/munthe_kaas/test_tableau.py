"""Tableaus fulfil the conditions of their order, and no more."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from lie_rigid_body.groups.group_moving_chart import runge_kutta_step
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT, ChainTableau

TABLEAUS = pytest.mark.parametrize("tableau", [EULER, MIDPOINT, CLASSICAL])


def conditions(tableau: ChainTableau) -> list[tuple[int, Fraction]]:
    """Orders of the eight order conditions up to order 4, and sums that are to be 0.

    E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., sec. II.2, table 2.2.
    """
    b = np.array(tableau.b)
    c = np.array(tableau.a)
    matrix = np.diag(c[1:], -1)
    ac = matrix @ c
    wanted = [(1, 1, c**0), (2, 2, c), (3, 3, c**2), (3, 6, ac)]
    wanted += [(4, 4, c**3), (4, 8, c * ac), (4, 12, matrix @ c**2), (4, 24, matrix @ ac)]
    return [(order, (b * weights).sum() - Fraction(1, inverse)) for order, inverse, weights in wanted]


@TABLEAUS
def test_the_order_is_as_claimed(tableau: ChainTableau) -> None:
    assert len(tableau.a) == len(tableau.b)
    assert tableau.a[0] == 0
    assert min((order for order, rest in conditions(tableau) if rest), default=5) == tableau.order + 1


@pytest.mark.parametrize("position", range(4))
def test_a_changed_weight_is_caught(position: int) -> None:
    weights = list(CLASSICAL.b)
    weights[position] += Fraction(1, 1000)
    assert any(rest for _, rest in conditions(CLASSICAL._replace(b=tuple(weights))))


@TABLEAUS
def test_stepper_integrates_polynomials_of_its_order_exactly(tableau: ChainTableau) -> None:
    """y' = (t^(p-1), 1) with t carried along: a method of order p has no error but round-off."""
    p = tableau.order
    end = runge_kutta_step(tableau, lambda y: np.array([y[1] ** (p - 1), 1.0]), np.zeros(2), 0.7)
    assert end[0] == pytest.approx(0.7**p / p, rel=1e-15)
