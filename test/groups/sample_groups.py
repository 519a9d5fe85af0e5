"""Groups and algebras that the tests of this folder go through, written down without the package's own bases."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.groups import SO, SU, U1, MatrixLieGroup, product


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

COMPACT: dict[str, MatrixLieGroup] = {
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
    **COMPACT,
    **{name: MatrixLieGroup.from_generators(make(), name=name) for name, make in GENERATED.items()},
}
