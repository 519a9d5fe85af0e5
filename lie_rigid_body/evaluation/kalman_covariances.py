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
the triangular R of all these rows, RᵀR = 1 + Σ rowsᵀ rows, the covariance is P + Ψ (RᵀR)⁻¹ Ψᵀ. The state before a block
acts on the block as constants do: A is the sensitivity to it, and the rows that tell of it are a root of J.

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
from collections.abc import Iterable, Iterator
from typing import TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array

Pair: TypeAlias = tuple[Array, Array]
"""Roots of covariances of states, and the sensitivities of their estimates to the constants."""


Steps: TypeAlias = tuple[Array, Array, Array, Array, Array]
"""Systems of S samples side by side: transitions F (S, n, n), roots of the noise Q (S, q, n), measurements H (S, m, n).

Then what constants add to states, B (S, n, c), and to readings, D (S, m, c)."""


def covariances(samples: Steps, first: Array) -> Array:
    """Covariances of each sample's state, for an estimator that knows the constants, and for one that does not.

    Parameters
    ----------
    samples : Steps
        Those of N samples.
    first : ndarray, shape (n,)
        Standard deviations of the state before sample 0, which are independent; none is 0.

    Returns
    -------
    ndarray, shape (2, 3, N, n, n)
        For the first and the second: from the readings before each sample, from those up to it, and from all.
    """
    count, n, c = samples[3].shape
    length = max(1, math.isqrt(count))  # loops over the blocks and over the samples of one are as long as each other
    blocks = -(-count // length)
    padded = [np.pad(part, ((0, length * blocks - count), (0, 0), (0, 0))) for part in samples]
    padded[0][count:] = np.eye(n)  # samples after the last change and tell nothing
    steps: list[Steps] = list(
        zip(*(part.reshape(blocks, length, *part.shape[1:]).swapaxes(0, 1) for part in padded), strict=True)
    )
    start, end = _at_ends(steps, first)
    filtered = list(_filtered(steps, start))
    smoothed = [end]
    for (F, noise, _, B, _), (_, updated, _) in zip(steps[:0:-1], filtered[-2::-1], strict=True):
        smoothed.append(_earlier(updated, F, noise, B, smoothed[-1]))
    # the rows that tell of the constants up to the begin of each block, and all of them
    factors = [np.eye(c)]
    for block in np.swapaxes([told for _, _, told in filtered], 0, 1):
        factors.append(_triangle([[factors[-1]], [np.concatenate(block)]]))
    R, found = np.array(factors[:-1]), np.empty((2, 3, blocks, length, n, n))
    for k, ((before, after, told), late) in enumerate(zip(filtered, smoothed[::-1], strict=True)):
        later_R = _triangle([[R], [told]])
        for i, (r, (root, psi)) in enumerate(((R, before), (later_R, after), (factors[-1], late))):
            found[:, i, :, k] = _square(root)
            found[1, i, :, k] += _square(np.linalg.solve(_transposed(r), _transposed(psi)))
        R = later_R
    return found.reshape(2, 3, -1, n, n)[:, :, :count]


def _at_ends(steps: list[Steps], first: Array) -> tuple[Pair, Pair]:
    """Roots and sensitivities before each block by the readings before it, and after each block by all readings."""
    (blocks, n, c), rows = steps[0][3].shape, list[Array]()
    of_states = (
        (F, noise, H, np.block([np.zeros_like(F), B]), np.block([np.zeros_like(H), D])) for F, noise, H, B, D in steps
    )
    end = np.zeros((blocks, n, n)), np.tile(np.eye(n, n + c), (blocks, 1, 1))
    for _, pair, told in _filtered(of_states, end):
        end = pair
        rows.append(told)
    A, b, C = end[1][..., :n], end[1][..., n:], _triangle([[end[0]]])
    told = _triangle([[np.zeros_like(end[1])], [np.concatenate(rows, axis=-2)]])[..., :n, :]
    before, updated = [(np.diag(first), np.zeros_like(b[0]))], list[Pair]()
    for i in range(blocks):
        (root, psi), _ = _read(before[-1], told[i, :, :n], told[i, :, n:])
        updated.append((root, psi))
        before.append((_triangle([[root @ A[i].T], [C[i]]]), A[i] @ psi + b[i]))
    after = [before.pop()]
    for i in range(blocks - 1, 0, -1):
        after.append(_earlier(updated[i], A[i], C[i], b[i], after[-1]))
    return _together(before), _together(after[::-1])


def _filtered(steps: Iterable[Steps], pair: Pair) -> Iterator[tuple[Pair, Pair, Array]]:
    """Roots and sensitivities before and after each sample's readings, and the rows that these tell of constants."""
    for F, noise, H, B, D in steps:
        before = np.block([[pair[0] @ _transposed(F)], [noise]]), F @ pair[1] + B
        pair, told = _read(before, H, D)
        yield before, pair, told


def _read(pair: Pair, H: Array, D: Array) -> tuple[Pair, Array]:
    """Root and sensitivity after readings, and the rows that these tell of the constants.

    The triangle has S^½ of the innovation's covariance S = H P Hᵀ + 1, and S^(−½) H P beside it.
    """
    (root, sensitivity), m = pair, H.shape[-2]
    ones = np.broadcast_to(np.eye(m), (*root.shape[:-2], m, m))
    found = _triangle([[ones, np.zeros_like(H)], [root @ _transposed(H), root]])
    told = np.linalg.solve(_transposed(found[..., :m, :m]), H @ sensitivity + D)
    return (found[..., m:, m:], sensitivity - _transposed(found[..., :m, m:]) @ told), told


def _earlier(pair: Pair, F: Array, noise: Array, B: Array, later: Pair) -> Pair:
    """Root and sensitivity of a state by all readings, of those by the readings up to it, and of the next state's."""
    (root, sensitivity), n = pair, F.shape[-1]
    found = _triangle([[root @ _transposed(F), root], [noise, np.zeros_like(noise)]])
    gain = np.linalg.solve(found[..., :n, :n], found[..., :n, n:])  # transposed
    smoothed = _triangle([[later[0] @ gain], [found[..., n:, n:]]])
    return smoothed, sensitivity + _transposed(gain) @ (later[1] - F @ sensitivity - B)


def _triangle(rows: list[list[Array]]) -> Array:
    """Triangular root of the matrix of which the given rows, in parts, are a root."""
    return np.linalg.qr(np.block(rows), mode="r")


def _square(root: Array) -> Array:
    return _transposed(root) @ root


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -1, -2)


def _together(pairs: list[Pair]) -> Pair:
    return np.array([root for root, _ in pairs]), np.array([sensitivity for _, sensitivity in pairs])
