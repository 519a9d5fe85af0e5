"""Laws that hold for every matrix Lie group: of its algebra, of its elements, and of the maps between them."""

from __future__ import annotations

import numpy as np
import pytest
from sample_groups import ALL, ALL_COMPACT

from lie_rigid_body.groups import SO, SU, MatrixLieGroup, product
from lie_rigid_body.lie import so3
from sampled import sampled

groups = pytest.mark.parametrize("group", sampled(ALL.values(), every=2), ids=ALL)
compact = pytest.mark.parametrize("group", sampled(ALL_COMPACT.values(), every=2), ids=ALL_COMPACT)


def commutator(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a @ b - b @ a


def close(actual: np.ndarray, expected: np.ndarray, digits: float = 1e-14) -> None:
    """Equal to within a tolerance relative to the largest entry expected, or 1."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=digits * max(1.0, float(np.max(np.abs(expected)))))


def coordinates(group: MatrixLieGroup, seed: int, *shape: int, scale: float = 1.0) -> np.ndarray:
    """Coordinates whose matrices have 2-norm at most `scale` times a number below 1."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(*shape, group.dimension))
    size = np.linalg.norm(group.hat(x), ord=2, axis=(-2, -1))
    return x * (scale * rng.uniform(0.1, 1.0, shape) / size)[..., np.newaxis]


@groups
def test_commutators_are_the_structure_constants(group):
    T, f = group.generators, group.structure_constants
    for a in range(group.dimension):
        close(commutator(T[a], T), np.einsum("bc,cij->bij", f[a], T), 1e-13)


@groups
def test_commutators_with_products_are_the_product_rule(group):
    """[Tᵃ, TᵇTᶜ] = fᵃᶜᵈ TᵇTᵈ + fᵃᵇᵈ TᵈTᶜ, eq. (17), on any group."""
    T, f = group.generators, group.structure_constants
    pairs = np.einsum("bij,cjk->bcik", T, T)
    found = np.einsum("aij,bcjk->abcik", T, pairs) - np.einsum("bcij,ajk->abcik", pairs, T)
    expected = np.einsum("acd,bdik->abcik", f, pairs) + np.einsum("abd,dcik->abcik", f, pairs)
    close(found, expected, 1e-13)


@compact
def test_structure_constants_are_totally_antisymmetric(group):
    f = np.einsum("abe,ec->abc", group.structure_constants, group.trace_metric)
    close(f, -f.transpose(1, 0, 2))
    close(f, -f.transpose(0, 2, 1))


@groups
def test_adjoint_representation_obeys_the_algebra(group):
    """Which is Jacobi's identity."""
    F, f = group.adjoint_representation, group.structure_constants
    for a in range(group.dimension):
        close(commutator(F[a], F), np.einsum("bc,cij->bij", f[a], F), 1e-13)


@groups
def test_ad_is_the_commutator(group):
    x, y = coordinates(group, 1), coordinates(group, 2)
    close(group.hat(group.ad(x) @ y), commutator(group.hat(x), group.hat(y)))
    close(group.ad(x), np.tensordot(x, group.adjoint_representation, 1))


@groups
def test_vee_is_the_inverse_of_hat(group):
    x = coordinates(group, 3, 20)
    close(group.vee(group.hat(x)), x)


@groups
def test_trace_metric_is_the_inner_product_of_the_generators(group):
    x, y = coordinates(group, 4), coordinates(group, 5)
    product_of_matrices = np.real(np.trace(group.hat(x).conj().T @ group.hat(y)))
    product_of_coordinates = x @ group.trace_metric @ y
    unit_scale = np.real(np.trace(group.generators[0].conj().T @ group.generators[0])) / group.trace_metric[0, 0]
    if "×" not in group.name:
        close(product_of_coordinates * unit_scale, product_of_matrices)
    assert np.all(np.linalg.eigvalsh(group.trace_metric) > 0.0)


@groups
def test_group_axioms(group):
    A, B, C = (group.exp(coordinates(group, seed, 10, scale=0.8)) for seed in (6, 7, 8))
    assert group.contains(group.identity)
    close((A @ B) @ C, A @ (B @ C))
    close(A @ group.inverse(A), np.broadcast_to(group.identity, A.shape))
    close(group.exp(-group.log(A)), group.inverse(A))
    assert group.contains(A @ B).all()
    assert group.contains(group.inverse(A)).all()


@groups
def test_Ad_is_a_homomorphism(group):  # noqa: N802
    A, B = group.exp(coordinates(group, 9, 10)), group.exp(coordinates(group, 10, 10))
    x, y = coordinates(group, 11, 10), coordinates(group, 12, 10)
    Ad = group.Ad(A)
    close(group.Ad(A @ B), Ad @ group.Ad(B), 1e-13)
    turned = A @ group.hat(y) @ np.linalg.inv(A)
    close(group.hat(np.einsum("kab,kb->ka", Ad, y)), turned, 1e-13)
    bracket = np.einsum("kab,kb->ka", group.ad(x), y)
    image = np.einsum("kab,kb->ka", group.ad(np.einsum("kab,kb->ka", Ad, x)), np.einsum("kab,kb->ka", Ad, y))
    close(np.einsum("kab,kb->ka", Ad, bracket), image, 1e-13)


@groups
def test_log_is_the_inverse_of_exp(group):
    """Relative to the argument at any size, except where 1 + δ on the diagonal has rounded a small one."""
    rounded = np.finfo(float).eps * np.abs(np.diagonal(group.generators, axis1=1, axis2=2).real).max()
    for scale in (1e-300, 1e-15, 1e-8, 1e-4, 0.1, 0.4, 0.6, 1.0, 2.0, 3.0):
        x = coordinates(group, 14, 10, scale=scale)
        error = np.abs(group.log(group.exp(x)) - x).max()
        assert error <= 2e-14 * np.abs(x).max() * np.exp(2 * scale) + rounded, scale


@compact
def test_log_reaches_close_to_the_half_turn(group):
    x = coordinates(group, 15, 10)
    x *= (np.pi - 1e-3) / np.linalg.norm(group.hat(x), ord=2, axis=(-2, -1))[:, np.newaxis]
    close(group.log(group.exp(x)), x, 1e-11)


@compact
def test_exp_of_log_is_the_element(group):
    A = group.random(np.random.default_rng(16), (40,))
    close(group.exp(group.log(A)), A, 1e-14)


@groups
def test_dexpinv_is_the_inverse_of_dexp(group):
    for scale in (1e-8, 0.1, 1.0, 3.0):
        x = coordinates(group, 17, 10, scale=scale)
        J, inverse = group.dexp(x), group.dexpinv(x)
        condition = np.linalg.norm(J, axis=(-2, -1)).max() * np.linalg.norm(inverse, axis=(-2, -1)).max()
        one = np.broadcast_to(np.eye(group.dimension), J.shape)
        close(J @ inverse, one, 1e-15 * condition)
        close(inverse @ J, one, 1e-15 * condition)


@groups
def test_a_batch_gives_its_rows(group):
    x = coordinates(group, 20, 4, 3, scale=2.9)
    A = group.exp(x)
    for function, argument, rank in (
        (group.hat, x, 1),
        (group.exp, x, 1),
        (group.ad, x, 1),
        (group.dexp, x, 1),
        (group.dexpinv, x, 1),
        (group.vee, group.hat(x), 2),
        (group.log, A, 2),
        (group.Ad, A, 2),
        (group.inverse, A, 2),
        (group.contains, A, 2),
        (group.restored, A, 2),
    ):
        rows = argument.reshape(12, *argument.shape[-rank:])
        each = np.array([function(row) for row in rows])
        batch = function(argument)
        assert batch.shape[:2] == (4, 3)
        close(batch.reshape(each.shape), each, 1e-13)


@groups
def test_a_batch_of_none_is_none(group):
    x = np.zeros((0, group.dimension))
    assert group.log(group.exp(x)).shape == (0, group.dimension)
    assert group.dexpinv(x).shape == (0, group.dimension, group.dimension)
    assert group.restored(group.exp(x)).shape == (0, group.size, group.size)


@groups
def test_random_elements_belong_and_repeat_with_the_seed(group):
    A = group.random(np.random.default_rng(21), (3, 2))
    assert A.shape == (3, 2, group.size, group.size)
    np.testing.assert_array_equal(A, group.random(np.random.default_rng(21), (3, 2)))
    if group.name in ALL_COMPACT:
        assert group.contains(A, 1e-13).all()


@compact
def test_projection_leaves_elements_and_returns_from_nearby(group):
    A = group.exp(coordinates(group, 23, 10))
    close(group.project(A), A)
    noise = 1e-3 * np.random.default_rng(22).normal(size=A.shape)
    back = group.project(A + noise)
    assert group.contains(back, 1e-12).all()
    assert (np.linalg.norm(back - (A + noise), axis=(1, 2)) <= np.linalg.norm(noise, axis=(1, 2)) * (1 + 1e-3)).all()


@compact
def test_projection_is_stationary(group):
    """The way from the projection to the matrix is orthogonal to the group; on SU(n) to first order."""
    A = group.exp(coordinates(group, 24, 6))
    away = A + 1e-4 * np.random.default_rng(25).normal(size=A.shape)
    nearest = group.project(away)
    along = np.einsum("kij,ajl->kail", nearest, group.generators)
    slope = np.real(np.einsum("kail,kil->ka", along.conj(), away - nearest))
    close(slope, np.zeros_like(slope), 1e-13 if "SU" not in group.name else 1e-7)


def test_general_so3_agrees_with_the_rotation_vectors():
    group = SO(3)
    v = np.random.default_rng(26).normal(size=(500, 3))
    angles = np.concatenate([np.logspace(-300, -1, 100), np.linspace(0.1, 3.1, 400)])
    v *= (angles / np.linalg.norm(v, axis=1))[:, np.newaxis]
    np.testing.assert_array_equal(group.generators, so3.hat(np.eye(3)))
    np.testing.assert_array_equal(group.hat(v), so3.hat(v))
    close(group.exp(v), so3.exp(v))
    close(group.dexp(v), so3.left_jacobian(v))
    close(group.dexpinv(v), so3.left_jacobian_inverse(v), 2e-14)
    close(group.log(so3.exp(v)), so3.log(so3.exp(v)))
    close(group.Ad(so3.exp(v)), so3.exp(v))


def test_maps_of_a_product_are_those_of_its_factors():
    first, second = SO(4), SU(3)
    both = product(first, second)
    x, y = coordinates(first, 27), coordinates(second, 28)
    z = np.concatenate([x, y])
    close(both.exp(z)[:4, :4], first.exp(x))
    close(both.exp(z)[4:, 4:], second.exp(y))
    close(both.dexp(z)[:6, :6], first.dexp(x))
    close(both.dexp(z)[6:, 6:], second.dexp(y))
    assert not both.exp(z)[:4, 4:].any()
    assert not both.dexp(z)[:6, 6:].any()
    assert not both.structure_constants[:6, 6:].any()
