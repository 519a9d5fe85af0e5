"""Groups known by their generators alone: the check of the generators, and elements recognised by their logarithm."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups import exponential, logarithm
from lie_rigid_body.groups.elements import Elements
from lie_rigid_body.groups.matrix_lie_algebra import (
    DEPENDENCE_LIMIT,
    SPAN_TOLERANCE,
    MatrixLieAlgebra,
    flattened,
    frobenius,
)

Array = NDArray[Any]
Real = NDArray[np.float64]

SIZE_LIMIT: Final = 1e50
"""Generators with larger entries, or with all entries below its inverse, have products beyond a double."""

PROJECTION_REACH: Final = 0.5
"""Frobenius norm of B⁻¹A − 1 up to which an element B counts as near a matrix A."""

SINGULAR_LIMIT: Final = 1e15
"""Condition number, rows and columns of equal size, from which a matrix is singular to within rounding."""

_ENTRY_ERROR: Final = 1e-12
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
    _refuse_sizes(np.abs(T).max(axis=(1, 2)))
    size = frobenius(T)
    flat = flattened(T) / size[:, np.newaxis]
    if len(flat) <= flat.shape[1] and np.linalg.svd(flat, compute_uv=False)[-1] > DEPENDENCE_LIMIT:
        return
    for k in range(1, len(flat)):
        weights = np.linalg.lstsq(flat[:k].T, flat[k], rcond=None)[0]
        if np.linalg.norm(flat[k] - weights @ flat[:k]) <= DEPENDENCE_LIMIT * np.sqrt(len(flat)):
            raise InputError(_dependence(k, weights * size[k] / size[:k]))
    raise InputError(f"the generators are dependent to within {DEPENDENCE_LIMIT:g}: give fewer or more distinct ones")


def _refuse_sizes(largest: Real) -> None:
    """An error that names a generator whose largest entry is none, or whose products leave the range of a double."""
    if np.any(largest == 0.0):
        raise InputError(f"T{int(np.argmin(largest))} is zero: leave it out")
    beyond = (largest > SIZE_LIMIT) | (largest < 1.0 / SIZE_LIMIT)
    if np.any(beyond):
        worst = int(np.argmax(beyond))
        raise InputError(
            f"the largest entry of T{worst} is {largest[worst]:.3g} (limits {1.0 / SIZE_LIMIT:g} and {SIZE_LIMIT:g}): "
            "rescale it, which changes the unit of its coordinate alone"
        )


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
        logs = _principal_logs(A)
        off = self._algebra.off_span(np.nan_to_num(logs))
        return np.where(np.isfinite(logs).all(axis=(-2, -1)), off, np.inf)

    def certain_distance(self, A: Array) -> Real:
        """The larger of what rules a matrix out: its determinant, or what its Ad moves out of the algebra.

        Infinite for a matrix that is singular to within rounding. Others of a large condition number are let off what
        an error of 1e-12 in the entries of an element would add.
        """
        regular = _condition(_equilibrated(A)) < SINGULAR_LIMIT
        A = np.where(regular[..., np.newaxis, np.newaxis], A, np.eye(A.shape[-1]))
        off = np.maximum(self._off_determinants(A), self._off_normaliser(A))
        return np.where(regular, off / np.maximum(1.0, _ENTRY_ERROR / SPAN_TOLERANCE * _condition(A)), np.inf)

    def _off_determinants(self, A: Array) -> Real:
        """How far log det A, shape (...), is from the traces of the algebra, if these are all real or all imaginary."""
        traces = np.trace(self._algebra.generators, axis1=-2, axis2=-1)
        negligible = SPAN_TOLERANCE * frobenius(self._algebra.generators)
        sign, modulus = np.linalg.slogdet(A)
        real = np.where(np.all(np.abs(traces.real) <= negligible), modulus, 0.0)
        imaginary = np.where(np.all(np.abs(traces.imag) <= negligible), np.angle(sign), 0.0)
        return np.hypot(real, imaginary)

    def _off_normaliser(self, A: Array) -> Real:
        """How far A Tᵃ A⁻¹ leaves the algebra at most, relative to Tᵃ, shape (...)."""
        T, each = self._algebra.generators, A[..., np.newaxis, :, :]
        off = self._algebra.off_span(each @ T @ np.linalg.inv(each)) / frobenius(T)
        return np.asarray(off.max(axis=-1))

    def project(self, A: Array) -> Array:
        """The nearest element near a matrix, from the exponential of what its logarithm has in the algebra."""
        logs = _principal_logs(A)
        _refuse_without_logarithm(logs)
        B = exponential.exp(self._algebra.hat(self._algebra.coordinates(logs)))
        nearest = [self._nearest(*pair) for pair in zip(*(m.reshape(-1, *m.shape[-2:]) for m in (A, B)), strict=True)]
        return np.array(nearest).reshape(A.shape)

    def restored(self, A: Array) -> Array:
        """The matrices as they are: a principal logarithm may lead to another sheet of the group, or not exist."""
        return A

    def _nearest(self, A: Array, B: Array) -> Array:
        """The element nearest to A, shape (n, n), by Gauss–Newton steps B ← B exp(ξ) from an element near it."""
        for _ in range(_PROJECTION_STEPS):
            # far from A the steps would lead to some other element
            _refuse_far(A, B)
            tangents = flattened(B @ self._algebra.generators)
            xi = np.linalg.lstsq(tangents.T, flattened(A - B), rcond=None)[0]
            B = B @ exponential.exp(self._algebra.hat(xi))
            if np.linalg.norm(xi) <= 1e-15 * np.linalg.norm(B):
                break
        _refuse_far(A, B)
        return B

    def inverse(self, A: Array) -> Array:
        """The inverse by elimination."""
        return np.asarray(np.linalg.inv(A))

    def log(self, A: Array) -> Array:
        """The principal logarithm, where it lies in the algebra."""
        logs = _principal_logs(A)
        _refuse_without_logarithm(logs)
        worst = np.max(self._algebra.off_span(logs), initial=0.0)
        if not worst <= SPAN_TOLERANCE:
            raise InputError(
                f"a matrix is not recognised as an element: its principal logarithm leaves the span of the generators "
                f"by {worst:.3g} (limit {SPAN_TOLERANCE:g}); give an element closer to the identity"
            )
        return logs

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Exponentials of standard normal coordinates."""
        return exponential.exp(self._algebra.hat(rng.standard_normal((*shape, self._algebra.dimension))))


def _condition(A: Array) -> Real:
    """Ratio of the largest and the smallest singular value, shape (...), or infinity."""
    sizes = np.linalg.svd(A, compute_uv=False)
    smallest = sizes[..., -1]
    return np.where(smallest > 0.0, sizes[..., 0] / np.where(smallest > 0.0, smallest, 1.0), np.inf)


def _equilibrated(A: Array) -> Array:
    """Matrices with columns, then rows, divided by their largest entries: singular only if the given ones are."""
    for axis in (-2, -1):
        largest = np.abs(A).max(axis=axis, keepdims=True)
        A = A / np.where(largest > 0.0, largest, 1.0)
    return A


def _refuse_far(A: Array, B: Array) -> None:
    far = float(np.linalg.norm(np.linalg.solve(B, A - B)))
    if not far <= PROJECTION_REACH:
        raise InputError(
            f"no nearest element found: the principal logarithm leads to one that is {far:.3g} of its size away (limit "
            f"{PROJECTION_REACH:g}); give a matrix nearer to an element that contains() recognises"
        )


def _refuse_without_logarithm(logs: Array) -> None:
    if not np.all(np.isfinite(logs)):
        raise InputError(
            "no principal logarithm: a matrix is singular, far from normal, or has an eigenvalue on the negative real "
            f"axis (within {logarithm.HALF_TURN_MARGIN:g} rad); give an element closer to the identity"
        )


def _principal_logs(A: Array) -> Array:
    """The principal logarithms of matrices, shape (..., n, n), NaN where there is none."""
    return np.array([_principal_or_nan(matrix) for matrix in A.reshape(-1, *A.shape[-2:])]).reshape(A.shape)


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
