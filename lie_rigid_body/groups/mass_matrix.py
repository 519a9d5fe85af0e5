"""The inertia of a body on its rotation group, in any dimension."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics.array_input import real_array
from lie_rigid_body.mechanics.second_moment import rotated_second_moment, second_moment_matrix

Array = NDArray[np.float64]

_GENERATOR_ROUND_OFF: Final = 1e-12


def mass_matrix(second_moment: ArrayLike, generators: ArrayLike, attitude: ArrayLike | None = None) -> Array:
    """The inertia of a body on its rotation group, Mᵃᵇ = −½ tr[A₀ K A₀ᵀ {Tᵃ, Tᵇ}] (Lucas, arXiv 1111.1275).

    With it the kinetic energy ½ ∫ρ |ẋ|² of ẋ = ωᵃTᵃ x is ½ Mᵃᵇωᵃωᵇ. For n = 3 in the basis Tᵃ = hat(eₐ) it is the
    usual inertia tensor; for diagonal K on SO(n), in the basis of the coordinate planes (i, j), it is diagonal with
    the entries Kᵢᵢ + Kⱼⱼ.

    Parameters
    ----------
    second_moment : array_like, shape (n, n)
        K in the body frame, kg m².
    generators : array_like, shape (d, n, n)
        Tᵃ, real and antisymmetric: of SO(n), or of a subgroup.
    attitude : array_like, shape (..., n, n), optional
        A₀, body to world. If left out it is 1, and M belongs to the body rate, ẋ = A ωᵃTᵃ y; with it M belongs to the
        world rate, ẋ = ωᵃTᵃ A y.

    Returns
    -------
    ndarray, shape (..., d, d)
        Symmetric, positive semidefinite, kg m². Definite on SO(n) when rank K ≥ n−1.

    Raises
    ------
    InputError
        If K is not positive semidefinite, a generator not antisymmetric, A₀ not orthogonal, or sizes differ.
    """
    K = second_moment_matrix(second_moment)
    T = _antisymmetric_generators(generators, len(K))
    if attitude is not None:
        K = rotated_second_moment(K, attitude)
    # −tr(TᵃKTᵇ) = Σᵢⱼ (TᵃK)ᵢⱼ Tᵇᵢⱼ, since Tᵇ is antisymmetric
    flat = T.reshape(len(T), -1)
    products = (T @ K[..., None, :, :]).reshape(*K.shape[:-2], *flat.shape) @ flat.T
    return np.asarray(0.5 * (products + products.swapaxes(-1, -2)))


def _antisymmetric_generators(generators: ArrayLike, n: int) -> Array:
    T = real_array("generators", generators, "(d, n, n)")
    if T.shape[1:] != (n, n):
        raise InputError(f"generators: shape {T.shape} does not go with a {n}×{n} second moment: give (d, {n}, {n})")
    gap = np.abs(T + T.swapaxes(-1, -2)).max(axis=(-1, -2))
    worst = int(np.argmax(gap))
    if gap[worst] > _GENERATOR_ROUND_OFF * np.abs(T).max():
        raise InputError(
            f"generators: number {worst} plus its transpose has an entry of {gap[worst]:.9g} instead of 0: rotations "
            "of a body have antisymmetric generators, as those of SO(n)"
        )
    return T
