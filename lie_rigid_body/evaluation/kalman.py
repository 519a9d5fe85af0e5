"""Covariances of the Kalman filter and of the Rauch–Tung–Striebel smoother of a linear system.

The system is x_k = F_k x_(k−1) + w_k and y_k = H_k x_k + m_k, with covariances Q_k of w_k and 1 of m_k. The update by a
reading has the form of P. D. Joseph, L P Lᵀ + K Kᵀ, which stays positive where rounding is large beside it.

References
----------
H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of linear dynamic systems", AIAA Journal 3 (1965)
1445. R. S. Bucy, P. D. Joseph, "Filtering for stochastic processes with applications to guidance", Interscience (1968).
"""

from __future__ import annotations

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.foundation.arrays import Array


def covariances(F: Array, Q: Array, H: Array, deviations: Array) -> tuple[Array, Array, Array]:
    """Covariances of each sample's state by the readings before it, by those up to it, and by all readings.

    Parameters
    ----------
    F, Q : ndarray, shape (N, n, n)
        Transitions to each sample, and covariances of their noise.
    H : ndarray, shape (N, m, n)
        Measurements, scaled to noise of unit variance.
    deviations : ndarray, shape (n,)
        Standard deviations of the state before sample 0, which are independent; none is 0.

    Returns
    -------
    tuple of ndarray, shape (N, n, n) each
    """
    predicted = np.empty_like(F)
    filtered = np.empty_like(F)
    of_noise = np.eye(H.shape[1])
    unit = np.eye(len(deviations))
    P = np.diag(deviations**2)
    for k, (F_k, Q_k, H_k) in enumerate(zip(F, Q, H, strict=True)):
        P = F_k @ P @ F_k.T + Q_k
        predicted[k] = P
        HP = H_k @ P
        _, _, found, _ = scipy.linalg.lapack.dgesv(HP @ H_k.T + of_noise, HP)
        gain = found.T
        L = unit - gain @ H_k
        P = L @ P @ L.T + gain @ gain.T
        filtered[k] = P
    gains = np.swapaxes(np.linalg.solve(predicted[1:], F[1:] @ filtered[:-1]), 1, 2)
    smoothed = filtered.copy()
    for k in range(len(gains) - 1, -1, -1):
        smoothed[k] += gains[k] @ (smoothed[k + 1] - predicted[k + 1]) @ gains[k].T
    return predicted, filtered, smoothed
