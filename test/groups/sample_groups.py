"""Groups, bodies on them and exact derivatives of polynomials, for the tests of mechanics on groups."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.groups import SO, SU, U1, Lagrangian, MatrixLieGroup, mass_matrix, product


def unit(i: int, j: int, n: int) -> np.ndarray:
    """The matrix with a single 1."""
    matrix = np.zeros((n, n))
    matrix[i, j] = 1.0
    return matrix


def so4_split() -> np.ndarray:
    """so(4) as self-dual and anti-self-dual halves: two commuting copies of so(3)."""
    left, right = [], []
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        inner = unit(k, j, 4) - unit(j, k, 4)
        outer = unit(i, 0, 4) - unit(0, i, 4)
        left.append(0.5 * (inner + outer))
        right.append(0.5 * (inner - outer))
    return np.array(left + right)


def su3_mixed() -> np.ndarray:
    """su(3) in a skew basis: i times real symmetric traceless, and real antisymmetric matrices, mixed up."""
    basis = [unit(i, j, 3) - unit(j, i, 3) for i in range(3) for j in range(i)]
    basis += [1j * (unit(i, j, 3) + unit(j, i, 3)) for i in range(3) for j in range(i)]
    basis += [1j * (unit(0, 0, 3) - unit(1, 1, 3)), 1j * (unit(1, 1, 3) - unit(2, 2, 3))]
    mixing = np.random.default_rng(5).normal(size=(8, 8)) + 3.0 * np.eye(8)
    return np.einsum("ab,bij->aij", mixing, np.array(basis))


def se3() -> np.ndarray:
    """Rigid motions of space: three rotations, three translations."""
    turns = [unit(2, 1, 4) - unit(1, 2, 4), unit(0, 2, 4) - unit(2, 0, 4), unit(1, 0, 4) - unit(0, 1, 4)]
    return np.array(turns + [unit(i, 3, 4) for i in range(3)])


def heisenberg() -> np.ndarray:
    """Upper triangular 3×3 matrices with [X, Y] = Z."""
    return np.array([unit(0, 1, 3), unit(1, 2, 3), unit(0, 2, 3)])


def sl2() -> np.ndarray:
    """Traceless real 2×2 matrices: H, E, F with [H, E] = 2E, [H, F] = −2F, [E, F] = H."""
    return np.array([unit(0, 0, 2) - unit(1, 1, 2), unit(0, 1, 2), unit(1, 0, 2)])


GENERATED = {
    "so(4)": so4_split,
    "su(3)": su3_mixed,
    "se(3)": se3,
    "Heisenberg": heisenberg,
    "sl(2)": sl2,
}

ALL_COMPACT: dict[str, MatrixLieGroup] = {
    group.name: group
    for group in (
        *(SO(n) for n in range(2, 8)),
        *(SU(n) for n in range(2, 5)),
        U1(),
        product(SO(3), SO(3)),
        product(SO(4), U1(), SU(2)),
    )
}

ALL: dict[str, MatrixLieGroup] = {
    **ALL_COMPACT,
    **{name: MatrixLieGroup.from_generators(make(), name=name) for name, make in GENERATED.items()},
}

ROTATIONS = {n: SO(n) for n in (3, 4, 5, 6)}
UNITARY = {n: SU(n) for n in (2, 3)}


def affine_line() -> MatrixLieGroup:
    """The group of x ↦ ax + b: the smallest that is not compact and not unimodular."""
    return MatrixLieGroup.from_generators([unit(0, 0, 2), unit(0, 1, 2)])


def rigid_motions_of_the_plane() -> MatrixLieGroup:
    """SE(2): a turn and two translations."""
    return MatrixLieGroup.from_generators([unit(1, 0, 3) - unit(0, 1, 3), unit(0, 2, 3), unit(1, 2, 3)])


def skewed_rotations() -> MatrixLieGroup:
    """SO(3) on generators that are neither orthogonal nor of one length."""
    mix = np.array([[1.0, 0.3, 0.0], [0.0, 0.7, -0.4], [0.2, 0.0, 1.5]])
    return MatrixLieGroup.from_generators(np.einsum("ab,bij->aij", mix, SO(3).generators))


COMPACT = {
    "U1": U1(),
    **{f"SO{n}": group for n, group in ROTATIONS.items()},
    **{f"SU{n}": group for n, group in UNITARY.items()},
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


def random_body(group: MatrixLieGroup, seed: int) -> tuple[Lagrangian, np.random.Generator]:
    """A body of random metric, and the generator that goes on."""
    rng = np.random.default_rng(seed)
    return Lagrangian(group, random_metric(rng, group.dimension)), rng


def diagonal_body(group: MatrixLieGroup, moments) -> Lagrangian:
    """A body in n dimensions with these principal second moments."""
    return Lagrangian(group, mass_matrix(np.diag(moments), group.generators))


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
