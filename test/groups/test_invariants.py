"""What free motion conserves: invariants stand still along Euler's equations, as symmetries make them."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_groups import (
    COMPACT,
    GROUPS,
    ROTATIONS,
    UNITARY,
    assert_still,
    derivative_along,
    diagonal_body,
    gradient,
    random_body,
    random_metric,
    rank,
    skewed_rotations,
)

from lie_rigid_body.groups import (
    SO,
    SU,
    Lagrangian,
    MatrixLieGroup,
    casimirs,
    conserved_momenta,
    legendre_transform,
    manakov_integrals,
    mass_matrix,
    metric_at,
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


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values()], ids=lambda g: g.name)
@FEW
@given(seed=seeds)
def test_energy_and_casimirs_stand_still_for_any_body(group, seed):
    body, rng = random_body(group, seed)
    p = rng.normal(size=group.dimension)
    rate = body.momentum_rate(body.rates(p))
    assert_still(partial(casimirs, group), p, rate)
    assert_still(lambda q: legendre_transform(body).value(q)[..., np.newaxis], p, rate)


@dimensions
@FEW
@given(seed=seeds)
def test_manakovs_integrals_stand_still_for_a_body_with_second_moment(n, seed):
    group, rng = ROTATIONS[n], np.random.default_rng(seed)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    body = Lagrangian(group, mass_matrix(k, group.generators))
    assert_still(lambda q: manakov_integrals(momentum_matrix(group, q), k), p, body.momentum_rate(body.rates(p)))


@pytest.mark.parametrize("n", [4, 5, 6])
def test_manakovs_integrals_move_for_other_metrics(n):
    """Also with K in place of K²: the test above can fail."""
    group, rng = ROTATIONS[n], np.random.default_rng(31)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    integrals = lambda q: manakov_integrals(momentum_matrix(group, q), k)  # noqa: E731
    other = Lagrangian(group, random_metric(rng, group.dimension))
    assert np.abs(derivative_along(integrals, p, other.momentum_rate(other.rates(p)))).max() > 1e-2
    body = Lagrangian(group, mass_matrix(k @ k, group.generators))
    assert np.abs(derivative_along(integrals, p, body.momentum_rate(body.rates(p)))).max() > 1e-2


@dimensions
def test_manakovs_integrals_count_half_of_dimension_and_rank(n):
    """As many as Liouville's theorem asks for, and the energy and the Casimirs are functions of them."""
    group, rng = ROTATIONS[n], np.random.default_rng(32)
    k, p = random_second_moment(rng, n), rng.normal(size=group.dimension)
    manakov = gradient(lambda q: manakov_integrals(momentum_matrix(group, q), k), p)
    body = legendre_transform(Lagrangian(group, mass_matrix(k, group.generators)))
    energy = gradient(lambda q: body.value(q)[..., np.newaxis], p)
    of_any_body = gradient(partial(casimirs, group), p)
    assert manakov.shape[1] == n * n // 4 == (group.dimension + n // 2) // 2
    assert rank(manakov) == n * n // 4
    assert rank(np.hstack([manakov, energy, of_any_body])) == n * n // 4
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


@pytest.mark.parametrize(("group", "count"), [(SO(3), 1), (SO(4), 2), (SO(5), 2), (SO(6), 3), (SU(2), 1), (SU(3), 2)])
def test_the_casimirs_are_as_many_as_the_rank(group, count):
    p = np.random.default_rng(36).normal(size=group.dimension)
    slopes = gradient(partial(casimirs, group), p)
    assert slopes.shape == (group.dimension, count)
    assert rank(slopes) == count


@dimensions
def test_casimirs_of_rotations_are_what_they_are_called(n):
    group, rng = ROTATIONS[n], np.random.default_rng(37)
    p = momentum_matrix(group, rng.normal(size=(4, group.dimension)))
    expected = [np.trace(np.linalg.matrix_power(p, k), axis1=-2, axis2=-1) for k in range(2, n, 2)]
    expected += [pfaffian(p)] * (n % 2 == 0)
    np.testing.assert_allclose(rotation_casimirs(p), np.stack(expected, axis=-1), rtol=1e-13)


def test_casimirs_of_su3_are_those_of_the_eigenvalues():
    group = SU(3)
    p = momentum_matrix(group, np.random.default_rng(38).normal(size=8))
    eigenvalues = np.linalg.eigvalsh(-1j * p)
    np.testing.assert_allclose(unitary_casimirs(p), [np.sum(eigenvalues**2), np.sum(eigenvalues**3)], rtol=1e-12)


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values(), skewed_rotations()], ids=lambda g: g.name)
def test_eulers_equations_are_a_commutator(group):
    """Ṗ = [P, Ω] for any body, and the spatial momentum matrix is A P A⁻¹."""
    body, rng = random_body(group, 39)
    w = rng.normal(size=group.dimension)
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
    found = momentum_matrix(group, Lagrangian(group, mass_matrix(k, group.generators)).momenta(w))
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


def test_pfaffian_needs_no_pivot_on_the_way_and_none_at_all_for_odd_n():
    swapped = np.zeros((4, 4))
    swapped[0, 2], swapped[2, 0], swapped[1, 3], swapped[3, 1] = 2.0, -2.0, 3.0, -3.0
    assert pfaffian(swapped) == -6.0
    assert pfaffian(np.zeros((4, 4))) == 0.0
    assert pfaffian(np.array([[0.0, 7.0], [-7.0, 0.0]])) == 7.0
    np.testing.assert_array_equal(pfaffian(np.stack([SO(3).hat([0.3, 0.2, 0.1])] * 2)), [0.0, 0.0])
    np.testing.assert_array_equal(pfaffian(np.zeros((2, 0, 0))), [1.0, 1.0])
    assert pfaffian(np.zeros((0, 4, 4))).shape == (0,)


@pytest.mark.parametrize(
    ("moments", "expected"),
    [
        ([1.0, 1.0, 2.0], [[0, 0, 1]]),
        ([2.0, 1.0, 1.0], [[1, 0, 0]]),
        ([1.0, 2.0, 1.0], [[0, 1, 0]]),
        ([3.0, 3.0, 3.0], np.eye(3)),
        ([1.0, 2.0, 3.0], np.empty((0, 3))),
        ([1.0, 1.0 + 1e-9, 3.0], np.empty((0, 3))),
    ],
)
def test_tops(moments, expected):
    np.testing.assert_allclose(conserved_momenta(SO(3), np.diag(moments)), expected, atol=1e-15)


@given(seeds, st.floats(1e-8, 1e8))
def test_a_tilted_symmetric_top_keeps_its_axis_in_any_unit(seed, unit):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    found = conserved_momenta(SO(3), unit * (np.eye(3) + rng.uniform(0.1, 3.0) * np.outer(axis, axis)))
    assert found.shape == (1, 3)
    np.testing.assert_allclose(np.abs(found @ axis), 1.0, rtol=1e-12)
    assert found[0, np.argmax(np.abs(found[0]))] > 0.0


@pytest.mark.parametrize("name", COMPACT)
def test_the_unit_keeps_everything_and_a_random_metric_nothing(name):
    group = COMPACT[name]
    np.testing.assert_array_equal(conserved_momenta(group, 3.0 * np.eye(group.dimension)), np.eye(group.dimension))
    metric = random_metric(np.random.default_rng(21), group.dimension)
    assert len(conserved_momenta(group, metric)) == (name == "U1")


@pytest.mark.parametrize(
    "moments",
    [
        *([1, 1, 2, 3], [1, 1, 2, 2], [1, 1, 1, 2], [1, 2, 3, 4], [1, 1, 2, 2, 2], [1, 2, 2, 3, 3]),
        *([1, 1, 1, 2, 2, 2], [1, 1, 2, 2, 3, 3], [2, 1, 2, 1, 2, 1]),
    ],
)
def test_equal_second_moments_are_turns_into_each_other(moments):
    """The isotropy of K is the product of rotation groups, one for each of its eigenvalues."""
    n, (_, counts) = len(moments), np.unique(moments, return_counts=True)
    group = ROTATIONS[n]
    k = np.diag(np.array(moments, float))
    found = conserved_momenta(group, mass_matrix(k, group.generators))
    assert len(found) == np.sum(counts * (counts - 1) // 2)
    commutators = group.hat(found) @ k - k @ group.hat(found)
    np.testing.assert_allclose(commutators, 0.0, atol=1e-13)


@pytest.mark.parametrize("name", GROUPS)
@given(seed=seeds)
def test_exactly_these_momenta_stand_still(name, seed):
    """The condition asked of motions: ξ·ṗ = 0 for many random rates, and for no direction outside the span."""
    group, rng = GROUPS[name], np.random.default_rng(seed)
    d = group.dimension
    # a metric with a symmetry in about half of the cases: 1 plus what two random directions add
    add = rng.normal(size=(rng.integers(0, 2), d))
    metric = np.eye(d) + add.T @ add
    w = rng.normal(size=(d * d + 5, d))
    rates = Lagrangian(group, metric).momentum_rate(w)
    found = conserved_momenta(group, metric)
    np.testing.assert_allclose(found @ found.T, np.eye(len(found)), atol=1e-13)
    np.testing.assert_allclose(rates @ found.T, 0.0, atol=1e-11 * (1 + np.abs(rates).max()))
    others = np.linalg.svd(rates, compute_uv=False) if d else np.empty(0)
    assert np.sum(others > 1e-9 * (1 + others.max())) == d - len(found)


def test_the_basis_does_not_hang_on_round_off():
    group, rng = ROTATIONS[5], np.random.default_rng(24)
    tilted = metric_at(diagonal_body(group, [1.0, 1.0, 1.0, 2.0, 2.0]), group.random(rng))
    first = conserved_momenta(group, tilted)
    for _ in range(5):
        noise = rng.normal(size=tilted.shape) * 1e-15
        np.testing.assert_allclose(conserved_momenta(group, tilted + noise + noise.T), first, atol=1e-11)


def test_a_tie_is_for_the_first_generator_whatever_round_off_says():
    """The axis (1, −1, 0)/√2 is as near to the first generator as to the second: the first gives the sign."""
    axis, rng = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0), np.random.default_rng(25)
    for _ in range(20):
        noise = rng.normal(size=(3, 3)) * 1e-15
        metric = np.eye(3) + np.outer(axis, axis) + noise + noise.T
        np.testing.assert_allclose(conserved_momenta(SO(3), metric), [axis], atol=1e-13)


def test_the_tolerance_is_asymmetry_relative_to_the_metric():
    nearly = 1e5 * np.diag([1.0, 1.0 + 1e-6, 2.0])
    assert len(conserved_momenta(SO(3), nearly)) == 0
    assert len(conserved_momenta(SO(3), nearly, tolerance=1e-5)) == 1


@pytest.mark.parametrize("stretch", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize(("moments", "count"), [((1.0, 2.0, 1.8), 0), ((1.0, 1.0, 1.8), 1), ((2.0, 2.0, 2.0), 3)])
def test_what_is_conserved_does_not_depend_on_the_scale_of_a_generator(stretch, moments, count):
    scales = np.array([1.0, 1.0, stretch])
    group = MatrixLieGroup.from_generators(scales[:, None, None] * SO(3).generators)
    assert len(conserved_momenta(group, np.diag(scales * moments * scales))) == count
