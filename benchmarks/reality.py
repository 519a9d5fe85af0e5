"""Does a simulated world rank filters as real recordings do?  ``python benchmarks/reality.py --data FOLDER``.

Every filter of the league runs at its defaults over real recordings with optical truth, and over simulated minutes of
a body that is kicked, carried and at times at rest. Printed is the median total RMS of each, Kendall's τ of the two
orders with its 95 % interval by the bootstrap over recordings and minutes, and for each filter the ratio of the real
error to the simulated one. ``--motions`` prints how fast the recordings turn and how much they are accelerated.

A recording is an npz file with ``gyro`` (rad/s), ``specific_force`` (m/s²), ``magnetic_field`` (µT), ``attitude_wxyz``
(IMU to east-north-up, NaN where unknown), ``movement`` (where errors count) and a rate of 285.7 Hz, as the data set
BROAD (D. Laidig et al., Data 6(7):72, 2021) is published. Its world is magnetic east-north-up.

Measured on ten of its recordings: τ = 0.84 (0.62 to 0.93) for fourteen filters of vqf, imufusion and ahrs, and 0.78
(0.64 to 0.92) for all 23, most of which have no memory. Real errors are 1.2 to 2 times as large as the simulated ones.
Those of Mahony and Fourati, which follow the accelerometer fast, are 5.5 times as large.
"""

from __future__ import annotations

import argparse
import io
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch
from scipy.spatial.transform import Rotation
from scipy.stats import kendalltau

from league.contender import Filter, Setting, filters
from league.readings import Readings
from lie_rigid_body import simulate

Array = NDArray[np.float64]

BROAD_HZ: Final = 2000.0 / 7.0
TOGETHER: Final = 3
"""Samples of a recording that are averaged: to 95 Hz, which changes no filter's place."""
RATE_HZ: Final = BROAD_HZ / TOGETHER
SETTLED_S: Final = 20.0
"""Time in which a filter may converge in a simulated minute, s; recordings begin with a rest that does not count."""
MINUTES: Final = 20
REST_PROBABILITIES: Final = (0.0, 0.3, 0.5, 0.8)
RESAMPLES: Final = 1000
SETTINGS: Final[dict[str, tuple[Setting, ...]]] = {
    "vqf VQF": ({}, {"tauAcc": 0.5, "tauMag": 9.0, "biasClip": 2.0}),
    "imufusion Ahrs": ({}, {"acceleration_rejection": 10.0}),
}
"""Settings that filters run with beside their defaults."""
SENSORS: Final[dict[str, Any]] = {
    "gyro_noise_density": np.radians(0.014),
    "gyro_turn_on_bias": np.radians(0.3),
    "gyro_scale_factor": [1.005, 0.995, 1.005],
    "accelerometer_noise_density": 175e-6 * 9.80665,
    "accelerometer_turn_on_bias": 0.05,
    "magnetometer_noise_density": 0.3e-6 / np.sqrt(RATE_HZ),
    "magnetometer_hard_iron": [0.5e-6, -0.5e-6, 0.5e-6],
}
"""Errors of the simulated sensors: those of a good MEMS unit after calibration."""


@dataclass(frozen=True)
class Trial:
    """What filters are given, the true attitudes, and where errors count."""

    name: str
    given: Readings
    truth: Rotation
    counted: NDArray[np.bool_]


def recordings(folder: Path) -> Iterator[Trial]:
    """The recordings of a folder, averaged."""
    for path in sorted(folder.glob("*.npz")):
        data = np.load(path)
        count = len(data["gyro"]) // TOGETHER * TOGETHER
        gyro, force, field = (
            data[name][:count].astype(float).reshape(-1, TOGETHER, 3).mean(axis=1)
            for name in ("gyro", "specific_force", "magnetic_field")
        )
        attitude = data["attitude_wxyz"][TOGETHER // 2 : count : TOGETHER][:, [1, 2, 3, 0]].astype(float)
        known = np.isfinite(attitude).all(axis=1)
        truth = Rotation.from_quat(np.where(known[:, np.newaxis], attitude, [0.0, 0.0, 0.0, 1.0]))
        moves = data["movement"][TOGETHER // 2 : count : TOGETHER].astype(bool)
        east, north, up = np.median(truth.apply(field)[known & ~moves], axis=0)
        world = np.array([0.0, np.hypot(east, north), up])
        t_ns = np.round(np.arange(len(gyro)) * 1e9 / RATE_HZ).astype(np.int64)
        readings = Readings(t_ns, RATE_HZ, gyro, force, 1e-6 * field, 1e-6 * world)
        yield Trial(path.stem, readings, truth, known & moves)


def motions(folder: Path) -> Iterator[str]:
    """How each recording moves where errors count: rates, rad/s, accelerations of an axis, m/s², and rests."""
    for trial in recordings(folder):
        rates = np.linalg.norm(trial.given.gyro[trial.counted], axis=1)
        accelerations = trial.truth[trial.counted].apply(trial.given.acc[trial.counted])
        accelerations -= accelerations.mean(axis=0)
        frequency, power = welch(accelerations, RATE_HZ, nperseg=round(8.0 * RATE_HZ), axis=0)
        shares = np.cumsum(power.sum(axis=1)) / power.sum()
        low, high = frequency[np.searchsorted(shares, [0.1, 0.9])]
        middle, fast = np.quantile(rates, [0.5, 0.95])
        yield (
            f"{trial.name:42} rate {middle:.2f}, 95 % below {fast:.1f} rad/s; at rest {np.mean(rates < 0.1):.0%}; "
            f"acceleration {np.sqrt(np.mean(accelerations**2)):.2f} m/s² RMS, {low:.1f} to {high:.1f} Hz"
        )


def minutes() -> Iterator[Trial]:
    """Simulated minutes: a body that turns freely between kicks, is carried, and rests at times."""
    for seed in range(MINUTES):
        draws = np.random.default_rng(seed)
        times = np.cumsum(draws.uniform(1.0, 4.0, 60))
        times = times[times < 60.0]
        directions = draws.normal(size=(len(times), 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        fastest = draws.uniform(0.5, 3.0)
        rates = directions * draws.uniform(0.2, 1.0, (len(times), 1)) * fastest
        rates[draws.random(len(times)) < REST_PROBABILITIES[seed % len(REST_PROBABILITIES)]] = 0.0
        run: Any = simulate(
            duration=60.0,
            rate=RATE_HZ,
            imu_rate=RATE_HZ,
            magnetometer_rate=RATE_HZ,
            motion="closed_form",
            gyro_rate="integrated",
            magnetic_field=[0.0, 2e-5, -4.5e-5],
            initial_body_rate=[0.0, 0.0, 0.0],
            kicks=np.column_stack([times, rates]).ravel(),
            translation="carried",
            sway_acceleration=[draws.uniform(0.5, 3.0)] * 3,
            sway_band=[0.3, 2.0],
            sway_seed=seed,
            sensor_seed=seed,
            **SENSORS,
        )
        given = Readings.of(run)
        yield Trial(f"minute {seed}", given, Rotation.from_quat(run.truth.attitude_xyzw), run.t_s >= SETTLED_S)


def error_deg(each: Filter, setting: Setting, trial: Trial) -> float:
    """RMS of the total error where it counts, degrees; 180 where the filter gives no attitude in a tenth of it."""
    np.random.seed(1)  # noqa: NPY002 - what filters draw from
    try:
        with redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
            found = each.estimate(trial.given, **setting).as_quat()
    except (ValueError, np.linalg.LinAlgError):
        return 180.0
    counted = trial.counted & np.isfinite(found).all(axis=1)
    if counted.sum() < 0.9 * trial.counted.sum():
        return 180.0
    angles = (Rotation.from_quat(found[counted]).inv() * trial.truth[counted]).magnitude()
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def errors(playing: Sequence[tuple[Filter, Setting]], trials: Iterator[Trial]) -> Array:
    """Errors of every filter in every trial, degrees."""
    rows = []
    for trial in trials:
        rows.append([error_deg(each, setting, trial) for each, setting in playing])
        print(f"{trial.name}: {np.median(rows[-1]):.3g}°", flush=True)
    return np.array(rows).T


def main() -> None:
    """Print both tables, τ with its interval, and the ratios."""
    parser = argparse.ArgumentParser(description="Filters of the league over real recordings and simulated minutes.")
    parser.add_argument("--data", type=Path, required=True, help="folder of npz files")
    parser.add_argument("--filters", nargs="*", help="names of filters, such as 'vqf VQF'; by default all")
    parser.add_argument("--motions", action="store_true", help="print how the recordings move, and run no filter")
    given = parser.parse_args()
    if given.motions:
        print("\n".join(motions(given.data)))
        return
    named = [each for each in filters() if not given.filters or each.full_name in given.filters]
    playing = [(each, setting) for each in named for setting in SETTINGS.get(each.full_name, ({},))]
    real = errors(playing, recordings(given.data))
    simulated = errors(playing, minutes())
    medians = [np.median(table, axis=1) for table in (real, simulated)]
    draws = np.random.default_rng(0)
    resampled = [
        kendalltau(*(np.median(t[:, draws.integers(t.shape[1], size=t.shape[1])], axis=1) for t in (real, simulated)))[
            0
        ]
        for _ in range(RESAMPLES)
    ]
    for k in np.argsort(medians[0]):
        ratio = medians[0][k] / medians[1][k]
        name = " ".join([playing[k][0].full_name, *(f"{key}={value:g}" for key, value in playing[k][1].items())])
        print(f"{name:48} {medians[0][k]:8.3g} {medians[1][k]:8.3g}  ratio {ratio:.2f}")
    tau, p = kendalltau(*medians)
    low, high = np.quantile(resampled, [0.025, 0.975])
    logs = np.corrcoef(*np.log(medians))[0, 1]
    print(f"tau {tau:.2f} ({low:.2f} to {high:.2f}), p {p:.1g}; correlation of the logarithms {logs:.2f}")


if __name__ == "__main__":
    main()
