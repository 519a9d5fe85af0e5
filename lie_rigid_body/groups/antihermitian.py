"""Reading antisymmetric and anti-Hermitian matrices at the edge: momenta of SO(n) and SU(n) as matrices."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError

Array = NDArray[np.float64]

_ROUND_OFF: Final = 64.0 * float(np.finfo(np.float64).eps)


def antisymmetric_matrices(name: str, value: ArrayLike) -> Array:
    """Real matrices that are antisymmetric to within round-off.

    Parameters
    ----------
    name : str
        What they are called in the message.
    value : array_like, shape (..., n, n)
        There may be none, and n may be 0.

    Returns
    -------
    ndarray, shape (..., n, n)

    Raises
    ------
    InputError
        If they are not square, real, finite and antisymmetric.
    """
    given = _square_matrices(name, value)
    if np.iscomplexobj(given):
        raise InputError(f"{name}: complex numbers: give a real antisymmetric matrix")
    given = given.astype(np.float64, copy=False)
    _require_small(name, given, given + np.swapaxes(given, -1, -2), "P + Pᵀ", "an antisymmetric")
    return given


def antihermitian_matrices(name: str, value: ArrayLike) -> NDArray[np.complex128]:
    """Matrices that are anti-Hermitian to within round-off.

    Parameters
    ----------
    name : str
        What they are called in the message.
    value : array_like, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)

    Raises
    ------
    InputError
        If they are not square, finite and anti-Hermitian.
    """
    given = _square_matrices(name, value).astype(np.complex128, copy=False)
    _require_small(name, given, given + np.swapaxes(given.conj(), -1, -2), "P + P†", "an anti-Hermitian")
    return given


def _square_matrices(name: str, value: ArrayLike) -> NDArray[Any]:
    try:
        given = np.asarray(value)
    except (TypeError, ValueError):
        raise InputError(f"{name}: rows of unequal length: give square matrices") from None
    if given.dtype.kind not in "fiuc":
        raise InputError(f"{name}: type {given.dtype} is not numbers: give square matrices")
    if given.ndim < 2 or given.shape[-1] != given.shape[-2]:
        raise InputError(f"{name}: shape {given.shape} is not (..., n, n): give square matrices")
    if not np.isfinite(given).all():
        raise InputError(f"{name}: {given[~np.isfinite(given)][0]} is not finite: give finite numbers")
    return given


def _require_small(name: str, given: NDArray[Any], sums: NDArray[Any], formula: str, kind: str) -> None:
    off = np.abs(sums).max(axis=(-2, -1), initial=0.0)
    limit = _ROUND_OFF * np.abs(given).max(axis=(-2, -1), initial=0.0)
    if np.any(off > limit):
        worst = np.argmax(off - limit)
        raise InputError(
            f"{name}: {formula} reaches {off.flat[worst]:.3g}, the limit is {limit.flat[worst]:.3g}: give {kind} matrix"
        )
