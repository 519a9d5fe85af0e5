"""Reading the arrays that a caller gives: checked and converted once, or refused with an error that names them."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, Shape, Sizes, real_array
from lie_rigid_body.foundation.errors import ParameterError

if TYPE_CHECKING:
    from typing_extensions import Self

ROUND_OFF: Final = 64.0 * sys.float_info.epsilon
"""Rounding error allowed in a given or computed matrix, relative to its largest entry or eigenvalue."""

ORTHOGONAL_TOLERANCE: Final = 1e-9
"""Largest entry of AᵀA − 1 with which a matrix A still counts as a rotation."""


def require_share(name: str, values: Array, unit: str) -> None:
    """Refuse masses, densities or weights of which one is negative or all are 0.

    Raises
    ------
    ParameterError
    """
    if values.min() < 0.0 or not values.max() > 0.0:
        worst = values.min() if values.min() < 0.0 else values.max()
        raise ParameterError(name, f"{worst:.9g}{unit} is not allowed: give values of at least 0, some above 0")


def positive(name: str, value: ArrayLike, unit: str, shape: Shape = ()) -> Array:
    """An argument as finite real numbers above 0; see `real_array`.

    Parameters
    ----------
    name : str
    value : array_like
    unit : str
        Unit in the message.
    shape : tuple, optional
        A single number by default.

    Returns
    -------
    ndarray

    Raises
    ------
    ParameterError
    """
    array = real_array(name, value, shape)
    if not array.min() > 0.0:
        raise ParameterError(name, f"{array.min():.9g} {unit} is not positive: give more than 0 {unit}")
    return array


def symmetric_matrix(name: str, value: ArrayLike) -> Array:
    """A symmetric matrix, rid of the round-off of its asymmetry.

    Parameters
    ----------
    name : str
    value : array_like, shape (n, n)

    Returns
    -------
    ndarray, shape (n, n)
        A copy, exactly symmetric.

    Raises
    ------
    ParameterError
        If the argument is not a finite square matrix, or not symmetric within round-off.
    """
    matrix = real_array(name, value, ("n", "n"))
    gap = np.abs(matrix - matrix.T).max()
    limit = ROUND_OFF * (np.abs(matrix).max())
    if gap > limit:
        raise ParameterError(
            name,
            f"entries across the diagonal differ by {gap:.9g}, more than round-off ({limit:.3g}): "
            "give a symmetric matrix",
        )
    return symmetrised(matrix)


def symmetrised(m: Array) -> Array:
    """The symmetric part (m + mᵀ)/2 of matrices, shape (..., n, n)."""
    return 0.5 * (m + np.swapaxes(m, -1, -2))


def orthogonal_matrix(name: str, value: ArrayLike, n: int) -> Array:
    """Rotations of n dimensions, or reflections.

    Parameters
    ----------
    name : str
    value : array_like, shape (..., n, n)
    n : int

    Returns
    -------
    ndarray, shape (..., n, n)

    Raises
    ------
    ParameterError
        If the shape is another or AᵀA is not 1 within `ORTHOGONAL_TOLERANCE`.
    """
    matrices = real_array(name, value, (..., n, n))
    worst = np.abs(matrices.swapaxes(-1, -2) @ matrices - np.eye(n)).max()
    if not worst <= ORTHOGONAL_TOLERANCE:
        raise ParameterError(
            name,
            f"AᵀA differs from 1 by {worst:.3g}, more than {ORTHOGONAL_TOLERANCE:g}: "
            "give an orthogonal matrix, or project it onto the group",
        )
    return matrices


class Immutable:
    """Base class of what is made of its attributes as a whole: each is set once."""

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> None:
        if hasattr(self, name):
            raise AttributeError(f"a {type(self).__name__} is immutable: build a new one instead of setting {name}")
        super().__setattr__(name, value)


class ArraysOnly(Immutable):
    """Base class of what is arrays alone: its slots, each of which is read only."""

    __slots__: tuple[str, ...] = ()

    @property
    def batch_shape(self) -> Sizes:
        """The leading axes: () of one."""
        raise NotImplementedError

    def __len__(self) -> int:
        if not self.batch_shape:
            raise TypeError(f"one {type(self).__name__} has no length")
        return self.batch_shape[0]

    def __bool__(self) -> bool:
        """True, as of any object: without it Python would ask for the length, which one has not."""
        return True

    def __getitem__(self, index: int | slice | Integers | Booleans) -> Self:
        """Those at an index of the first leading axis."""
        if not self.batch_shape:
            raise TypeError(f"one {type(self).__name__} cannot be indexed")
        return self.trusted(*(getattr(self, name)[index] for name in self.__slots__))

    @classmethod
    def trusted(cls, *arrays: Array) -> Self:
        """Make it of arrays that are not checked or copied, in the order of the slots."""
        made = cls.__new__(cls)
        made._hold(*arrays)
        return made

    def joined(self, later: Self) -> Self:
        """These, of N instants, and later ones."""
        pairs = ((getattr(self, name), getattr(later, name)) for name in self.__slots__)
        return self.trusted(*map(np.concatenate, pairs))

    def _hold(self, *arrays: Array) -> None:
        for name, array in zip(self.__slots__, arrays, strict=True):
            array.setflags(write=False)
            setattr(self, name, array)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).trusted, tuple(getattr(self, name) for name in self.__slots__)
