"""Groups, bodies on them and exact derivatives of polynomials, for the tests of mechanics on groups."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.groups import SO, SU, U1, MatrixLieGroup

ROTATIONS = {n: SO(n) for n in (3, 4, 5, 6)}
UNITARY = {n: SU(n) for n in (2, 3)}


def affine_line() -> MatrixLieGroup:
    """The group of x ↦ ax + b: the smallest that is not compact and not unimodular."""
    return MatrixLieGroup.from_generators(np.array([[[1.0, 0.0], [0.0, 0.0]], [[0.0, 1.0], [0.0, 0.0]]]))


def rigid_motions_of_the_plane() -> MatrixLieGroup:
    """SE(2): a turn and two translations."""
    turn, along, across = np.zeros((3, 3, 3))
    turn[0, 1], turn[1, 0] = -1.0, 1.0
    along[0, 2] = across[1, 2] = 1.0
    return MatrixLieGroup.from_generators(np.array([turn, along, across]))


def skewed_rotations() -> MatrixLieGroup:
    """SO(3) on generators that are neither orthogonal nor of one length."""
    mix = np.array([[1.0, 0.3, 0.0], [0.0, 0.7, -0.4], [0.2, 0.0, 1.5]])
    return MatrixLieGroup.from_generators(np.einsum("ab,bij->aij", mix, SO(3).generators))


COMPACT = {
    "U1": U1(),
    **{f"SO{n}": g for n, g in ROTATIONS.items()},
    **{f"SU{n}": g for n, g in UNITARY.items()},
}
GROUPS = {
    **COMPACT,
    "affine line": affine_line(),
    "SE2": rigid_motions_of_the_plane(),
    "skewed SO3": skewed_rotations(),
}


def random_metric(rng: np.random.Generator, dimension: int) -> np.ndarray:
    """A symmetric positive definite matrix with no symmetry, of condition number at most 10 or so."""
    turned, _ = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    m = turned @ np.diag(rng.uniform(0.5, 3.0, dimension)) @ turned.T
    return (m + m.T) / 2


def diagonal_body(group: MatrixLieGroup, moments: np.ndarray) -> np.ndarray:
    """M of a body in n dimensions with principal second moments kᵢ: −½ tr(K{Tᵃ, Tᵇ})."""
    k, t = np.diag(moments), group.generators
    return -0.5 * np.einsum("ij,ajk,bki->ab", k, t, t) - 0.5 * np.einsum("ij,bjk,aki->ab", k, t, t)


# nodes and weights of a derivative at 0 that is exact for polynomials of degree at most 8
_NODES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0]) / 4.0
_WEIGHTS = np.linalg.solve(np.vander(np.append(_NODES, 0.0), increasing=True).T, np.eye(9)[1])[:8]


def derivative_along(polynomial, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """The derivative of a polynomial of degree at most 8 along a direction, exact but for round-off."""
    size = np.linalg.norm(point) / np.linalg.norm(direction)
    shifted = point + size * _NODES[:, np.newaxis] * direction
    return np.tensordot(_WEIGHTS, polynomial(shifted), axes=1) / size


def gradient(polynomial, point: np.ndarray) -> np.ndarray:
    """Derivatives along all coordinates, shape (d, ...)."""
    return np.array([derivative_along(polynomial, point, e) for e in np.eye(len(point))])


def assert_still(invariants, p, rate):
    """The derivative along ṗ is round-off beside the sizes of gradient and ṗ."""
    sizes = np.linalg.norm(gradient(invariants, p), axis=0) * np.linalg.norm(rate)
    assert np.all(np.abs(derivative_along(invariants, p, rate)) <= 1e-12 * sizes)


def rank(gradients):
    """The rank of gradients (d, count), each measured by its own length."""
    sizes = np.linalg.svd(gradients / np.linalg.norm(gradients, axis=0), compute_uv=False)
    return int(np.sum(sizes > 1e-9))
