"""A complementary filter of a page, compiled by numba: what an estimator of a campaign costs at least."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from lie_rigid_body import Run

Array = npt.NDArray[np.float64]


def estimate(run: Run, gain: float = 0.5) -> Array:
    """Attitudes, shape (N, 4): the gyro integrated, and the vertical of the accelerometer taken with a gain, 1/s."""
    return np.asarray(_attitudes(run.imu.t_ns, run.imu.gyro, run.imu.specific_force, gain))


@numba.njit(cache=True)  # type: ignore[misc]  # numba has no types
def _attitudes(t_ns: npt.NDArray[np.int64], gyro: Array, force: Array, gain: float) -> Array:
    found = np.empty((len(t_ns), 4))
    x, y, z, w = 0.0, 0.0, 0.0, 1.0
    for k in range(len(t_ns)):
        dt = (t_ns[k] - t_ns[k - 1]) / 1e9 if k else 0.0
        fx, fy, fz = force[k] / max(np.sqrt(np.sum(force[k] ** 2)), 1e-9)
        # the vertical in the body, which the accelerometer should show
        ux, uy, uz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
        a = 0.5 * dt * (gyro[k, 0] + gain * (fy * uz - fz * uy))
        b = 0.5 * dt * (gyro[k, 1] + gain * (fz * ux - fx * uz))
        c = 0.5 * dt * (gyro[k, 2] + gain * (fx * uy - fy * ux))
        dx, dy, dz = w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a
        x, y, z, w = x + dx, y + dy, z + dz, w - x * a - y * b - z * c
        norm = np.sqrt(x * x + y * y + z * z + w * w)
        x, y, z, w = x / norm, y / norm, z / norm, w / norm
        found[k] = x, y, z, w
    return found
