"""Groups known by their generators alone: the check of the generators, and elements recognised by their logarithm."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.lie import exponential, logarithm
from lie_rigid_body.lie.elements import Elements
from lie_rigid_body.lie.matrix_lie_algebra import (
    DEPENDENCE_LIMIT,
    SPAN_TOLERANCE,
    MatrixLieAlgebra,
    flattened,
    frobenius,
)

Array = NDArray[Any]
Real = NDArray[np.float64]

_PROJECTION_STEPS: Final = 50


def closed_algebra(generators: ArrayLike) -> MatrixLieAlgebra:
    """The algebra of generators from outside, checked: shape, independence, closure."""
    T = _as_generators(generators)
    _refuse_dependent(T)
    algebra = MatrixLieAlgebra(T)
    _refuse_open(algebra)
    return algebra


def _as_generators(generators: ArrayLike) -> Array:
    try:
        T = np.asarray(generators)
        T = T.astype(np.complex128 if np.iscomplexobj(T) else np.float64)
    except (TypeError, ValueError):
        raise InputError("generators need shape (d, n, n), given rows of unequal length or no numbers") from None
    if T.ndim != 3 or T.shape[1] != T.shape[2] or 0 in T.shape:
        raise InputError(f"generators need shape (d, n, n) with d, n ≥ 1, given {T.shape}: stack square matrices")
    if not np.all(np.isfinite(T)):
        worst = int(np.argmin(np.isfinite(T).all(axis=(1, 2))))
        raise InputError(f"T{worst} has an entry that is not a finite number: give finite generators")
    return T


def _refuse_dependent(T: Array) -> None:
    """An error that names the first generator in the span of those before it."""
    size = frobenius(T)
    if np.any(size == 0.0):
        raise InputError(f"T{int(np.argmin(size))} is zero: leave it out")
    flat = flattened(T) / size[:, np.newaxis]
    if len(flat) <= flat.shape[1] and np.linalg.svd(flat, compute_uv=False)[-1] > DEPENDENCE_LIMIT:
        return
    for k in range(1, len(flat)):
        weights = np.linalg.lstsq(flat[:k].T, flat[k], rcond=None)[0]
        if np.linalg.norm(flat[k] - weights @ flat[:k]) <= DEPENDENCE_LIMIT * np.sqrt(len(flat)):
            raise InputError(_dependence(k, weights * size[k] / size[:k]))
    raise InputError(f"the generators are dependent to within {DEPENDENCE_LIMIT:g}: give fewer or more distinct ones")


def _dependence(k: int, weights: Real) -> str:
    kept = np.flatnonzero(np.abs(weights) > DEPENDENCE_LIMIT * np.max(np.abs(weights)))
    combination = " ".join(f"{weights[j]:+.3g} T{j}" for j in kept)
    return f"the generators are dependent, T{k} = {combination} over the reals: leave one of these out"


def _refuse_open(algebra: MatrixLieAlgebra) -> None:
    """An error that names the commutator farthest outside the span."""
    T, size = algebra.generators, frobenius(algebra.generators)
    off = np.stack([algebra.off_span(t @ T - T @ t) for t in T])
    allowed = SPAN_TOLERANCE * np.outer(size, size)
    if np.all(off <= allowed):
        return
    a, b = np.unravel_index(np.argmax(np.where(off > allowed, off, 0.0)), off.shape)
    raise InputError(
        f"[T{a}, T{b}] leaves the span by {off[a, b]:.3g} (limit {allowed[a, b]:.3g}), "
        f"one of {np.count_nonzero(off > allowed) // 2} commutators that do: add the matrices that it needs"
    )


class GeneratedElements(Elements):
    """Elements near enough to the identity for their principal logarithm to tell them.

    Parameters
    ----------
    algebra : MatrixLieAlgebra
    """

    def __init__(self, algebra: MatrixLieAlgebra) -> None:
        self._algebra = algebra

    def distance(self, A: Array) -> Real:
        """Distance of the principal logarithm from the algebra; infinite where there is none."""
        logs = np.array([_principal_or_nan(matrix) for matrix in A.reshape(-1, *A.shape[-2:])]).reshape(A.shape)
        off = self._algebra.off_span(np.nan_to_num(logs))
        return np.where(np.isfinite(logs).all(axis=(-2, -1)), off, np.inf)

    def project(self, A: Array) -> Array:
        """The nearest element, by Gauss–Newton steps B ← B exp(ξ) from the exponential of the logarithm's nearest."""
        B = exponential.exp(self._algebra.hat(self._algebra.coordinates(self.log(A))))
        nearest = [self._nearest(*pair) for pair in zip(*(m.reshape(-1, *m.shape[-2:]) for m in (A, B)), strict=True)]
        return np.array(nearest).reshape(A.shape)

    def restored(self, A: Array) -> Array:
        """The matrices as they are: a principal logarithm may lead to another sheet of the group, or not exist."""
        return A

    def _nearest(self, A: Array, B: Array) -> Array:
        for _ in range(_PROJECTION_STEPS):
            tangents = flattened(B @ self._algebra.generators)
            xi = np.linalg.lstsq(tangents.T, flattened(A - B), rcond=None)[0]
            B = B @ exponential.exp(self._algebra.hat(xi))
            if np.linalg.norm(xi) <= 1e-15 * np.linalg.norm(B):
                break
        return B

    def inverse(self, A: Array) -> Array:
        """The inverse by elimination."""
        return np.asarray(np.linalg.inv(A))

    def log(self, A: Array) -> Array:
        """The principal logarithm."""
        logs = np.array([_principal_or_nan(matrix) for matrix in A.reshape(-1, *A.shape[-2:])]).reshape(A.shape)
        if not np.all(np.isfinite(logs)):
            raise InputError(
                "no principal logarithm: a matrix is singular or has an eigenvalue on the negative real axis "
                f"(within {logarithm.HALF_TURN_MARGIN:g} rad); give an element closer to the identity"
            )
        return logs

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Exponentials of standard normal coordinates."""
        return exponential.exp(self._algebra.hat(rng.standard_normal((*shape, self._algebra.dimension))))


def _principal_or_nan(A: Array) -> Array:
    """The principal logarithm of one matrix, shape (n, n), or NaN where it has none."""
    nothing = np.full_like(A, np.nan)
    eigenvalues = np.linalg.eigvals(A)
    if np.any(np.pi - np.abs(np.angle(eigenvalues)) <= logarithm.HALF_TURN_MARGIN) or np.any(eigenvalues == 0.0):
        return nothing
    with np.errstate(all="ignore"):
        try:
            L = logarithm.principal(A)
            back = exponential.exp(L)
        except np.linalg.LinAlgError:
            return nothing
    # far from normal matrices can lose all digits on the way
    return L if np.abs(back - A).max() <= SPAN_TOLERANCE * max(1.0, float(np.abs(A).max())) else nothing
