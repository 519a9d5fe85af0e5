"""A multiplicative extended Kalman filter on filterpy's: attitude error and gyro bias, six states."""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import UP, Readings


def estimate(given: Readings, gyro: float = 1e-3, bias: float = 1e-5, vectors: float = 0.02) -> Rotation:
    """Noise of gyro (rad/s/√Hz), of its bias (rad/s²/√Hz), and of the directions of gravity and field (rad)."""
    north = given.field / np.linalg.norm(given.field)
    acc, mag = (track / np.linalg.norm(track, axis=1, keepdims=True) for track in (given.acc, given.mag))
    attitude = given.first_attitude
    kf = KalmanFilter(dim_x=6, dim_z=6)
    kf.P = np.diag([0.1, 0.1, 0.1, 1e-3, 1e-3, 1e-3])
    kf.Q = np.diag(np.repeat([gyro**2 * given.dt, bias**2 * given.dt], 3))
    kf.R = np.eye(6) * vectors**2
    drift, out = np.zeros(3), []
    for k in range(len(given.t_ns)):
        turn = Rotation.from_rotvec((given.gyro[k] - drift) * given.dt if k else np.zeros(3))
        attitude = attitude * turn
        kf.F = np.block([[turn.inv().as_matrix(), -given.dt * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
        kf.x = np.zeros((6, 1))
        kf.predict()
        expected = attitude.inv().apply([UP, north])
        kf.H = np.vstack([np.hstack([_cross(v), np.zeros((3, 3))]) for v in expected])
        kf.update(np.concatenate([acc[k] - expected[0], mag[k] - expected[1]]).reshape(6, 1))
        attitude = attitude * Rotation.from_rotvec(kf.x[:3, 0])
        drift = drift + kf.x[3:, 0]
        out.append(attitude.as_quat())
    return Rotation.from_quat(out)


def _cross(v: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


GRID = {"gyro": (1e-3, 1e-2), "bias": (1e-5,), "vectors": (0.02, 0.1, 0.5)}
FILTERS = (Filter("filterpy", "KalmanFilter (MEKF)", estimate, GRID, advice="wired to six states here"),)
