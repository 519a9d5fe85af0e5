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
with B θ for a step and D θ for a reading. An innovation of covariance S tells of them the rows S^(−½) (H Ψ + D). With
the triangular R of all these rows, RᵀR = 1 + Σ rowsᵀ rows, the covariance is P + Ψ (RᵀR)⁻¹ Ψᵀ.

Each covariance and information is kept as a root, P = rootᵀ root, which orthogonal transformations change. None is
squared on the way, so that it stays right where noises are tiny beside the first deviations.

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
"""F (S, n, n), a root of Q (S, q, n), H (S, m, n), B (S, n, c) and D (S, m, c) of S samples by number.

Those after the last change and tell nothing.
"""

Pair: TypeAlias = tuple[Array, Array]
"""Roots of covariances of states, and the sensitivities of their estimates to the constants."""


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
    first : ndarray, shape (n,)
        Standard deviations of the state before sample 0, which are independent; none is 0.
    constants : int, optional
        Number of constants, c.

    Returns
    -------
    known, unknown : Covariances
    """
    numbers = np.arange(padded(count)).reshape(-1, _length(count)).T
    start, end = _at_ends(*_blocks(steps, numbers, len(first), constants), np.diag(first))
    before, filtered, rows = _filtered(steps, numbers, *start)
    smoothed = _smoothed(steps, numbers, filtered, end)
    parts = before, filtered, smoothed
    known = [_square(root)[:count] for root, _ in parts]
    added = _by_constants(numbers, rows, *(sensitivity for _, sensitivity in parts))
    return Covariances(*known), Covariances(*(P + more[:count] for P, more in zip(known, added, strict=True)))


def _length(count: int) -> int:
    """Length of a block: loops over the blocks and over the samples of one are as long as each other."""
    return max(1, math.isqrt(count))


def _blocks(steps: Steps, numbers: Integers, n: int, c: int) -> tuple[Array, Array, Array, Array, Array]:
    """Blocks: A, what the constants add to the state, a root of C, and rows that tell of the state and of constants."""
    A, C, J = (np.tile(part, (numbers.shape[1], 1, 1)) for part in (np.eye(n), np.zeros((n, n)), np.zeros((n, n))))
    b, g = np.zeros((2, numbers.shape[1], n, c))
    for k in numbers:
        F, noise, H, B, D = steps(k)
        A, b = F @ A, F @ b + B
        C, gain, S = _updated(_stacked(C @ _transposed(F), noise), H)
        told, beside = np.linalg.solve(S, H @ A), np.linalg.solve(S, H @ b + D)
        A, b = A - _transposed(gain) @ told, b - _transposed(gain) @ beside
        rows = _triangle(_stacked(_beside(J, g), _beside(told, beside)))
        J, g = rows[..., :n, :n], rows[..., :n, n:]
    return A, b, C, J, g


def _at_ends(A: Array, b: Array, C: Array, J: Array, g: Array, first: Array) -> tuple[Pair, Pair]:
    """Roots and sensitivities before each block by the readings before it, and after each block by all readings."""
    before, updated = [(first, np.zeros_like(b[0]))], list[Pair]()
    for i in range(len(A)):
        root, sensitivity = before[-1]
        root, gain, S = _updated(root, J[i])
        sensitivity = sensitivity - gain.T @ np.linalg.solve(S, J[i] @ sensitivity + g[i])
        updated.append((root, sensitivity))
        before.append((_triangle(_stacked(root @ A[i].T, C[i])), A[i] @ sensitivity + b[i]))
    after = [before.pop()]
    for i in range(len(A) - 1, 0, -1):
        after.append(_earlier(*updated[i], A[i], C[i], b[i], *after[-1]))
    return _together(before), _together(after[::-1])


def _filtered(steps: Steps, numbers: Integers, root: Array, sensitivity: Array) -> tuple[Pair, Pair, Array]:
    """Roots and sensitivities before and after each sample's readings, and the rows that these tell of constants."""
    before, after, rows = list[Pair](), list[Pair](), list[Array]()
    for k in numbers:
        F, noise, H, B, D = steps(k)
        root, sensitivity = _stacked(root @ _transposed(F), noise), F @ sensitivity + B
        before.append((root, sensitivity))
        root, gain, S = _updated(root, H)
        rows.append(np.linalg.solve(S, H @ sensitivity + D))
        sensitivity = sensitivity - _transposed(gain) @ rows[-1]
        after.append((root, sensitivity))
    return _in_order(before), _in_order(after), np.array(rows)


def _smoothed(steps: Steps, numbers: Integers, filtered: Pair, end: Pair) -> Pair:
    """Roots and sensitivities by all readings."""
    found = [end]
    for k in numbers[:0:-1]:
        F, noise, _, B, _ = steps(k)
        found.append(_earlier(filtered[0][k - 1], filtered[1][k - 1], F, noise, B, *found[-1]))
    return _in_order(found[::-1])


def _by_constants(
    numbers: Integers, rows: Array, before: Array, filtered: Array, smoothed: Array
) -> tuple[Array, Array, Array]:
    """Covariances that the constants add to those before and after each sample's readings, and to the smoothed."""
    factors = [np.eye(rows.shape[-1])]
    for block in rows.swapaxes(0, 1):
        factors.append(_triangle(_stacked(factors[-1], np.concatenate(block))))
    R, states = np.array(factors[:-1]), before.shape[-2]
    added = np.empty((2, numbers.size, states, states))
    for k, row in zip(numbers, rows, strict=True):
        added[0, k] = _left(R, before[k])
        R = _triangle(_stacked(R, row))
        added[1, k] = _left(R, filtered[k])
    return added[0], added[1], _left(factors[-1], smoothed)


def _left(R: Array, sensitivity: Array) -> Array:
    """Covariance of a state of this sensitivity to constants of the information RᵀR."""
    return _square(np.linalg.solve(_transposed(R), _transposed(sensitivity)))


def _updated(root: Array, H: Array) -> tuple[Array, Array, Array]:
    """Root after readings; S^(−½) H P and S^½, with the covariance S = H P Hᵀ + 1 of the innovation."""
    m = H.shape[-2]
    seen, ones = root @ _transposed(H), np.broadcast_to(np.eye(m), (*root.shape[:-2], m, m))
    found = _triangle(_stacked(_beside(ones, np.zeros_like(H)), _beside(seen, root)))
    return found[..., m:, m:], found[..., :m, m:], _transposed(found[..., :m, :m])


def _earlier(
    root: Array, sensitivity: Array, F: Array, noise: Array, B: Array, later: Array, later_sensitivity: Array
) -> Pair:
    """Root and sensitivity of a state by all readings, of those by the readings up to it, and of the next state's."""
    n = root.shape[-1]
    found = _triangle(_stacked(_beside(root @ _transposed(F), root), _beside(noise, np.zeros_like(noise))))
    gain = np.linalg.solve(found[..., :n, :n], found[..., :n, n:])  # transposed
    smoothed = _triangle(_stacked(later @ gain, found[..., n:, n:]))
    return smoothed, sensitivity + _transposed(gain) @ (later_sensitivity - F @ sensitivity - B)


def _in_order(pairs: list[Pair]) -> Pair:
    """Join the first samples of all blocks, their second ones and so on, in the order of the samples."""
    first, second = (np.concatenate(np.stack(parts, axis=1)) for parts in zip(*pairs, strict=True))
    return first, second


def _triangle(rows: Array) -> Array:
    """The triangular root of what rows are a root of."""
    return np.linalg.qr(rows, mode="r")


def _square(root: Array) -> Array:
    return _transposed(root) @ root


def _stacked(first: Array, second: Array) -> Array:
    return np.concatenate([first, second], axis=-2)


def _beside(first: Array, second: Array) -> Array:
    return np.concatenate([first, second], axis=-1)


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -1, -2)


def _together(pairs: list[Pair]) -> Pair:
    first, second = (np.array(parts) for parts in zip(*pairs, strict=True))
    return first, second
