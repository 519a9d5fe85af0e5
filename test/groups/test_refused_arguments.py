"""Arguments that no group can take are refused, and named: other objects, other shapes, numbers beyond doubles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sample_groups import se3

from lie_rigid_body import InputError, ParameterError, groups
from lie_rigid_body.groups import SO, SU, U1, GroupMovingChart, GroupState, Lagrangian, double_cover, product
from lie_rigid_body.groups.algebra import MOST_GENERATORS

pytestmark = pytest.mark.filterwarnings("error")

ROOM: Any = groups
"""The room without its types, which refuse as well."""
GROUP: Any = SO(4)
CHART: Any = double_cover
BODY: Any = Lagrangian(GROUP, np.diag(np.arange(1.0, 7.0)))
RIGID: Any = groups.MatrixLieGroup.from_generators(se3())
HUGE = np.full(6, 1e308)
FAR = np.eye(4) + np.diag([1e308, 0.0, 0.0], 1)
NO_NUMBER = ("x", None, np.ones(3), 10**400, object(), np.nan)
NO_MATRICES = (np.ones(6), np.zeros((3, 3)), np.zeros((3, 4, 5)), None, object(), np.array(list("abc")), GROUP)


@pytest.mark.parametrize(
    ("family", "dimension"), [(SO, lambda n: n * (n - 1) // 2), (SU, lambda n: n * n - 1)], ids=["SO", "SU"]
)
def test_the_largest_group_is_the_last_whose_structure_constants_take_4_gib(family, dimension):
    fits = [n for n in range(2, 60) if dimension(n) ** 3 * 8 <= 4 * 1024**3]
    assert family(fits[-1]).dimension == dimension(fits[-1]) <= MOST_GENERATORS
    for size in (fits[-1] + 1, 3000, 2**63, 10**400, True, "3"):
        with pytest.raises(ParameterError) as caught:
            family(size)
        assert caught.value.name == "n"


def test_a_product_has_no_more_generators_than_the_largest_group():
    with pytest.raises(ParameterError) as caught:
        product(SO(40), SO(40))
    assert caught.value.name == "dimension"


@pytest.mark.parametrize("function", ["coordinates", "off_span", "vee", "restored", "project", "contains"])
@pytest.mark.parametrize("given", NO_MATRICES, ids=range(len(NO_MATRICES)))
def test_what_is_no_matrix_of_the_size_is_refused(function, given):
    with pytest.raises(ParameterError) as caught:
        getattr(GROUP, function)(given)
    assert caught.value.name == "matrices of SO(4)"


@pytest.mark.parametrize("given", NO_NUMBER, ids=range(len(NO_NUMBER)))
@pytest.mark.parametrize(
    ("function", "name"),
    [
        (lambda given: GROUP.contains(np.eye(4), given), "tolerance"),
        (lambda given: GROUP.as_elements(np.eye(4), given), "tolerance"),
        (lambda given: groups.conserved_momenta(GROUP, np.eye(6), tolerance=given), "tolerance"),
        (lambda given: GROUP.scaled_trace(given), "scale"),
    ],
    ids=["contains", "as_elements", "conserved_momenta", "scaled_trace"],
)
def test_what_is_no_finite_number_is_refused(function, name, given):
    with pytest.raises(ParameterError) as caught:
        function(given)
    assert caught.value.name == name


@pytest.mark.parametrize("shape", ["x", (-1,), -1, 1.5, None, np.ones(3), (2, "x"), [[1], [2, 3]]], ids=range(8))
def test_what_is_no_shape_is_refused(shape):
    for group in (GROUP, RIGID, U1(), product(SO(3), SU(2))):
        with pytest.raises(ParameterError) as caught:
            group.random(np.random.default_rng(1), shape)
        assert caught.value.name == "shape"


@pytest.mark.parametrize("name", [3, None, np.float32(1.0), b"x", GROUP], ids=range(5))
def test_an_error_tells_any_name(name):
    for build in (lambda: GROUP.as_components(np.ones(5), name), lambda: ROOM.require_metric(np.eye(5), 6, name)):
        with pytest.raises(ParameterError) as caught:
            build()
        assert isinstance(caught.value.name, str)


@pytest.mark.parametrize(
    "build",
    [
        lambda: groups.chart_reach(GROUP, np.full(6, np.nan)),
        lambda: GROUP.restored(np.full((4, 4), np.nan)),
        lambda: BODY.momenta(np.full(6, np.inf)),
        lambda: groups.linearisation(BODY, [1.0, 2.0]),
        lambda: groups.linearisation(BODY, np.ones((1, 1, 1, 1))),
        lambda: groups.coadjoint_action(GROUP, np.ones((2, 6)), np.ones((3, 6))),
        lambda: groups.lie_poisson_bracket(GROUP, np.ones(6), np.ones((2, 6)), np.ones((3, 6))),
        lambda: groups.spatial_momentum(GROUP, np.stack([np.eye(4)] * 2), np.ones((3, 6))),
        lambda: CHART.from_quaternion("x"),
        lambda: CHART.lift("x"),
        lambda: groups.chasles(np.eye(3), np.eye(3)).apply(np.ones(4)),
        *(
            lambda function=function, given=given: function(given)
            for group, given in ((GROUP, FAR), (RIGID, FAR), (RIGID, np.full((4, 4), 1e308)))
            for function in (group.log, group.inverse, group.as_elements, group.Ad, RIGID.project)
        ),
        *(
            lambda function=function, given=given: function(given)
            for function in (GROUP.off_span, GROUP.coordinates)
            for given in (np.full((4, 4), np.inf), np.full((4, 4), np.nan))
        ),
        lambda: GROUP.off_span(FAR),
    ],
)
def test_what_is_not_finite_or_goes_with_nothing_is_refused(build):
    with pytest.raises(InputError):
        build()


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


@pytest.mark.parametrize("moments", [np.full(4, 1e308), np.array([1e308, -1e308, 1.0, 1.0]), np.full(4, -1e308)])
def test_second_moments_whose_sums_leave_double_precision_are_refused(moments):
    with pytest.raises(ParameterError) as caught:
        groups.mass_matrix(np.diag(moments), GROUP.generators)
    assert caught.value.name == "second moment"


def test_a_direction_of_nearly_nothing_is_followed_for_ever():
    reach = groups.chart_reach(SO(3), [1e-320, 0.0, 0.0])
    assert np.isinf(reach).all()


def test_impossibly_many_steps_are_refused_before_the_first():
    chart = GroupMovingChart(BODY, GroupState(np.eye(4), 0.1 * np.ones(6)), max_step=1e-9)
    with pytest.raises(InputError):
        chart.at([0, 2**62])
    chart.at([0, 3])
