"""Does the league rank filters as real recordings do?  ``python benchmarks/reality.py --data FOLDER``.

Every filter of the league runs over real recordings with optical truth, at its library's defaults and with the settings
that the league advises for MEMS sensors. Printed are its median total RMS while the body moves, the league's overall
error and their ratio; Kendall's τ-b of the two orders with its 95 % interval by the bootstrap over recordings, over all
filters and over those of `TRIAL`, also with errors within 5 % as ties; how well half of the recordings agrees with the
other half; and each advised setting beside the defaults. ``--motions`` prints how the recordings move.

FOLDER has files of the data set BROAD (D. Laidig et al., Data 6(7):72, 2021) as published, mat or hdf5, or npz files
with ``gyro`` (rad/s), ``specific_force`` (m/s²), ``magnetic_field`` (µT), ``attitude_wxyz`` (IMU to east-north-up, NaN
where unknown) and ``movement`` (where errors count), at 285.7 Hz. The world is magnetic east-north-up.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache, partial
from itertools import combinations
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch
from scipy.stats import kendalltau

from league import recordings
from league.contender import Setting, filters
from league.kept import each, key_of
from league.page import TUNED, short
from lie_rigid_body.league.table import FilterRow, reference

Array = NDArray[np.float64]

TRIAL: Final = (
    *("vqf VQF", "vqf offlineVQF", "vqf BasicVQF", "imufusion Ahrs"),
    *(f"ahrs {name}" for name in ("Madgwick", "EKF", "AQUA", "Mahony", "ROLEQ", "Fourati", "SAAM", "Tilt")),
)
"""Filters of the trial in which τ was first measured, but for one that is not on PyPI."""
TIE: Final = 0.05
"""Share of an error by which another may differ and count as the same."""
RESAMPLES: Final = 1000


class Job(NamedTuple):
    """A filter, by its number, with a setting over a recording, by its number."""

    number: int
    setting: Setting
    recording: int


@lru_cache
def recorded(folder: Path) -> tuple[recordings.Recording, ...]:
    """The recordings of a folder."""
    return tuple(recordings.read(folder))


def played(folder: Path, job: Job) -> float:
    """Error of a filter on a recording, degrees."""
    return recordings.error_deg(filters()[job.number], job.setting, recorded(folder)[job.recording])


def motions(folder: Path) -> Iterator[str]:
    """How each recording moves where errors count: rates, rad/s, accelerations of an axis, m/s², and rests."""
    for trial in recordings.read(folder):
        gyro = trial.given.gyro[trial.counted]
        rates = np.linalg.norm(gyro, axis=1)
        accelerations = trial.truth[trial.counted].apply(trial.given.acc[trial.counted])
        accelerations -= accelerations.mean(axis=0)
        frequency, power = welch(accelerations, recordings.RATE_HZ, nperseg=round(8.0 * recordings.RATE_HZ), axis=0)
        shares = np.cumsum(power.sum(axis=1)) / power.sum()
        low, high = frequency[np.searchsorted(shares, [0.1, 0.9])]
        middle, fast = np.quantile(rates, [0.5, 0.95])
        field = trial.truth[trial.counted].apply(1e6 * trial.given.mag[trial.counted]).std(axis=0)
        first = np.argmax(trial.counted) / recordings.RATE_HZ
        yield (
            f"{trial.name:42} rests {first:.0f} s, then {np.mean(rates < 0.1):.0%}; rate {middle:.2f}, 95 % below "
            f"{fast:.1f} rad/s, half correlated after {half_correlated_s(gyro):.2f} s; acceleration "
            f"{np.sqrt(np.mean(accelerations**2)):.2f} m/s² RMS, {low:.1f} to {high:.1f} Hz; "
            f"field {field.mean():.1f} µT"
        )


def half_correlated_s(rates: Array) -> float:
    """Time after which the autocorrelation of rates, shape (N, 3), falls to a half, s."""
    rates = rates - rates.mean(axis=0)
    spectrum = np.abs(np.fft.rfft(rates, 2 * len(rates), axis=0)) ** 2
    correlation = np.fft.irfft(spectrum, axis=0).sum(axis=1)[: len(rates)]
    return float(np.argmax(correlation < 0.5 * correlation[0]) / recordings.RATE_HZ)


def agreement(real: Array, ours: Array, *, tie: float = 0.0) -> float:
    """Kendall's τ-b of two orders; errors whose logarithms are within a tie count as the same."""
    if not tie:
        return float(kendalltau(real, ours)[0])
    one, other = (np.sign(pairs) * (np.abs(pairs) > np.log1p(tie)) for pairs in map(log_ratios, (real, ours)))
    return float(np.sum(one * other) / np.sqrt(np.sum(one**2) * np.sum(other**2)))


def log_ratios(errors: Array) -> Array:
    """Logarithms of the ratios of all pairs of errors."""
    i, j = np.triu_indices(len(errors), 1)
    return np.asarray(np.log(errors[i] / errors[j]))


def split_half(table: Array) -> Array:
    """τ-b of the medians over each half of the recordings with those over the other half, for every split."""
    count = table.shape[1]
    halves = [chosen for chosen in combinations(range(count), count // 2) if 0 in chosen or count % 2]
    draws = np.random.default_rng(0)
    halves = [halves[k] for k in draws.permutation(len(halves))[:RESAMPLES]]
    return np.array(
        [
            kendalltau(
                np.median(table[:, list(chosen)], axis=1),
                np.median(np.delete(table, list(chosen), axis=1), axis=1),
            )[0]
            for chosen in halves
        ]
    )


def compared(name: str, table: Array, ours: Array) -> str:
    """How two orders agree: errors in each recording, shape (F, R), and the league's, shape (F,)."""
    real = np.median(table, axis=1)
    draws = np.random.default_rng(0)
    resampled = [
        agreement(np.median(table[:, draws.integers(table.shape[1], size=table.shape[1])], axis=1), ours)
        for _ in range(RESAMPLES)
    ]
    low, high = np.quantile(resampled, [0.025, 0.975])
    logs = np.corrcoef(np.log(real), np.log(ours))[0, 1]
    return (
        f"{name}: tau-b {agreement(real, ours):.2f} ({low:.2f} to {high:.2f}), with ties within 5 % "
        f"{agreement(real, ours, tie=TIE):.2f}; half of the recordings against the other half "
        f"{np.median(split_half(table)):.2f}; correlation of the logarithms {logs:.2f}"
    )


def main() -> None:
    """Print the table, what agrees, and what is advised."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of mat, hdf5 or npz files")
    parser.add_argument("--motions", action="store_true", help="print how the recordings move, and run no filter")
    parser.add_argument("--save", action="store_true", help="write the numbers of the page about the league")
    given = parser.parse_args()
    if given.motions:
        print("\n".join(motions(given.data)))
        return
    rows = {row.name: row for row in reference().rows}
    playing: list[tuple[FilterRow, int, Setting]] = []
    for number, one in enumerate(filters()):
        playing.append((rows[one.full_name], number, {}))
        tuned = rows.get(f"{one.full_name}, {TUNED}")
        if tuned and "mems" in tuned.parameters:
            playing.append((tuned, number, tuned.parameters["mems"]))
    table = errors(given.data, [(number, setting) for _, number, setting in playing])
    ours = np.array([row.overall_deg for row, _, _ in playing])
    real = np.median(table, axis=1)
    print(f"{'filter':48} {'real':>8} {'league':>8} {'ratio':>6}")
    for k in np.argsort(real):
        print(f"{playing[k][0].name:48} {real[k]:8.3g} {ours[k]:8.3g} {real[k] / ours[k]:6.2f}")
    plain = np.array([not row.setting for row, _, _ in playing])
    trial = plain & [row.filter in TRIAL for row, _, _ in playing]
    for name, some in (
        ("filters of the trial", trial),
        ("all at the defaults", plain),
        ("all rows", np.ones_like(plain)),
    ):
        print(compared(name, table[some], ours[some]))
    by_name = {row.name: value for (row, _, _), value in zip(playing, real, strict=True)}
    for row, _, setting in playing:
        if row.setting:
            print(f"{row.filter} {dict(setting)}: {by_name[row.name] / by_name[row.filter]:.2f} of the default error")
    if given.save:
        content: dict[str, Any] = {
            "recordings": [recording.name for recording in recorded(given.data)],
            "attribution": "D. Laidig, M. Caruso, A. Cereatti, T. Seel, BROAD, Data 6(7):72, 2021",
            "licence": "CC BY 4.0",
            "errors_deg": {row.name: line.tolist() for (row, _, _), line in zip(playing, table, strict=True)},
        }
        recordings.NUMBERS.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def errors(folder: Path, playing: Sequence[tuple[int, Setting]]) -> Array:
    """Errors of filters with settings on the recordings of a folder, degrees, shape (F, R), rounded as the page is."""
    jobs = [Job(*one, k) for k in range(len(recorded(folder))) for one in playing]
    keys = [key_of(filters()[job.number], job.setting, recorded(folder)[job.recording].digest) for job in jobs]
    with ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        found = each(pool, partial(played, folder), jobs, keys, "recordings")
    return np.reshape([short(error) for error in found], (len(recorded(folder)), len(playing))).T


if __name__ == "__main__":
    main()
