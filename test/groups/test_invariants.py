"""What free motion conserves: each invariant stands still along Euler's equations, and none is superfluous."""

from __future__ import annotations

import numpy as np
import pytest
from group_bodies import (
    ROTATIONS,
    UNITARY,
    assert_still,
    derivative_along,
    diagonal_body,
    gradient,
    random_metric,
    rank,
    skewed_rotations,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from lie_rigid_body.groups import (
    SO,
    SU,
    Lagrangian,
    legendre_transform,
    manakov_integrals,
    momentum_matrix,
    pfaffian,
    rotation_casimirs,
    spatial_momentum,
    unitary_casimirs,
)

seeds = st.integers(0, 2**32 - 1)
dimensions = pytest.mark.parametrize("n", ROTATIONS)
FEW = settings(max_examples=12)
TURN = np.array([[0.0, -2.0], [2.0, 0.0]])


def random_second_moment(rng, n):
    turned = SO(n).random(rng)
    k = turned @ np.diag(rng.uniform(0.3, 2.0, n)) @ turned.T
    return (k + k.T) / 2


def metric_of(group, k):
    t = group.generators
    m = -0.5 * (np.einsum("ij,ajk,bki->ab", k, t, t) + np.einsum("ij,bjk,aki->ab", k, t, t))
    return (m + m.T) / 2


def casimirs_of(group):
    casimirs = unitary_casimirs if np.iscomplexobj(group.generators) else rotation_casimirs
    return lambda p: casimirs(momentum_matrix(group, p))


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values()], ids=lambda g: g.name)
@FEW
@given(seed=seeds)
def test_energy_and_casimirs_stand_still_for_any_body(group, seed):
    rng = np.random.default_rng(seed)
    body, p = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=group.dimension)
    rate = body.momentum_rate(body.rates(p))
    assert_still(casimirs_of(group), p, rate)
    assert_still(lambda q: legendre_transform(body).value(q)[..., np.newaxis], p, rate)


@dimensions
@FEW
@given(seed=seeds)
def test_manakovs_integrals_stand_still_for_a_body_with_second_moment(n, seed):
    group, rng = ROTATIONS[n], np.random.default_rng(seed)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    body = Lagrangian(group, metric_of(group, k))
    assert_still(lambda q: manakov_integrals(momentum_matrix(group, q), k), p, body.momentum_rate(body.rates(p)))


@pytest.mark.parametrize("n", [4, 5, 6])
def test_manakovs_integrals_move_for_other_metrics(n):
    """Also with K in place of K²: the test above can fail."""
    group, rng = ROTATIONS[n], np.random.default_rng(31)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    integrals = lambda q: manakov_integrals(momentum_matrix(group, q), k)  # noqa: E731
    other = Lagrangian(group, random_metric(rng, group.dimension))
    assert np.abs(derivative_along(integrals, p, other.momentum_rate(other.rates(p)))).max() > 1e-2
    body = Lagrangian(group, metric_of(group, k @ k))
    assert np.abs(derivative_along(integrals, p, body.momentum_rate(body.rates(p)))).max() > 1e-2


@dimensions
def test_manakovs_integrals_count_half_of_dimension_and_rank(n):
    """As many as Liouville's theorem asks for, and the energy and the Casimirs are functions of them."""
    group, rng = ROTATIONS[n], np.random.default_rng(32)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    manakov = gradient(lambda q: manakov_integrals(momentum_matrix(group, q), k), p)
    body = legendre_transform(Lagrangian(group, metric_of(group, k)))
    energy = gradient(lambda q: body.value(q)[..., np.newaxis], p)
    casimirs = gradient(casimirs_of(group), p)
    assert manakov.shape[1] == n * n // 4 == (group.dimension + n // 2) // 2
    assert rank(manakov) == n * n // 4
    assert rank(np.hstack([manakov, energy, casimirs])) == n * n // 4
    assert rank(np.hstack([manakov, rng.normal(size=(group.dimension, 1))])) == n * n // 4 + 1


@dimensions
def test_manakovs_integrals_commute(n):
    """They are in involution under the Lie–Poisson bracket: with their number, Liouville integrability."""
    group, rng = ROTATIONS[n], np.random.default_rng(33)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    slopes = gradient(lambda q: manakov_integrals(momentum_matrix(group, q), k), p)
    slopes /= np.linalg.norm(slopes, axis=0)
    brackets = np.einsum("abc,c,ax,by->xy", group.structure_constants, p, slopes, slopes)
    np.testing.assert_allclose(brackets, 0.0, atol=1e-11 * np.linalg.norm(p))


@dimensions
def test_manakovs_integrals_are_the_coefficients_of_the_polynomials(n):
    rng = np.random.default_rng(34)
    k, p = random_second_moment(rng, n), momentum_matrix(ROTATIONS[n], rng.normal(size=ROTATIONS[n].dimension))
    found, row = manakov_integrals(p, k), 0
    for power in range(2, n + 1):
        orders = range(2, power + 1, 2)
        for parameter in (0.0, 0.5, -1.3):
            whole = np.trace(np.linalg.matrix_power(p + parameter * k @ k, power))
            without = parameter**power * np.trace(np.linalg.matrix_power(k @ k, power))
            terms = sum(found[row + i] * parameter ** (power - m) for i, m in enumerate(orders))
            assert terms == pytest.approx(whole - without, rel=1e-11, abs=1e-11)
        row += len(orders)
    assert row == len(found)


def test_manakovs_integrals_of_a_top_are_its_momentum_and_energy():
    """n = 3: tr P² = −2|p|², and tr(P²K²) is a combination of |p|² and the energy."""
    rng = np.random.default_rng(35)
    k = np.array([0.4, 0.7, 1.1])
    body = legendre_transform(Lagrangian(SO(3), diagonal_body(SO(3), k)))
    p = rng.normal(size=(10, 3))
    found = manakov_integrals(momentum_matrix(SO(3), p), np.diag(k))
    square = np.sum(p**2, axis=-1)
    np.testing.assert_allclose(found[:, 0], -2.0 * square, rtol=1e-14)
    # the second is −3 Σ (kᵢ² + kⱼ²) pₗ², and kᵢ² + kⱼ² = s² − q − (sq − r)/(kᵢ + kⱼ) in the symmetric functions s, q, r
    s, q, r = k.sum(), k[0] * k[1] + k[1] * k[2] + k[2] * k[0], k.prod()
    expected = -3.0 * ((s * s - q) * square - 2.0 * (s * q - r) * body.value(p))
    np.testing.assert_allclose(found[:, 1], expected, rtol=1e-13)


@pytest.mark.parametrize(("group", "count"), [(SO(3), 1), (SO(4), 2), (SO(5), 2), (SO(6), 3), (SU(2), 1), (SU(3), 2)])
def test_the_casimirs_are_as_many_as_the_rank(group, count):
    p = np.random.default_rng(36).normal(size=group.dimension)
    slopes = gradient(casimirs_of(group), p)
    assert slopes.shape == (group.dimension, count)
    assert rank(slopes) == count
    if not np.iscomplexobj(group.generators):
        n = group.size
        powers = lambda q: np.stack(  # noqa: E731
            [np.trace(np.linalg.matrix_power(momentum_matrix(group, q), k), axis1=-2, axis2=-1) for k in (2, 4, 6)], -1
        )
        assert rank(np.hstack([slopes, gradient(powers, p)[:, : n // 2]])) == count


@dimensions
def test_casimirs_of_rotations_are_what_they_are_called(n):
    group, rng = ROTATIONS[n], np.random.default_rng(37)
    p = momentum_matrix(group, rng.normal(size=(4, group.dimension)))
    expected = [np.trace(np.linalg.matrix_power(p, k), axis1=-2, axis2=-1) for k in range(2, n, 2)]
    if n % 2 == 0:
        expected.append(pfaffian(p))
    np.testing.assert_allclose(rotation_casimirs(p), np.stack(expected, axis=-1), rtol=1e-13)


def test_casimirs_of_su3_are_those_of_the_eigenvalues():
    group = SU(3)
    p = momentum_matrix(group, np.random.default_rng(38).normal(size=8))
    eigenvalues = np.linalg.eigvalsh(-1j * p)
    np.testing.assert_allclose(unitary_casimirs(p), [np.sum(eigenvalues**2), np.sum(eigenvalues**3)], rtol=1e-12)


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values(), skewed_rotations()], ids=lambda g: g.name)
def test_eulers_equations_are_a_commutator(group):
    """Ṗ = [P, Ω] for any body, and the spatial momentum matrix is A P A⁻¹."""
    rng = np.random.default_rng(39)
    body, w = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=group.dimension)
    p, big_w = body.momenta(w), group.hat(w)
    big_p = momentum_matrix(group, p)
    np.testing.assert_allclose(momentum_matrix(group, body.momentum_rate(w)), big_p @ big_w - big_w @ big_p, atol=1e-13)
    a = group.random(rng)
    there = momentum_matrix(group, spatial_momentum(group, a, p))
    np.testing.assert_allclose(there, a @ big_p @ group.inverse(a), atol=1e-13)


@dimensions
def test_the_momentum_matrix_of_a_body_is_k_omega_plus_omega_k(n):
    group, rng = ROTATIONS[n], np.random.default_rng(40)
    k, w = random_second_moment(rng, n), rng.normal(size=group.dimension)
    omega = group.hat(w)
    found = momentum_matrix(group, Lagrangian(group, metric_of(group, k)).momenta(w))
    np.testing.assert_allclose(found, k @ omega + omega @ k, atol=1e-14 * 10)


def expanded(p):
    """Pf by expansion along the first row, from its definition."""
    n = len(p)
    if n == 0:
        return 1.0
    rest = range(1, n)
    without = {j: [i for i in rest if i != j] for j in rest}
    return sum((-1) ** (j - 1) * p[0, j] * expanded(p[np.ix_(without[j], without[j])]) for j in rest)


@given(seeds, st.integers(0, 4))
def test_pfaffian_is_its_expansion_and_the_root_of_the_determinant(seed, half):
    rng = np.random.default_rng(seed)
    x = rng.integers(-3, 4, size=(3, 2 * half, 2 * half)).astype(float)
    p = x - np.swapaxes(x, 1, 2)
    expected = [expanded(q) for q in p]
    scale = 1.0 + np.prod(np.linalg.norm(p, axis=-1), axis=-1) ** 0.5
    np.testing.assert_allclose((pfaffian(p) - expected) / scale, 0.0, atol=1e-12)
    np.testing.assert_allclose((pfaffian(p) ** 2 - np.linalg.det(p)) / scale**2, 0.0, atol=1e-12)


@given(seeds)
def test_pfaffian_under_a_change_of_basis(seed):
    """Pf(B P Bᵀ) = det B · Pf P: an odd exchange of axes changes its sign, so it is no invariant of O(n)."""
    rng = np.random.default_rng(seed)
    x, b = rng.normal(size=(2, 6, 6))
    p = x - x.T
    expected = np.linalg.det(b) * pfaffian(p)
    changed = b @ p @ b.T
    assert pfaffian((changed - changed.T) / 2) == pytest.approx(
        expected, abs=1e-10 * np.linalg.norm(b) ** 6 * np.linalg.norm(p) ** 3
    )


def test_pfaffian_needs_no_pivot_on_the_way_and_none_at_all_for_odd_n():
    swapped = np.zeros((4, 4))
    swapped[0, 2], swapped[2, 0], swapped[1, 3], swapped[3, 1] = 2.0, -2.0, 3.0, -3.0
    assert pfaffian(swapped) == -6.0
    assert pfaffian(np.zeros((4, 4))) == 0.0
    assert pfaffian(np.array([[0.0, 7.0], [-7.0, 0.0]])) == 7.0
    np.testing.assert_array_equal(
        pfaffian(np.triu(np.ones((2, 3, 3)), 1) - np.tril(np.ones((2, 3, 3)), -1)), [0.0, 0.0]
    )
    np.testing.assert_array_equal(pfaffian(np.zeros((2, 0, 0))), [1.0, 1.0])
    assert pfaffian(np.zeros((0, 4, 4))).shape == (0,)
