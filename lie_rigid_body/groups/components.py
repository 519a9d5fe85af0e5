"""Components along the generators of a group: rates, momenta and gradients as arrays of the right length."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError

if TYPE_CHECKING:
    from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup


def require_components(group: MatrixLieGroup, values: ArrayLike, what: str) -> NDArray[np.float64]:
    """The values as float64 components, or a refusal.

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    values : array_like, shape (..., d)
    what : str
        What they are, in the plural, for the message.

    Returns
    -------
    ndarray, shape (..., d)

    Raises
    ------
    InputError
        If they are not real numbers, or the last axis is not of length d.
    """
    d = group.dimension
    try:
        given = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"{what} on {group.name} have rows of unequal length: give {d} real numbers") from None
    if given.dtype.kind not in "fiu":
        raise InputError(f"{what} on {group.name} are of type {given.dtype}: give {d} real numbers")
    array = given.astype(np.float64, copy=False)
    if array.ndim == 0 or array.shape[-1] != d:
        raise InputError(
            f"{what} on {group.name} need shape (..., {d}), given {array.shape}: put the components on the last axis"
        )
    return array
