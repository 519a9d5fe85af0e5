"""Covariances of the Kalman filter and the smoother of a linear system with unknown constants, many samples at a time.

The system is x_k = F_k x_(k−1) + B_k θ + w_k and y_k = H_k x_k + D_k θ + m_k, with covariances Q_k of w_k and 1 of m_k.
A block of samples acts as one step does. It changes the covariance P of the state before it, and the information Y of
later readings about its end:

    P ↦ C + A (P⁻¹ + J)⁻¹ Aᵀ,    Y ↦ J + Aᵀ (Y⁻¹ + C)⁻¹ A

C is the covariance after the block of a filter that knew the state before it, J the information of the block's readings
about that state, and A its transition. They are found for all blocks side by side. A loop over the blocks then finds P
and Y at their ends. The samples within follow, again side by side. It is exact, and takes a sixth of the time of a loop
over the samples.

The constants θ begin with the covariance 1, independent of the state. Their number costs little, as they are no part of
the state. An estimate that takes them to be 0 errs by Ψ θ more. Its sensitivity Ψ follows the estimate's own recursion,
with B θ for a turn and D θ for a reading. An innovation tells of them the rows S^(−½) (H Ψ + D), with its covariance S.
Orthogonal transformations add such rows to a triangular R, RᵀR = 1 + Σ rowsᵀ rows, without squaring them; then the
covariance is P + Ψ (RᵀR)⁻¹ Ψᵀ.

References
----------
S. Särkkä, Á. F. García-Fernández, "Temporal parallelization of Bayesian smoothers", IEEE Transactions on Automatic
Control 66 (2021) 299. B. Friedland, "Treatment of bias in recursive filtering", IEEE Transactions on Automatic Control
14 (1969) 359. G. J. Bierman, "Factorization methods for discrete sequential estimation", Academic Press (1977).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Array, Integers

Steps: TypeAlias = Callable[[Integers], tuple[Array, Array, Array, Array, Array]]
"""F (S, n, n), Q (S, n, n), H (S, m, n), B (S, n, c) and D (S, m, c) of S samples by number.

Those after the last change and tell nothing.
"""
Pair: TypeAlias = tuple[Array, Array]
"""A covariance, an information or a transition of states, (..., n, n), and its part for the constants, (..., n, c)."""


class Covariances(NamedTuple):
    """Covariances of each sample's state, shape (N, n, n) each.

    Attributes
    ----------
    before, filtered, smoothed : ndarray
        From the readings before the sample, from those up to it, and from all.
    """

    before: Array
    filtered: Array
    smoothed: Array


def padded(count: int) -> int:
    """Number of samples in blocks of equal length that hold so many: the steps are asked for as many."""
    length = _length(count)
    return length * -(-count // length)


def covariances(steps: Steps, count: int, first: Array, constants: int = 0) -> tuple[Covariances, Covariances]:
    """Covariances of each sample's state, for an estimator that knows the constants, and for one that does not.

    Parameters
    ----------
    steps : callable
    count : int
        Samples, N.
    first : ndarray, shape (n, n)
        Covariance of the state before sample 0.
    constants : int, optional
        Number of constants, c.

    Returns
    -------
    known, unknown : Covariances
    """
    numbers = np.arange(padded(count)).reshape(-1, _length(count)).T
    transition, C, information = _blocks(steps, numbers, len(first), constants)
    before, filtered, rows = _filtered(steps, numbers, _before(transition, C, information, first))
    smoothed = _smoothed(steps, numbers, filtered, _after(transition, C, information))
    added = _added(rows, numbers, before[1], filtered[1], smoothed[1])
    known = Covariances(before[0][:count], filtered[0][:count], smoothed[0][:count])
    return known, Covariances(*(P + more[:count] for P, more in zip(known, added, strict=True)))


def _length(count: int) -> int:
    """Length of a block: loops over the blocks and over the samples of one are as long as each other."""
    return max(1, math.isqrt(count))


def _blocks(steps: Steps, numbers: Integers, n: int, c: int) -> tuple[Pair, Array, Pair]:
    A, C, J = (np.tile(part, (numbers.shape[1], 1, 1)) for part in (np.eye(n), np.zeros((n, n)), np.zeros((n, n))))
    b, g = np.zeros((2, numbers.shape[1], n, c))
    for k in numbers:
        F, Q, H, B, D = steps(k)
        A, b, C = F @ A, F @ b + B, F @ C @ _transposed(F) + Q
        told = np.concatenate([H @ A, H @ b + D], axis=-1)
        gain, weighed = _gain(C, H, told)
        information = _transposed(told[..., :n]) @ weighed
        J, g = J + information[..., :n], g + information[..., n:]
        A, b, C = A - gain @ told[..., :n], b - gain @ told[..., n:], _joseph(C, H, gain)
    return (A, b), C, (J, g)


def _before(transition: Pair, C: Array, information: Pair, first: Array) -> Pair:
    """Covariance and sensitivity before each block."""
    (A, b), (H, D) = transition, _rows(*information)
    found = [(first, np.zeros(b.shape[1:]))]
    for i in range(len(A) - 1):
        P, sensitivity = _updated(*found[-1], H[i], D[i])
        found.append((C[i] + A[i] @ P @ A[i].T, A[i] @ sensitivity + b[i]))
    return _stacked(found)


def _after(transition: Pair, C: Array, information: Pair) -> Pair:
    """Information of the readings after each block on the state at its end."""
    (A, b), (J, g), (H, D) = transition, information, _rows(C, np.zeros_like(transition[1]))
    found = [(np.zeros_like(J[0]), np.zeros_like(g[0]))]
    for i in range(len(A) - 1, 0, -1):
        Y, beside = _updated(*found[-1], H[i], D[i])
        found.append((J[i] + A[i].T @ Y @ A[i], g[i] + A[i].T @ (Y @ b[i] + beside)))
    return _stacked(found[::-1])


def _filtered(steps: Steps, numbers: Integers, start: Pair) -> tuple[Pair, Pair, Array]:
    """Covariance and sensitivity before and after each sample's readings, and the rows that these tell of constants."""
    P, sensitivity = start
    before, after = (
        (np.empty((numbers.size, *P.shape[1:])), np.empty((numbers.size, *sensitivity.shape[1:]))) for _ in range(2)
    )
    rows = []
    for k in numbers:
        F, Q, H, B, D = steps(k)
        before[0][k], before[1][k] = P, sensitivity = F @ P @ _transposed(F) + Q, F @ sensitivity + B
        rows.append(_whitened(P, H, H @ sensitivity + D))
        after[0][k], after[1][k] = P, sensitivity = _updated(P, sensitivity, H, D)
    return before, after, np.array(rows)


def _smoothed(steps: Steps, numbers: Integers, filtered: Pair, later: Pair) -> Pair:
    found = np.empty_like(filtered[0]), np.empty_like(filtered[1])
    Y, g = later
    for k in numbers[::-1]:
        P, sensitivity = filtered[0][k], filtered[1][k]
        found[0][k], found[1][k] = _joined(P, sensitivity - P @ g, Y)
        F, Q, H, B, D = steps(k)
        Y, g = _joined(Y + _transposed(H) @ H, g + _transposed(H) @ D, Q)
        Y, g = _transposed(F) @ Y @ F, _transposed(F) @ (Y @ B + g)
    return found


def _added(rows: Array, numbers: Integers, before: Array, filtered: Array, smoothed: Array) -> tuple[Array, ...]:
    """Covariances that the constants add before and after each sample's readings, and from all."""
    starts = [np.eye(rows.shape[-1])]
    for block in rows.swapaxes(0, 1):
        starts.append(_factor(starts[-1], np.concatenate(block)))
    R, states = np.array(starts[:-1]), before.shape[-2]
    added = np.empty((2, numbers.size, states, states))
    for k, row in zip(numbers, rows, strict=True):
        added[0, k] = _by_constants(R, before[k])
        R = _factor(R, row)
        added[1, k] = _by_constants(R, filtered[k])
    return (*added, _by_constants(starts[-1], smoothed))


def _factor(R: Array, rows: Array) -> Array:
    return np.linalg.qr(np.concatenate([R, rows], axis=-2), mode="r")


def _by_constants(R: Array, sensitivity: Array) -> Array:
    half = np.linalg.solve(_transposed(R), _transposed(sensitivity))
    return _transposed(half) @ half


def _whitened(P: Array, H: Array, told: Array) -> Array:
    """What innovations tell, divided by a root of their covariance; that has no eigenvalue below 1."""
    values, vectors = np.linalg.eigh(H @ P @ _transposed(H) + np.eye(H.shape[-2]))
    return _transposed(vectors) @ told / np.sqrt(values.clip(1.0))[..., np.newaxis]


def _joined(P: Array, sensitivity: Array, J: Array) -> Pair:
    """Covariance (P⁻¹ + J)⁻¹, also where P has no inverse, and (1 + P J)⁻¹ times the sensitivity."""
    n = P.shape[-1]
    found = np.linalg.solve(np.eye(n) + P @ J, np.concatenate([P, sensitivity], axis=-1))
    P, sensitivity = found[..., :n], found[..., n:]
    return 0.5 * (P + _transposed(P)), sensitivity


def _updated(P: Array, sensitivity: Array, H: Array, D: Array) -> Pair:
    """Covariance and sensitivity after readings."""
    gain, _ = _gain(P, H, H)
    return _joseph(P, H, gain), sensitivity - gain @ (H @ sensitivity + D)


def _gain(P: Array, H: Array, told: Array) -> tuple[Array, Array]:
    """Gain P Hᵀ S⁻¹ with the covariance S of the innovation, and S⁻¹ times what the readings tell."""
    seen = H @ P
    S = seen @ _transposed(H) + np.eye(H.shape[-2])
    both = np.linalg.solve(S, np.concatenate([seen, told], axis=-1))
    return _transposed(both[..., : seen.shape[-1]]), both[..., seen.shape[-1] :]


def _joseph(P: Array, H: Array, gain: Array) -> Array:
    """The covariance after readings in Joseph's form, which stays symmetric and positive."""
    rest = np.eye(P.shape[-1]) - gain @ H
    return np.asarray(rest @ P @ _transposed(rest) + gain @ _transposed(gain))


def _rows(information: Array, beside: Array) -> Pair:
    """Rows (H, D) of readings that tell the same as an information (HᵀH, HᵀD)."""
    size = np.sqrt(np.diagonal(information, axis1=-2, axis2=-1).clip(np.finfo(float).tiny))[..., np.newaxis]
    values, vectors = np.linalg.eigh(information / (size * _transposed(size)))  # of one size, whatever the units
    root = np.sqrt(values.clip(0.0))[..., np.newaxis]
    D = np.divide(_transposed(vectors) @ (beside / size), root, where=root > 0.0, out=np.zeros_like(beside))
    return root * _transposed(vectors) * _transposed(size), D


def _stacked(pairs: list[Pair]) -> Pair:
    return np.array([first for first, _ in pairs]), np.array([second for _, second in pairs])


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -1, -2)
