"""Filters over real recordings: the data set BROAD (D. Laidig et al., Data 6(7):72, 2021), or npz files like it."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

from league.contender import Filter, Setting
from league.readings import Readings
from lie_rigid_body.league.playing import MIN_SHARE
from lie_rigid_body.league.table import LOST_DEG

BROAD_HZ: Final = 2000.0 / 7.0
TOGETHER: Final = 3
"""Samples of a recording that are averaged: to 95 Hz, which changes no filter's place."""
RATE_HZ: Final = BROAD_HZ / TOGETHER
NUMBERS: Final = Path(__file__).resolve().parents[1] / "data" / "real_recordings.json"
"""Errors of the league's filters on ten recordings: numbers only, with names, attribution and licence."""
_PUBLISHED: Final = {
    "gyro": "imu_gyr",
    "specific_force": "imu_acc",
    "magnetic_field": "imu_mag",
    "attitude_wxyz": "opt_quat",
    "movement": "movement",
}
"""Names in the files that the authors publish, by those in npz files."""


@dataclass(frozen=True)
class Recording:
    """What filters are given, the true attitudes, and where errors count."""

    name: str
    given: Readings
    truth: Rotation
    counted: NDArray[np.bool_]

    @property
    def digest(self) -> str:
        """Hash of the readings, as 16 hexadecimal digits."""
        vectors = (self.given.gyro, self.given.acc, self.given.mag)
        return sha256(b"".join(np.round(each, 9).tobytes() for each in vectors)).hexdigest()[:16]


def read(folder: Path) -> Iterator[Recording]:
    """The recordings of a folder, npz, mat or hdf5 files, averaged."""
    for path in sorted(each for each in folder.iterdir() if each.suffix in (".npz", ".mat", ".hdf5")):
        data = arrays(path)
        count = len(data["gyro"]) // TOGETHER * TOGETHER
        gyro, force, field = (
            data[name][:count].astype(float).reshape(-1, TOGETHER, 3).mean(axis=1)
            for name in ("gyro", "specific_force", "magnetic_field")
        )
        attitude = data["attitude_wxyz"][TOGETHER // 2 : count : TOGETHER][:, [1, 2, 3, 0]].astype(float)
        known = np.isfinite(attitude).all(axis=1)
        truth = Rotation.from_quat(np.where(known[:, np.newaxis], attitude, [0.0, 0.0, 0.0, 1.0]))
        moves = np.ravel(data["movement"])[TOGETHER // 2 : count : TOGETHER].astype(bool)
        east, north, up = np.median(truth.apply(field)[known & ~moves], axis=0)
        world = np.array([0.0, np.hypot(east, north), up])  # magnetic east-north-up
        t_ns = np.round(np.arange(len(gyro)) * 1e9 / RATE_HZ).astype(np.int64)
        readings = Readings(t_ns, RATE_HZ, gyro, force, 1e-6 * field, 1e-6 * world)
        yield Recording(path.stem, readings, truth, known & moves)


def arrays(path: Path) -> Mapping[str, Any]:
    """The arrays of a file, by the names of npz files."""
    if path.suffix == ".npz":
        return dict(np.load(path))
    if path.suffix == ".mat":
        content: Mapping[str, Any] = loadmat(path)
        return {name: content[published] for name, published in _PUBLISHED.items()}
    import h5py  # the authors' other format, of which nothing else has need

    with h5py.File(path) as file:
        return {name: file[published][:] for name, published in _PUBLISHED.items()}


def error_deg(each: Filter, setting: Setting, recording: Recording) -> float:
    """RMS of the total error where it counts, degrees; 180 where the filter gives no attitude in a tenth of it."""
    np.random.seed(1)  # noqa: NPY002 - what filters draw from
    try:
        with redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
            found = each.estimate(recording.given, **setting).as_quat()
    except (ValueError, np.linalg.LinAlgError):
        return LOST_DEG
    counted = recording.counted & np.isfinite(found).all(axis=1)
    if counted.sum() < MIN_SHARE * recording.counted.sum():
        return LOST_DEG
    angles = (Rotation.from_quat(found[counted]).inv() * recording.truth[counted]).magnitude()
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def medians() -> dict[str, float]:
    """Median error of each row of the league on ten real recordings, degrees."""
    content = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {"errors_deg": {}}
    return {name: float(np.median(errors)) for name, errors in content["errors_deg"].items()}
