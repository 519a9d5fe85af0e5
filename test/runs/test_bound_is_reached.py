"""The bound with unknown constants against a batch smoother: iterated least squares over the same unknowns."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial.transform import Rotation

from lie_rigid_body import Run, simulate

RATE: Final = 25.0
SIZES: Final = {"gyro_scale": 0.01, "gyro_turn": 0.01, "accelerometer_scale": 0.005, "accelerometer_turn": 0.005}
SOFT_IRON: Final = 0.02
RUNS = 200
GIVEN: Final[dict[str, Any]] = {
    "initial_body_rate": [0.3, 1.0, -0.4],
    "gyro_rate": "integrated",
    "imu_rate": RATE,
    "magnetometer_rate": RATE,
    "rate": RATE,
    "accelerometer_mode": "pivot_gravity",
    "motion": "closed_form",
    "sensor_grade": "mems",
    "gyro_resolution": 0.0,
    "accelerometer_resolution": 0.0,
    "magnetometer_resolution": 0.0,
}
CONSTANTS: Final = 27
"""Bias of the accelerometer, hard iron, scale and mounting of gyro and accelerometer, three each, and soft iron."""


def hats(vectors: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([np.stack(row, -1) for row in ([zero, -z, y], [z, zero, -x], [-y, x, zero])], -2)


def right_jacobian(turns: np.ndarray) -> np.ndarray:
    """Derivative of log(exp(φ)⁻¹ exp(φ + ε)) by ε, by its series: turns are small."""
    K = hats(turns)
    return np.eye(3) - K / 2.0 + K @ K / 6.0 - K @ K @ K / 24.0 + K @ K @ K @ K / 120.0


class Smoother:
    """The most probable attitudes, gyro biases and constants of a run, by the noise that a scenario declares."""

    def __init__(self, declared: dict[str, Any], run: Run) -> None:
        assert run.imu is not None
        assert run.magnetometer is not None
        self.gyro, self.force, self.field = run.imu.gyro, run.imu.specific_force, run.magnetometer.field
        self.count, root = len(self.gyro), np.sqrt(RATE)
        self.up, self.north = np.array([0.0, 0.0, declared["gravity"]]), np.array(declared["magnetic_field"])
        self.noise = {
            name: declared[f"{name}_noise_density"] * root for name in ("gyro", "accelerometer", "magnetometer")
        }
        self.walk, self.turn_on = declared["gyro_bias_random_walk"] / root, declared["gyro_turn_on_bias"]
        hard = np.abs(declared["magnetometer_hard_iron"]).max()
        sizes = [declared["accelerometer_turn_on_bias"], hard, *SIZES.values()]
        self.deviations = np.concatenate([np.repeat(sizes, 3), np.repeat(SOFT_IRON, 9)])
        self.attitude, self.bias, self.constants = self._directions(), np.zeros((self.count, 3)), np.zeros(CONSTANTS)

    def _directions(self) -> Rotation:
        """The attitude that each pair of readings tells (TRIAD)."""

        def axes(first: np.ndarray, second: np.ndarray) -> np.ndarray:
            across = np.cross(first, second)
            found = np.stack([first, across, np.cross(first, across)], -1)
            return np.asarray(found / np.linalg.norm(found, axis=-2, keepdims=True))

        body = axes(self.force, self.field)
        return Rotation.from_matrix(axes(self.up, self.north) @ np.swapaxes(body, -1, -2))

    def linearised(self) -> tuple[sparse.csr_array, np.ndarray]:
        """Jacobian and residuals, each divided by its standard deviation."""
        n, R = self.count, self.attitude
        hard, iron = self.constants[3:6], np.eye(3) + self.constants[18:].reshape(3, 3)
        rows: list[tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]] = []
        each, fixed = np.arange(n), 6 * n

        def at(first: Any, size: int = 3) -> np.ndarray:
            return np.asarray(first)[..., np.newaxis] + np.arange(size)

        def constants(k: int, size: int = 3) -> np.ndarray:
            return np.tile(at(fixed + k, size), (n, 1))

        def through(k: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
            """Reading of x by scale and mounting from the k-th constant on; derivatives by x, scale and mounting."""
            scale, turn = 1.0 + self.constants[k : k + 3], self.constants[k + 3 : k + 6]
            mounted = Rotation.from_rotvec(turn).inv()
            y, S = mounted.apply(x), np.diag(scale)
            return y * scale, S @ mounted.as_matrix(), y[:, :, None] * np.eye(3), S @ hats(y) @ right_jacobian(turn)

        turn = (R[:-1].inv() * R[1:]).as_rotvec()
        read, by_rate, by_scale, by_turn = through(6, turn * RATE)
        backward, forward = np.linalg.inv(right_jacobian(-turn)), np.linalg.inv(right_jacobian(turn))
        tile = np.tile(np.eye(3), (n, 1, 1))
        later = each[1:]
        rows.append(
            (
                (read + self.bias[1:] - self.gyro[1:]) / self.noise["gyro"],
                [
                    (at(6 * later - 6), -by_rate @ backward * RATE / self.noise["gyro"]),
                    (at(6 * later), by_rate @ forward * RATE / self.noise["gyro"]),
                    (at(6 * later + 3), tile[1:] / self.noise["gyro"]),
                    (constants(6)[1:], by_scale / self.noise["gyro"]),
                    (constants(9)[1:], by_turn / self.noise["gyro"]),
                ],
            )
        )
        rows.append(
            (
                np.diff(self.bias, axis=0) / self.walk,
                [(at(6 * later + 3), tile[1:] / self.walk), (at(6 * later - 3), -tile[1:] / self.walk)],
            )
        )
        rows.append((self.bias[:1] / self.turn_on, [(at([3]), tile[:1] / self.turn_on)]))
        x, sigma = R.inv().apply(self.up), self.noise["accelerometer"]
        read, by_x, by_scale, by_turn = through(12, x)
        rows.append(
            (
                (read + self.constants[:3] - self.force) / sigma,
                [
                    (at(6 * each), by_x @ hats(x) / sigma),
                    (constants(0), tile / sigma),
                    (constants(12), by_scale / sigma),
                    (constants(15), by_turn / sigma),
                ],
            )
        )
        x, sigma = R.inv().apply(self.north), self.noise["magnetometer"]
        entries = np.einsum("ij,nk->nijk", np.eye(3), x).reshape(n, 3, 9)
        rows.append(
            (
                (x @ iron.T + hard - self.field) / sigma,
                [
                    (at(6 * each), iron @ hats(x) / sigma),
                    (constants(3), tile / sigma),
                    (constants(18, 9), entries / sigma),
                ],
            )
        )
        priors = (self.constants / self.deviations)[np.newaxis]
        rows.append((priors, [(at([fixed], CONSTANTS), np.diag(1.0 / self.deviations)[np.newaxis])]))
        return _assembled(rows, fixed + CONSTANTS)

    def solve(self) -> SuperLU:
        """Iterate to the end, and give the factors of the normal equations there."""
        for _ in range(20):
            jacobian, residuals = self.linearised()
            normal = splu((jacobian.T @ jacobian).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
            step = -normal.solve(jacobian.T @ residuals)
            states = step[: 6 * self.count].reshape(-1, 6)
            self.attitude = self.attitude * Rotation.from_rotvec(states[:, :3])
            self.bias, self.constants = self.bias + states[:, 3:], self.constants + step[6 * self.count :]
            if np.abs(states[:, :3]).max() < 1e-7:
                return normal
        raise AssertionError("the smoother does not converge")


def _assembled(rows: list[Any], columns: int) -> tuple[sparse.csr_array, np.ndarray]:
    """The sparse matrix of blocks (N, 3, m) at columns (N, m), and all residuals."""
    data, row, column, begin = [], [], [], 0
    for residuals, blocks in rows:
        number = begin + np.arange(residuals.size).reshape(residuals.shape)
        begin += residuals.size
        for at, block in blocks:
            data.append(block.ravel())
            row.append(np.broadcast_to(number[:, :, np.newaxis], block.shape).ravel())
            column.append(np.broadcast_to(at[:, np.newaxis], block.shape).ravel())
    entries = np.concatenate(data), (np.concatenate(row), np.concatenate(column))
    return sparse.csr_array(entries, shape=(begin, columns)), np.concatenate([r.ravel() for r, _ in rows])


def drawn(seed: int, hard_iron: float) -> dict[str, Any]:
    """Constants of a run, normal about none."""
    random = np.random.default_rng(seed)
    return {
        "sensor_seed": seed,
        "gyro_scale_factor": (1.0 + SIZES["gyro_scale"] * random.normal(size=3)).tolist(),
        "gyro_misalignment": (SIZES["gyro_turn"] * random.normal(size=3)).tolist(),
        "accelerometer_scale_factor": (1.0 + SIZES["accelerometer_scale"] * random.normal(size=3)).tolist(),
        "accelerometer_misalignment": (SIZES["accelerometer_turn"] * random.normal(size=3)).tolist(),
        "magnetometer_soft_iron": (np.eye(3) + SOFT_IRON * random.normal(size=(3, 3))).ravel().tolist(),
        "magnetometer_hard_iron": (hard_iron * random.normal(size=3)).tolist(),
    }


DURATION: Final = 20.0
LARGEST: Final[dict[str, Any]] = {
    "gyro_scale_factor": [1.0 + SIZES["gyro_scale"], 1.0, 1.0],
    "gyro_misalignment": [0.0, SIZES["gyro_turn"], 0.0],
    "accelerometer_scale_factor": [1.0, 1.0, 1.0 - SIZES["accelerometer_scale"]],
    "accelerometer_misalignment": [0.0, 0.0, -SIZES["accelerometer_turn"]],
    "magnetometer_soft_iron": [1.0, SOFT_IRON, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
}
"""Declared errors whose largest components are the standard deviations of what is drawn."""
DRAWS: Final = 1_000_000
LARGEST_PARTS: Final = 12
"""Parts of an error of which each is drawn: the others are less than a thousandth of it."""


def mean_squares_by_chance(smoother: Smoother, normal: SuperLU) -> np.ndarray:
    """Mean squares of errors of a run that have the smoother's own covariance, (JᵀJ)⁻¹, drawn by its eigenvalues."""
    turns = (6 * np.arange(smoother.count)[:, np.newaxis] + np.arange(3)).ravel()
    columns = np.zeros((normal.shape[0], len(turns)))
    columns[turns, np.arange(len(turns))] = 1.0
    values = np.linalg.eigvalsh(normal.solve(columns)[turns])[::-1] / smoother.count
    drawn = np.random.default_rng(7).normal(size=(DRAWS, LARGEST_PARTS))
    return np.asarray(np.square(drawn) @ values[:LARGEST_PARTS] + values[LARGEST_PARTS:].sum())


@pytest.mark.slow
def test_a_batch_smoother_comes_as_near_as_the_bound_and_no_nearer() -> None:
    """Constants are drawn for each run: none is nearer than in one of a hundred such campaigns by chance."""
    base = simulate(duration=DURATION, **GIVEN, **LARGEST)
    declared, bound = base.scenario.parameters(), base.cramer_rao_bound()
    assert bound is not None
    iron = float(np.abs(np.array(declared["magnetometer_hard_iron"])).max())
    squares, chance = [], np.zeros(0)
    for seed in range(RUNS):
        run = simulate(duration=DURATION, **GIVEN, **drawn(seed, iron))
        assert run.imu is not None
        smoother = Smoother(dict(declared), run)
        normal = smoother.solve()
        true = Rotation.from_quat(run.attitude().at(run.imu.t_ns))
        squares.append(float(np.mean((true.inv() * smoother.attitude).magnitude() ** 2)))
        if seed == 0:
            chance = mean_squares_by_chance(smoother, normal)
    least = bound.rms(bound.smoothed)
    assert np.sqrt(chance.mean()) == pytest.approx(least, rel=0.01)
    by_chance = 3.0 * chance.std() / chance.mean() / np.sqrt(RUNS)
    assert np.mean(squares) / least**2 == pytest.approx(1.0, abs=by_chance)
    assert np.mean(chance <= min(squares)) > 0.01 / RUNS
    assert np.sqrt(np.mean(squares)) / least == pytest.approx(1.0, abs=0.1)
    assert bound.calibrated is not None
    assert np.sqrt(np.mean(squares)) > 3.0 * bound.calibrated.rms(bound.calibrated.smoothed)
