"""The named groups: their dimensions and bases, Haar measure, nearest elements, and where logarithms end."""

from __future__ import annotations

import numpy as np
import pytest
from sample_groups import ALL_COMPACT
from scipy.optimize import minimize

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import SO, SU, U1, product
from lie_rigid_body.groups.elements import measured
from lie_rigid_body.lie import so3

PAULI = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
EPSILON = np.array([np.cross(a, np.eye(3)) for a in np.eye(3)])
"""EPSILON[a, b] is the cross product of unit vectors a and b."""


@pytest.mark.parametrize("group", ALL_COMPACT.values(), ids=ALL_COMPACT)
def test_trace_metric_of_the_standard_bases_is_the_identity(group):
    np.testing.assert_allclose(group.trace_metric, np.eye(group.dimension), rtol=0, atol=4e-16)


def test_so3_and_su2_have_epsilon_as_structure_constants():
    np.testing.assert_array_equal(SO(3).generators, so3.hat(np.eye(3)))
    np.testing.assert_array_equal(SO(3).structure_constants, EPSILON)
    np.testing.assert_array_equal(SU(2).structure_constants, EPSILON)
    np.testing.assert_array_equal(SU(2).generators, -0.5j * PAULI)


@pytest.mark.parametrize("n", range(2, 8))
def test_generators_of_rotations_keep_orthogonality_to_first_order(n):
    """(1 + ε)ᵀ(1 + ε) = 1 to first order in ε, and the trace of ε is 0, as det g = 1 asks; all there are."""
    group = SO(n)
    small = 1e-6 * group.hat(np.random.default_rng(n).normal(size=group.dimension))
    first = group.identity + small
    np.testing.assert_allclose(first.T @ first, group.identity, rtol=0, atol=4 * np.sum(small**2))
    np.testing.assert_array_equal(np.swapaxes(group.generators, 1, 2), -group.generators)
    assert np.linalg.matrix_rank(group.generators.reshape(group.dimension, -1)) == n * (n - 1) // 2


@pytest.mark.parametrize("n", range(3, 8))
def test_so_of_one_axis_less_comes_first(n):
    inner = SO(n - 1)
    np.testing.assert_array_equal(SO(n).generators[: inner.dimension, 1:, 1:], inner.generators)
    assert not SO(n).generators[: inner.dimension, 0].any()


def test_su3_has_the_structure_constants_of_the_particle_data_group():
    f = SU(3).structure_constants
    table = {(1, 2, 3): 1.0, (4, 5, 8): np.sqrt(0.75), (6, 7, 8): np.sqrt(0.75)}
    table |= dict.fromkeys([(1, 4, 7), (2, 4, 6), (2, 5, 7), (3, 4, 5), (1, 6, 5), (3, 7, 6)], 0.5)
    for (a, b, c), value in table.items():
        assert f[a - 1, b - 1, c - 1] == pytest.approx(value, abs=1e-15)
    assert np.count_nonzero(np.abs(f) > 1e-14) == 6 * len(table)


@pytest.mark.parametrize("group", [SO(3), SO(4), SU(2), SU(3), U1()], ids=lambda g: g.name)
def test_random_elements_have_the_moments_of_haar_measure(group):
    """Entries average to 0, |Aᵢⱼ|² to 1/n, and |tr A|² to 1, and so do those turned by a fixed element."""
    A = group.random(np.random.default_rng(41), (20_000,))
    fixed = group.exp(np.full(group.dimension, 0.7))
    for B in (A, fixed @ A):
        np.testing.assert_allclose(B.mean(axis=0), 0.0, rtol=0, atol=0.03)
        np.testing.assert_allclose((np.abs(B) ** 2).mean(axis=0), 1.0 / group.size, rtol=0, atol=0.02)
        assert np.mean(np.abs(np.trace(B, axis1=1, axis2=2)) ** 2) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("group", [SO(3), SO(4)], ids=lambda g: g.name)
def test_no_element_is_nearer_than_the_projection(group):
    """For matrices far from the group, against a minimiser started from many elements."""
    rng = np.random.default_rng(42)
    for sign in (1.0, -1.0):
        A = rng.normal(size=(group.size, group.size))
        A[0] *= sign * np.sign(np.linalg.det(A))
        found = np.linalg.norm(group.project(A) - A)

        def distance(x, start, A=A):
            return np.linalg.norm(start @ group.exp(x) - A)

        starts = group.random(rng, (4,))
        best = min(minimize(distance, np.zeros(group.dimension), args=(start,)).fun for start in starts)
        assert found <= best + 1e-9
        assert group.contains(group.project(A), 1e-13)


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_logarithm_is_precise_up_to_the_half_turn_and_refused_there(n):
    group = SO(n)
    turn = np.zeros(group.dimension)
    basis = group.random(np.random.default_rng(43))
    for gap in (1e-2, 1e-5, 1e-8, 1e-11):
        turn[-1] = np.pi - gap
        x = group.Ad(basis) @ turn
        np.testing.assert_allclose(group.log(basis @ group.exp(turn) @ basis.T), x, rtol=0, atol=2e-14)
    turn[-1] = np.pi
    with pytest.raises(InputError):
        group.log(basis @ group.exp(turn) @ basis.T)


@pytest.mark.parametrize("group", [SO(3), SU(2)], ids=lambda g: g.name)
def test_dexpinv_is_refused_at_a_full_turn(group):
    with pytest.raises(InputError):
        group.dexpinv([0.0, 2 * np.pi, 0.0])
    assert np.isfinite(group.dexpinv([0.0, 2 * np.pi - 1e-9, 0.0])).all()


@pytest.mark.parametrize(
    ("group", "matrix", "distance"),
    [
        (SO(3), 1.1 * np.eye(3), 0.21 * np.sqrt(3.0)),
        (SO(3), 2.0 * np.eye(3), 7.0),
        (SO(3), np.diag([1.0, 1.0, -1.0]), 2.0),
        (SU(2), np.diag([1j, 1j]), 2.0),
        (SU(2), np.diag([1.0, 1.0 + 1e-6]), 2e-6 + 1e-12),
        (U1(), [[1.5]], 0.5),
        (product(SO(2), SO(2)), np.eye(4)[[2, 1, 0, 3]], np.sqrt(2.0)),
        (product(SO(2), SO(2)), np.eye(4) + 0.1 * np.eye(4, k=3), 0.1),
        (product(SO(2), U1()), 1j * np.eye(3), np.sqrt(2.0)),
        (SO(3), np.full((3, 3), np.nan), np.inf),
        (SU(2), np.full((2, 2), np.inf), np.inf),
    ],
)
def test_matrices_off_the_group_are_told_and_refused(group, matrix, distance):
    found = measured(group.as_matrices(matrix), group.elements.distance)
    assert found == pytest.approx(distance, rel=1e-9)
    assert not group.contains(matrix)
    for function in (group.log, group.inverse, group.Ad):
        with pytest.raises(InputError):
            function(matrix)


def test_membership_is_to_within_the_tolerance():
    slightly_off = np.eye(3) + 1e-7
    assert not SO(3).contains(slightly_off)
    assert SO(3).contains(slightly_off, tolerance=1e-5)


@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e-10, 1.0, 1e10, 1e200])
@pytest.mark.parametrize("group", [SO(3), SU(3), product(SO(2), SO(2))], ids=lambda g: g.name)
def test_what_is_outside_the_algebra_is_refused_at_any_scale(group, size):
    inside = group.hat(np.random.default_rng(61).normal(size=group.dimension))
    np.testing.assert_allclose(group.vee(size * inside) / size, group.vee(inside), rtol=0, atol=1e-15)
    for outside in (group.identity, inside + 1e-6 * group.identity):
        with pytest.raises(InputError):
            group.vee(size * outside)


def test_round_off_of_products_is_inside_the_algebra():
    group = SO(5)
    A, x = group.random(np.random.default_rng(62)), 1e-12 * np.random.default_rng(63).normal(size=10)
    np.testing.assert_allclose(group.vee(A @ group.hat(x) @ A.T), group.Ad(A) @ x, rtol=0, atol=1e-26)
    np.testing.assert_array_equal(group.vee(np.zeros((5, 5))), np.zeros(10))
