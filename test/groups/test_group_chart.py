"""The chart of a group: its metric away from the centre, Lagrange's equations there, and how far it reaches."""

from __future__ import annotations

import numpy as np
import pytest
from sample_groups import ALL, ALL_COMPACT, GROUPS, random_body

from lie_rigid_body.groups import (
    SO,
    SU,
    U1,
    GroupMovingChart,
    GroupState,
    MatrixLieGroup,
    chart_metric,
    chart_reach,
    product,
)
from lie_rigid_body.lie import so3

NAMES = pytest.mark.parametrize("name", GROUPS)
SHIFTS, BOOSTS, TIME = [(0, 4), (1, 4), (2, 4)], [(0, 3), (1, 3), (2, 3)], [(3, 4)]
"""Entries of 5×5 matrices that move space."""
FIVE_POINTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


@NAMES
def test_the_metric_of_the_chart_is_the_energy_of_the_matrices(name):
    """L from A(β + tβ̇) as matrices, on both sides of β, far from the centre."""
    body, rng = random_body(GROUPS[name], 81)
    group = body.group
    beta, speed = 0.6 * rng.normal(size=(2, group.dimension))
    h = 1e-4
    chord = group.log(group.inverse(group.exp(beta - h * speed)) @ group.exp(beta + h * speed)) / (2 * h)
    assert 0.5 * speed @ chart_metric(body, beta) @ speed == pytest.approx(float(body.value(chord)), rel=1e-6)
    np.testing.assert_array_equal(chart_metric(body, np.zeros(group.dimension)), body.metric)


@NAMES
def test_lagranges_equations_hold_away_from_the_centre(name):
    """d/dt ∂L/∂β̇ = ∂L/∂β along a motion, in a chart that stays where it was, and each side is not 0."""
    body, rng = random_body(GROUPS[name], 81)
    group, d, h = body.group, body.group.dimension, 4e-3
    start = GroupState(group.identity, rng.normal(size=d) / np.sqrt(d))
    middle = 100
    times = np.rint(1e9 * h * (middle + np.array([-2, -1, 0, 1, 2]))).astype(np.int64)
    states = GroupMovingChart(body, start, max_step=h).at(times)
    beta = group.log(states.element)
    speed = np.einsum("nab,nb->na", group.dexpinv(-beta), states.rate)
    momenta = np.einsum("nab,nb->na", chart_metric(body, beta), speed)
    rate = FIVE_POINTS @ momenta[[0, 1, 3, 4]] / h
    eps = 1e-5
    metrics = [chart_metric(body, beta[2] + s * eps * e) for e in np.eye(d) for s in (1.0, -1.0)]
    slopes = np.array([speed[2] @ m @ speed[2] for m in metrics]).reshape(d, 2) @ [0.25, -0.25] / eps
    np.testing.assert_allclose(rate, slopes, rtol=0, atol=1e-8)
    assert np.linalg.norm(beta[2]) > 0.2
    assert name == "U1" or np.abs(slopes).max() > 1e-3


@pytest.mark.parametrize(
    ("group", "direction", "one_to_one", "regular"),
    [
        (SO(3), [0.0, 0.0, 1.0], np.pi, 2 * np.pi),
        (SO(3), [0.6, 0.0, 0.8], np.pi, 2 * np.pi),
        (SU(2), [0.6, 0.0, 0.8], 2 * np.pi, 2 * np.pi),
        (U1(), [2.0], np.pi / 2, np.inf),
        (SO(2), [1.0], np.pi, np.inf),
        # one half of so(4) turns two planes by the same angle; eigenvalues of ad are their sums and differences
        (SO(4), [1.0, 0, 0, 0, 0, 1.0], np.pi, np.pi),
        (SU(3), [0, 0, 1.0, 0, 0, 0, 0, 0], 2 * np.pi, 2 * np.pi),
        (product(SO(3), SU(2)), [0, 0, 1.0, 0, 0, 1.0], np.pi, 2 * np.pi),
        (product(SU(2), U1()), [0, 0, 1.0, 0.1], 2 * np.pi, 2 * np.pi),
        (ALL["Heisenberg"], [0.3, -0.2, 0.9], np.inf, np.inf),
        (ALL["sl(2)"], [1.0, 0.0, 0.0], np.inf, np.inf),
        (ALL["sl(2)"], [0.0, 1.0, -1.0], np.pi, np.pi),
        (GROUPS["SE2"], [1.0, 0.4, 0.0], np.pi, 2 * np.pi),
        (GROUPS["SE2"], [0.0, 1.0, 2.0], np.inf, np.inf),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_how_far_a_chart_reaches(group, direction, one_to_one, regular):
    reach = chart_reach(group, direction)
    assert reach.one_to_one == pytest.approx(one_to_one, rel=1e-12)
    assert reach.regular == pytest.approx(regular, rel=1e-12)


@pytest.mark.parametrize(
    ("entries", "tolerance"), [(SHIFTS, 1e-7), (SHIFTS + BOOSTS, 1e-7), (SHIFTS + BOOSTS + TIME, 1e-4)]
)
def test_a_turn_that_comes_with_shifts_ends_a_chart_where_it_does_alone(entries, tolerance):
    """Along most of these directions ad cannot be made diagonal: SE(3), SE_2(3) and Galilei's group."""
    generators = np.zeros((3 + len(entries), 5, 5))
    generators[:3, :3, :3] = so3.hat(np.eye(3))
    for generator, entry in zip(generators[3:], entries, strict=True):
        generator[entry] = 1.0
    group = MatrixLieGroup.from_generators(generators)
    for size in (1e-6, 1.0, 1e3):
        xi = np.random.default_rng(85).normal(size=(300, group.dimension))
        xi[:, 3:] *= size
        full_turn = 2 * np.pi / np.linalg.norm(xi[:, :3], axis=1)
        np.testing.assert_allclose(chart_reach(group, xi).regular, full_turn, rtol=tolerance)


@pytest.mark.parametrize("group", ALL.values(), ids=ALL)
def test_dexp_has_full_rank_up_to_the_reach_and_not_at_it(group):
    xi = np.random.default_rng(82).normal(size=group.dimension)
    end = chart_reach(group, xi).regular
    if np.isfinite(end):
        assert np.linalg.matrix_rank(group.dexp(end * xi), tol=1e-9) < group.dimension
        assert np.linalg.svd(group.dexp(0.95 * end * xi), compute_uv=False)[-1] > 1e-4
    else:
        assert np.linalg.matrix_rank(group.dexp(3.0 * xi)) == group.dimension


@pytest.mark.parametrize("group", ALL_COMPACT.values(), ids=ALL_COMPACT)
def test_the_logarithm_leads_back_up_to_the_reach_and_not_beyond(group):
    xi = np.random.default_rng(83).normal(size=group.dimension)
    end = chart_reach(group, xi).one_to_one
    for share, back in ((0.5, True), (0.999, True), (1.001, False)):
        found = group.log(group.exp(share * end * xi))
        assert np.allclose(found, share * end * xi, rtol=0, atol=1e-9) is back
    assert end <= chart_reach(group, xi).regular * (1 + 1e-12)


def test_reaches_are_batched():
    x = np.random.default_rng(84).normal(size=(2, 3, 6))
    reach = chart_reach(SO(4), x)
    assert reach.one_to_one.shape == reach.regular.shape == (2, 3)
    np.testing.assert_allclose(reach.regular[1, 2], chart_reach(SO(4), x[1, 2]).regular, rtol=1e-12)
