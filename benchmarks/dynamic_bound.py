"""Whether a fit of Euler's equations attains the bound of filters that know the dynamics.

    python benchmarks/dynamic_bound.py --runs 200

Each run has other noise and another bias of the gyro. The first attitude, the first body rate and the bias are fitted
to all readings by least squares. Printed are the RMS error of the fit beside the bounds of smoothers with and without
dynamics, and in how many runs it is said that the estimate has seen the truth: of the fit, and of a hundredth of its
error.
"""

from __future__ import annotations

import argparse
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from lie_rigid_body import ClosedForm, Run, State, simulate

Array = NDArray[np.float64]

RATE: Final = 20.0
GIVEN: Final[dict[str, Any]] = {
    "initial_body_rate": [0.3, 1.0, -0.4],
    "rate": RATE,
    "imu_rate": RATE,
    "magnetometer_rate": RATE,
    "accelerometer_mode": "pivot_gravity",
    "motion": "closed_form",
    "gyro_noise_density": 5e-3,
    "gyro_turn_on_bias": 0.02,
    "accelerometer_noise_density": 0.05,
    "magnetometer_noise_density": 5e-7,
}


def fitted(run: Run) -> Array:
    """Attitudes of the fit at the stamps of the IMU, scalar last."""
    assert run.imu is not None
    assert run.magnetometer is not None
    value: dict[str, Any] = dict(run.scenario.parameters())
    deviation = {
        name: value[f"{name}_noise_density"] * np.sqrt(RATE) for name in ("gyro", "accelerometer", "magnetometer")
    }
    body = run.scenario.body()
    start = run.scenario.start()
    first = Rotation.from_quat(start.attitude_xyzw)
    t_ns = run.imu.t_ns - run.imu.t_ns[0]
    up = np.array([0.0, 0.0, value["gravity"]])

    def states(x: Array) -> tuple[Rotation, Array]:
        turned = (first * Rotation.from_rotvec(x[:3])).as_quat()
        found = ClosedForm(body, State(turned, start.body_rate + x[3:6])).at(t_ns)
        return Rotation.from_quat(found.attitude_xyzw), np.asarray(found.body_rate)

    def residuals(x: Array) -> Array:
        R, rate = states(x)
        assert run.imu is not None
        assert run.magnetometer is not None
        return np.concatenate(
            [
                ((rate + x[6:] - run.imu.gyro) / deviation["gyro"]).ravel(),
                ((R.inv().apply(up) - run.imu.specific_force) / deviation["accelerometer"]).ravel(),
                ((R.inv().apply(value["magnetic_field"]) - run.magnetometer.field) / deviation["magnetometer"]).ravel(),
                x[6:] / value["gyro_turn_on_bias"],
            ]
        )

    found = least_squares(residuals, np.zeros(9), x_scale=[0.01] * 3 + [0.001] * 3 + [0.01] * 3)
    return np.asarray(states(found.x)[0].as_quat())


def played(seed: int, duration: float) -> tuple[float, float, float, bool, bool]:
    """Error of the fit and the two bounds, degrees, and whether the fit and a hundredth of it have seen the truth."""
    run = simulate(duration=duration, sensor_seed=seed, **GIVEN)
    estimate = fitted(run)
    score = run.score(estimate)
    assert run.imu is not None
    true = Rotation.from_quat(run.attitude().at(run.imu.t_ns))
    near = true * Rotation.from_rotvec(0.01 * (true.inv() * Rotation.from_quat(estimate)).as_rotvec())
    assert score.best is not None
    assert score.best.smoothed is not None
    assert score.best.dynamic is not None
    assert score.best.dynamic.smoothed is not None
    seen = run.score(near.as_quat()).best
    assert seen is not None
    bounds = score.best.smoothed.rms, score.best.dynamic.smoothed.rms
    return score.total_deg.rms, *bounds, score.best.beaten, seen.beaten


def main() -> None:
    """Print the errors and the shares."""
    parser = argparse.ArgumentParser(description="A fit of Euler's equations beside its bound.")
    parser.add_argument("--runs", type=int, default=200, help="number of runs (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=20.0, help="length of a run, s (default: %(default)s)")
    given = parser.parse_args()
    found = np.array([played(seed, given.duration) for seed in range(given.runs)], dtype=float)
    error, without, bound = np.sqrt(np.mean(found[:, :3] ** 2, axis=0))
    print(f"RMS over {given.runs} runs of {given.duration:g} s, degrees")
    print(f"bound of smoothers without dynamics  {without:.4f}")
    print(f"fit of Euler's equations             {error:.4f}")
    print(f"bound of smoothers with dynamics     {bound:.4f}")
    print(f"mean square of the fit beside its bound: {(error / bound) ** 2:.3f}")
    below, seen = found[:, 3:].sum(axis=0)
    print(f"said to have seen the truth: {below:.0f} fits; {seen:.0f} estimates of a hundredth of their errors")


if __name__ == "__main__":
    main()
