"""The metric of a group: masses, and the connection that it makes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from sample_groups import GROUPS, random_body, random_metric

from lie_rigid_body.groups import (
    SO,
    GroupMovingChart,
    GroupState,
    Lagrangian,
    chart_metric,
    christoffel_symbols,
    connection_coefficients,
    mass_matrix,
    metric_at,
    metric_derivative,
    require_metric,
)
from lie_rigid_body.mechanics import (
    inertia_from_second_moment,
    moments_of_density,
    moments_of_points,
    rotated_second_moment,
)
from random_masses import dimensions, plane_generators, random_points, rotation_of, seeds

UNIT = np.eye(3)


@given(dimensions, seeds)
def test_kinetic_energy_is_that_of_the_points(n, seed):
    """½ Σ m |ẋ|² with ẋ = A Ω y in body components, and with ẋ = Ω A y in world components."""
    rng = np.random.default_rng(seed)
    y, m = random_points(n, rng)
    T, A = plane_generators(n), rotation_of(n, rng)
    rate = rng.normal(size=len(T))
    turn = np.tensordot(rate, T, 1)
    K = moments_of_points(y, m).second_moment
    for velocities, M in (
        ([A @ turn @ point for point in y], mass_matrix(K, T)),
        ([turn @ A @ point for point in y], mass_matrix(K, T, A)),
    ):
        energy = sum(0.5 * a * v @ v for a, v in zip(m, velocities, strict=True))
        assert 0.5 * rate @ M @ rate == pytest.approx(energy, rel=1e-11)
        np.testing.assert_array_equal(M, M.T)


@given(dimensions, seeds)
def test_the_formula_of_the_paper_entry_by_entry(n, seed):
    rng = np.random.default_rng(seed)
    K, A = moments_of_points(*random_points(n, rng)).second_moment, rotation_of(n, rng)
    change = rng.normal(size=(n * (n - 1) // 2,) * 2)
    T = np.tensordot(change, plane_generators(n), 1)
    turned = A @ K @ A.T
    expected = [[-0.5 * np.trace(turned @ (a @ b + b @ a)) for b in T] for a in T]
    scale = np.abs(expected).max()
    np.testing.assert_allclose(mass_matrix(K, T, A), expected, rtol=0, atol=1e-13 * scale)


def cloud(x):
    """A density without any symmetry."""
    return np.exp(x @ np.linspace(0.3, 0.9, x.shape[1]) - x[:, 0] * x[:, -1])


def nodes_of(ends):
    """Gauss–Legendre nodes and weights in a box."""
    roots, weights = np.polynomial.legendre.leggauss(14)
    axes = [0.5 * (b + a) + 0.5 * (b - a) * roots for a, b in ends]
    sizes = [0.5 * (b - a) * weights for a, b in ends]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(ends))
    return x, np.prod(np.stack(np.meshgrid(*sizes, indexing="ij"), axis=-1).reshape(-1, len(ends)), axis=1)


@pytest.mark.parametrize("ends", [[(-1.0, 0.5), (0.2, 2.0)], [(-0.5, 0.7), (0.1, 1.0), (-0.3, 0.2)]], ids=["2D", "3D"])
def test_a_body_given_by_a_density_has_the_energy_of_its_integral(ends):
    """½ ∫ρ|u̇|² of u̇ = Ȧx, ½ tr(KȦᵀȦ) and ½ Mᵃᵇωᵃωᵇ are one number, with the integrals K and M taken here."""
    n = len(ends)
    group, rng = SO(n), np.random.default_rng(n)
    x, volumes = nodes_of(ends)
    masses = volumes * cloud(x)
    A, w = group.random(rng), rng.normal(size=group.dimension)
    velocity = A @ group.hat(w)
    energy = 0.5 * masses @ np.sum((x @ velocity.T) ** 2, axis=1)
    K = moments_of_density(cloud, ends).second_moment
    np.testing.assert_allclose(K, np.einsum("m,mi,mj->ij", masses, x, x), rtol=1e-11)
    assert 0.5 * np.trace(K @ velocity.T @ velocity) == pytest.approx(energy, rel=1e-11)
    assert Lagrangian(group, mass_matrix(K, group.generators)).value(w) == pytest.approx(energy, rel=1e-11)


def test_the_inertia_of_a_density_is_its_integrals():
    """M¹¹ = ∫ρ (y² + z²), M¹² = −∫ρ xy and the cyclic permutations."""
    ends = [(-0.5, 0.7), (0.1, 1.0), (-0.3, 0.2)]
    x, volumes = nodes_of(ends)
    masses = volumes * cloud(x)
    expected = np.empty((3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        expected[i, i] = masses @ (x[:, j] ** 2 + x[:, k] ** 2)
        expected[i, j] = expected[j, i] = -masses @ (x[:, i] * x[:, j])
    K = moments_of_density(cloud, ends).second_moment
    np.testing.assert_allclose(mass_matrix(K, SO(3).generators), expected, rtol=1e-11)
    np.testing.assert_allclose(inertia_from_second_moment(K), expected, rtol=1e-11)


def test_the_inertia_of_a_point_reads_off_the_anticommutators():
    """−½ xᵀ{Tᵃ, Tᵇ}x of a unit mass at x, with the printed anticommutators (27a), (27b) and their permutations."""
    square, mixed = np.diag([0.0, -2.0, -2.0]), np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    T, shift = SO(3).generators, np.eye(3)[[1, 2, 0]]
    for a in range(3):
        b = (a + 1) % 3
        np.testing.assert_array_equal(T[a] @ T[a] + T[a] @ T[a], square)
        np.testing.assert_array_equal(T[a] @ T[b] + T[b] @ T[a], mixed)
        for x in np.random.default_rng(a).normal(size=(4, 3)):
            found = mass_matrix(np.outer(x, x), T)
            assert found[a, a] == pytest.approx(-0.5 * x @ square @ x, rel=1e-13)
            assert found[a, b] == pytest.approx(-0.5 * x @ mixed @ x, rel=1e-13)
        square, mixed = shift.T @ square @ shift, shift.T @ mixed @ shift


@pytest.mark.parametrize("name", GROUPS)
def test_the_derivative_of_the_metric_is_its_change_along_the_group(name):
    """∂M/∂α of M at exp(αᵃTᵃ)A₀, by central differences: minus the right-hand side that is printed as (32)."""
    group = GROUPS[name]
    body, rng = random_body(group, 91)
    A, h = group.random(rng), 1e-4
    units = h * np.eye(group.dimension)
    measured = np.array([metric_at(body, group.exp(e) @ A) - metric_at(body, group.exp(-e) @ A) for e in units])
    here, f = metric_at(body, A), group.structure_constants
    found = metric_derivative(group, here)
    scale = np.abs(here).max()
    np.testing.assert_allclose(found, measured / (2 * h), rtol=0, atol=1e-6 * scale)
    printed = np.einsum("abd,dc->abc", f, here) + np.einsum("acd,bd->abc", f, here)
    np.testing.assert_allclose(found, -printed, rtol=0, atol=1e-12 * scale)
    assert name == "U1" or np.abs(found).max() > 1e-2 * scale


def test_attitudes_are_batched():
    rng = np.random.default_rng(1)
    K, T = moments_of_points(*random_points(4, rng)).second_moment, plane_generators(4)
    attitudes = rotation_of(4, rng)[None, None] @ np.stack([rotation_of(4, rng) for _ in range(6)]).reshape(2, 3, 4, 4)
    M, turned = mass_matrix(K, T, attitudes), rotated_second_moment(K, attitudes)
    assert M.shape == (2, 3, 6, 6)
    assert turned.shape == (2, 3, 4, 4)
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(M[index], mass_matrix(K, T, attitudes[index]), rtol=0, atol=1e-13 * M.max())
        np.testing.assert_allclose(
            turned[index], rotated_second_moment(K, attitudes[index]), rtol=0, atol=1e-13 * np.trace(K)
        )


def test_a_metric_symmetric_to_round_off_is_averaged_and_others_are_kept_to_the_bit():
    m = random_metric(np.random.default_rng(8), 3)
    kept = require_metric(m, 3)
    np.testing.assert_array_equal(kept, m)
    assert kept is not m
    m[0, 1] += 4e-16
    averaged = require_metric(m, 3)
    np.testing.assert_array_equal(averaged, averaged.T)


@pytest.mark.parametrize("name", GROUPS)
def test_it_has_no_torsion_and_keeps_the_metric(name):
    """The two conditions that single it out: ∇_X Y − ∇_Y X = [X, Y], and ⟨∇_X Y, Z⟩ + ⟨Y, ∇_X Z⟩ = 0."""
    body, _ = random_body(GROUPS[name], 71)
    gamma = connection_coefficients(body)
    np.testing.assert_allclose(gamma - np.swapaxes(gamma, 0, 1), body.group.structure_constants, atol=1e-12)
    lowered = gamma @ body.metric
    np.testing.assert_allclose(lowered, -np.swapaxes(lowered, 1, 2), atol=1e-12)


@pytest.mark.parametrize("name", GROUPS)
def test_its_geodesics_are_the_motions(name):
    body, rng = random_body(GROUPS[name], 71)
    w = rng.normal(size=(5, body.group.dimension))
    for symbols in (connection_coefficients(body), christoffel_symbols(body)):
        np.testing.assert_allclose(-np.einsum("abc,na,nb->nc", symbols, w, w), body.acceleration(w), atol=1e-12)


@pytest.mark.parametrize("name", GROUPS)
def test_christoffel_symbols_are_those_of_the_metric_in_the_chart(name):
    """Γᶜ_ab = ½ Gᶜᵈ (∂_a G_db + ∂_b G_da − ∂_d G_ab) at the centre, by central differences of G(β)."""
    body, _ = random_body(GROUPS[name], 71)
    h = 1e-4
    slope = np.array([chart_metric(body, h * e) - chart_metric(body, -h * e) for e in np.eye(body.group.dimension)])
    slope = slope / (2 * h)
    lowered = 0.5 * (np.einsum("adb->abd", slope) + np.einsum("bda->abd", slope) - np.einsum("dab->abd", slope))
    np.testing.assert_allclose(christoffel_symbols(body), lowered @ body.inverse_metric, atol=1e-6)


@pytest.mark.parametrize("name", ["SO3", "SU2", "SE2", "affine line"])
def test_a_motion_has_the_length_of_its_energy_and_no_detour_is_shorter(name):
    """Between near points: paths A exp(ε hat η) of the same ends are longer, and by the order of ε²."""
    body, rng = random_body(GROUPS[name], 71)
    group, d, step = body.group, body.group.dimension, 2e-3
    t = step * np.arange(201)
    start = GroupState(group.exp(0.3 * rng.normal(size=d)), rng.normal(size=d))
    path = GroupMovingChart(body, start, max_step=step).at(np.rint(1e9 * t).astype(np.int64)).element

    def length(elements):
        chords = group.log(group.inverse(elements[:-1]) @ elements[1:])
        return np.sqrt(np.einsum("na,ab,nb->n", chords, body.metric, chords)).sum()

    straight = length(path)
    assert straight == pytest.approx(t[-1] * np.sqrt(2.0 * body.value(start.rate)), rel=1e-6)
    bump = np.outer(np.sin(np.pi * t / t[-1]), rng.normal(size=d))
    near, far = (length(path @ group.exp(size * bump)) - straight for size in (1e-2, 2e-2))
    assert near > 0.0
    assert far / near == pytest.approx(4.0, rel=0.05)
