"""The bound of a run is that of the normal equations over all that its scenario leaves unknown, constants as well."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation

from untyped import simulate

RATE: Final = 25.0
SIZES: Final = {"gyro_scale": 0.2, "gyro_turn": 0.1, "accelerometer_scale": 0.05, "accelerometer_turn": 0.05}
SOFT_IRON: Final = 0.02
GIVEN: Final[dict[str, Any]] = {
    "initial_body_rate": [0.3, 1.0, -0.4],
    "gyro_rate": "integrated",
    "imu_rate": RATE,
    "magnetometer_rate": RATE / 2.0,
    "rate": RATE,
    "accelerometer_mode": "pivot_gravity",
    "motion": "closed_form",
    "sensor_grade": "mems",
    "accelerometer_bias_random_walk": 0.03,
    "gyro_bias_random_walk": 0.05,
    "gyro_resolution": 0.0,
    "accelerometer_resolution": 0.0,
    "magnetometer_resolution": 0.0,
    "gyro_scale_factor": [1.0 + SIZES["gyro_scale"], 1.0, 1.0],
    "gyro_misalignment": [0.0, SIZES["gyro_turn"], 0.0],
    "accelerometer_scale_factor": [1.0, 1.0, 1.0 - SIZES["accelerometer_scale"]],
    "accelerometer_misalignment": [0.0, 0.0, -SIZES["accelerometer_turn"]],
    "magnetometer_soft_iron": [1.0, SOFT_IRON, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
}
"""The largest components of the declared errors are the standard deviations of what is not known."""


def read(vectors: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """Readings of vectors by a triad whose scale errs by three constants, and whose mounting by three more."""
    return Rotation.from_rotvec(constants[3:]).inv().apply(vectors) * (1.0 + constants[:3])


def test_it_is_that_of_all_attitudes_biases_and_constants_at_once() -> None:
    """Linearised by differences of the readings; the constants are hard iron, scales, mountings and soft iron."""
    run = simulate(duration=12.0 / RATE, **GIVEN)
    n = len(run.imu.t_ns)
    true = Rotation.from_quat(run.attitude().at(run.imu.t_ns))
    declared: dict[str, Any] = dict(run.scenario.parameters())
    gyro, force = (declared[f"{name}_noise_density"] * np.sqrt(RATE) for name in ("gyro", "accelerometer"))
    field = declared["magnetometer_noise_density"] * np.sqrt(RATE / 2.0)
    sizes = np.repeat([np.abs(declared["magnetometer_hard_iron"]).max(), *SIZES.values()], 3)
    deviations = np.concatenate([sizes, np.full(9, SOFT_IRON)])
    up, north = np.array([0.0, 0.0, declared["gravity"]]), np.array(declared["magnetic_field"])

    def residuals(x: np.ndarray) -> np.ndarray:
        """Residuals of turns and biases, and of constants in their deviations; each divided by its own deviation."""
        turns, *biases = np.moveaxis(x[: 9 * n].reshape(n, 3, 3), 1, 0)
        constants = deviations * x[9 * n :]
        R = true * Rotation.from_rotvec(turns)
        rates = (R[:-1].inv() * R[1:]).as_rotvec() * RATE
        iron = np.eye(3) + constants[15:].reshape(3, 3)
        rows = [
            turns[0] / np.pi,
            (read(rates, constants[3:9]) + biases[0][1:]) / gyro,
            (read(R.inv().apply(up), constants[9:15]) + biases[1]) / force,
            (R[::2].inv().apply(north) @ iron.T + constants[:3]) / field,
            x[9 * n :],
        ]
        for name, bias in zip(("gyro", "accelerometer"), biases, strict=True):
            rows += [
                bias[0] / declared[f"{name}_turn_on_bias"],
                np.diff(bias, axis=0) / declared[f"{name}_bias_random_walk"] * np.sqrt(RATE),
            ]
        return np.concatenate([row.ravel() for row in rows])

    step = 1e-5
    jacobian = np.array([(residuals(step * e) - residuals(-step * e)) / (2.0 * step) for e in np.eye(9 * n + 24)]).T
    found = run.cramer_rao_bound()
    # calibrated: scales, mountings and soft iron are known
    for bound, columns in ((found, 9 * n + 24), (found.calibrated, 9 * n + 3)):
        covariance = np.linalg.inv(jacobian[:, :columns].T @ jacobian[:, :columns])
        blocks = np.array([covariance[9 * k : 9 * k + 3, 9 * k : 9 * k + 3] for k in range(n)])
        bias = slice(9 * n - 6, 9 * n - 3)
        np.testing.assert_allclose(bound.smoothed, blocks, rtol=0, atol=1e-4 * np.abs(blocks).max())
        np.testing.assert_allclose(bound.gyro_bias[-1], covariance[bias, bias], rtol=1e-4, atol=1e-9)
        np.testing.assert_allclose(bound.filtered[-1], blocks[-1], rtol=0, atol=1e-4 * np.abs(blocks).max())
    assert found.rms(found.smoothed) > 1.01 * found.calibrated.rms(found.calibrated.smoothed)
