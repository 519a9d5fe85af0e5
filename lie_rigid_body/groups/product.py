"""Direct products of matrix groups, as block diagonal matrices."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import accumulate, pairwise, starmap

import numpy as np
from scipy.linalg import block_diag

from lie_rigid_body.foundation.arrays import Array, Sizes, whole_number
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.groups.algebra import MAX_GENERATORS, frobenius
from lie_rigid_body.groups.elements import Elements
from lie_rigid_body.groups.exponential import Matrix
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup


def product(*groups: MatrixLieGroup) -> MatrixLieGroup:
    """The direct product of groups: block diagonal matrices; the coordinates of the factors follow each other.

    Parameters
    ----------
    *groups : MatrixLieGroup
        At least one. The product is complex if a factor is.

    Raises
    ------
    InputError
        If no group is given, an argument is no group, or the dimensions add up to more than 812.
    """
    if not groups:
        raise InputError("product() of 0 groups (limit 1): give at least one group")
    for given in groups:
        if not isinstance(given, MatrixLieGroup):
            raise InputError(
                f"product() of {shown(given)}, which is no MatrixLieGroup: give groups as arguments of their own, "
                "as product(SO(3), SU(2))"
            )
    dtype = np.result_type(*(group.generators.dtype for group in groups))
    d = whole_number("dimension", sum(g.dimension for g in groups), 1, MAX_GENERATORS)
    n = sum(g.size for g in groups)
    T = np.zeros((d, n, n), dtype)
    for group, rows, block in zip(groups, _slices(g.dimension for g in groups), _blocks(groups), strict=True):
        T[rows, block, block] = group.generators
    name = " × ".join(g.name for g in groups)
    metric = block_diag(*(g.trace_metric for g in groups))
    return MatrixLieGroup(T, name, metric, ProductElements(groups), groups)


def _slices(sizes: Iterable[int]) -> Iterator[slice]:
    return starmap(slice, pairwise(accumulate(sizes, initial=0)))


def _blocks(groups: tuple[MatrixLieGroup, ...]) -> Iterator[slice]:
    return _slices(group.size for group in groups)


class ProductElements(Elements):
    """Block diagonal matrices whose blocks are elements of the factors.

    Parameters
    ----------
    groups : tuple of MatrixLieGroup
    """

    def __init__(self, groups: tuple[MatrixLieGroup, ...]) -> None:
        self._factors = [
            (g.elements, s, np.iscomplexobj(g.generators)) for g, s in zip(groups, _blocks(groups), strict=True)
        ]

    def _parts(self, A: Matrix) -> Iterator[tuple[Elements, slice, Matrix]]:
        for elements, block, is_complex in self._factors:
            part = A[..., block, block]
            yield elements, block, part if is_complex else part.real

    def _blockwise(self, A: Matrix, function: Callable[[Elements, Matrix], Matrix]) -> Matrix:
        result = np.zeros_like(A)
        for elements, block, part in self._parts(A):
            result[..., block, block] = function(elements, part)
        return result

    def distance(self, A: Matrix) -> Array:
        """The largest of the blocks' distances and the Frobenius norm of what lies outside the blocks."""
        return self._largest(A, lambda elements, part: elements.distance(part))

    def certain_distance(self, A: Matrix) -> Array:
        """The largest of the blocks' certain distances and the Frobenius norm of what lies outside the blocks."""
        return self._largest(A, lambda elements, part: elements.certain_distance(part))

    def _largest(self, A: Matrix, distance: Callable[[Elements, Matrix], Array]) -> Array:
        outside = frobenius(A - self._blockwise(A, lambda _, part: part))
        return np.max([outside, *(distance(elements, part) for elements, _, part in self._parts(A))], axis=0)

    def project(self, A: Matrix) -> Matrix:
        """The nearest element of each factor to its block."""
        return self._blockwise(A, lambda elements, part: elements.project(part))

    def restored(self, A: Matrix) -> Matrix:
        """Each block projected by its own factor."""
        return self._blockwise(A, lambda elements, part: elements.restored(part))

    def inverse(self, A: Matrix) -> Matrix:
        """The inverse of each block."""
        return self._blockwise(A, lambda elements, part: elements.inverse(part))

    def log(self, A: Matrix) -> Matrix:
        """The logarithm of each block."""
        return self._blockwise(A, lambda elements, part: elements.log(part))

    def one_to_one(self, X: Matrix) -> Array:
        """The least multiple of all blocks, shape (...)."""
        return np.asarray(np.min([elements.one_to_one(part) for elements, _, part in self._parts(X)], axis=0))

    def random(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Independent elements of the factors."""
        size = self._factors[-1][1].stop
        dtype = np.complex128 if any(is_complex for *_, is_complex in self._factors) else np.float64
        A = np.zeros((*shape, size, size), dtype)
        return self._blockwise(A, lambda elements, _: elements.random(rng, shape))
