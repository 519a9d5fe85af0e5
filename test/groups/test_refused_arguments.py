"""Arguments that no group can take, or that are mixed up, are refused and named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lie_rigid_body import InputError, ParameterError, groups
from lie_rigid_body.groups import SO, SU, U1, GroupMovingChart, GroupState, Lagrangian
from lie_rigid_body.groups.algebra import MAX_GENERATORS

pytestmark = pytest.mark.filterwarnings("error")

ROOM: Any = groups
"""The room without its types, which refuse as well."""
GROUP = SO(4)
BODY = Lagrangian(GROUP, np.diag(np.arange(1.0, 7.0)))
HUGE = np.full(6, 1e308)


@pytest.mark.parametrize(
    ("family", "dimension"), [(SO, lambda n: n * (n - 1) // 2), (SU, lambda n: n * n - 1)], ids=["SO", "SU"]
)
def test_the_largest_group_is_the_last_whose_structure_constants_take_4_gib(family, dimension):
    fits = [n for n in range(2, 60) if dimension(n) ** 3 * 8 <= 4 * 1024**3]
    assert family(fits[-1]).dimension == dimension(fits[-1]) <= MAX_GENERATORS
    for size in (fits[-1] + 1, 3000, 2**63, 10**400, True, "3"):
        with pytest.raises(ParameterError) as caught:
            family(size)
        assert caught.value.name == "n"


@pytest.mark.parametrize(
    "function",
    [
        BODY.momenta,
        BODY.value,
        BODY.momentum_rate,
        BODY.chart_force,
        BODY.acceleration,
        GROUP.exp,
        GROUP.dexp,
        GROUP.dexpinv,
        groups.legendre_transform(BODY).value,
        lambda x: groups.casimirs(GROUP, x),
        lambda x: groups.casimirs(SU(3), np.append(x, x[:2])),
        lambda x: groups.linearisation(BODY, x),
        lambda x: groups.steady_rotation(BODY, x),
        lambda x: groups.chart_metric(BODY, x),
        lambda x: groups.chart_reach(GROUP, x),
        lambda x: groups.chart_reach(U1(), x[:1]),
        lambda x: GroupMovingChart(BODY, GroupState(np.eye(4), x)),
    ],
)
def test_what_leaves_double_precision_is_refused_without_a_warning(function):
    function(np.eye(6)[0])
    with pytest.raises(InputError):
        function(HUGE)


def test_metrics_and_rates_whose_eigenvalues_leave_double_precision_are_refused():
    with pytest.raises(ParameterError):
        groups.Lagrangian(SO(4), 1e308 * np.eye(6))
    with pytest.raises(ParameterError):
        groups.steady_rotation(groups.Lagrangian(SO(4), 2.0 * np.eye(6)), [0.3, -1e200, 0.5, 0.1, 0.4, -0.6])


def test_a_direction_of_nearly_nothing_is_followed_for_ever():
    reach = groups.chart_reach(SO(3), [1e-320, 0.0, 0.0])
    assert np.isinf(reach).all()


def test_impossibly_many_steps_are_refused_before_the_first():
    chart = GroupMovingChart(BODY, GroupState(np.eye(4), 0.1 * np.ones(6)), max_step=1e-9)
    with pytest.raises(InputError):
        chart.at([0, 2**62])
    chart.at([0, 3])


def test_the_coadjoint_action_takes_lists():
    assert np.array_equal(groups.ad_star(SO(3), [1, 0, 0], [0, 1, 0]), [0, 0, -1])


def test_other_names_are_missed_as_usual_and_those_that_are_there_are_found():
    assert not hasattr(groups, "casimir")
    assert all(hasattr(groups, name) for name in groups.__all__)
    assert U1().dimension == 1
