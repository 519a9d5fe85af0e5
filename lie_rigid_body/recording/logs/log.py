"""The readings of a log, each sensor with its own stamps, and what was taken for what."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.recording.bag_files import METADATA_FILE, SUFFIXES
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER, Vectors, read_bag
from lie_rigid_body.recording.logs.columns import read_tables
from lie_rigid_body.system.bounded_input import as_path

SENSORS: Final = (GYRO, ACCELEROMETER, MAGNETOMETER)
_ROS_1: Final = ".bag"


@short_dataclass
class Log:
    """Readings of a log in SI units, in the order of the file, whatever is wrong with them.

    Attributes
    ----------
    name : str
        Path, for messages.
    gyro : Vectors
        Rates, rad/s.
    accelerometer, magnetometer : Vectors or None
        Specific forces, m/s², and fields, T; None where there is no such sensor.
    taken : tuple of str
        Sentences about what was taken for what, and which units were converted: they are printed first.
    """

    name: str
    gyro: Vectors
    accelerometer: Vectors | None = None
    magnetometer: Vectors | None = None
    taken: tuple[str, ...] = ()

    @property
    def sensors(self) -> dict[str, Vectors]:
        """The sensors that there are, by their names."""
        found = {name: getattr(self, name) for name in SENSORS}
        return {name: vectors for name, vectors in found.items() if vectors is not None}


def read_log(
    path: str | Path,
    *,
    imu: str | None = None,
    magnetometer: str | None = None,
    columns: Mapping[str, str | int] | None = None,
) -> Log:
    """Read a log of a gyro and perhaps an accelerometer and a magnetometer.

    Parameters
    ----------
    path : str or Path
        A bag in MCAP or SQLite, a table in a text file, or a folder or a zip with one table a sensor.
    imu, magnetometer : str, optional
        Topics, where a bag has several of a type.
    columns : mapping of str to str or int, optional
        Headers of columns, or their numbers from 1, by ``t``, ``gyro_x`` to ``gyro_z``, ``accelerometer_x`` to ``_z``
        and ``magnetometer_x`` to ``_z``. A unit may follow, as in ``"wx:deg/s"``.

    Raises
    ------
    InputError
        If the file cannot be read, has no gyro, a cell that is no number, or sensors that do not overlap in time.
    BagError
        If it is a bag that cannot be read.
    """
    file = as_path(path, "log")
    if not isinstance(columns, Mapping | None):
        raise InputError(f'columns {shown(columns)}: give fields and columns, such as {{"gyro_x": "wx:deg/s"}}')
    if file.suffix.lower() == _ROS_1:
        raise InputError(f"{file} is a bag of ROS 1: convert it by rosbags-convert --src {file.name} --dst {file.stem}")
    if _is_bag(file):
        if columns:
            raise InputError(f"{file} is a bag, which has no columns: choose topics by imu and magnetometer")
        found, taken = read_bag(file, imu, magnetometer)
    else:
        if imu or magnetometer:
            raise InputError(f"{file} is no bag, and has no topics: name its columns by columns")
        found, taken = read_tables(file, {} if columns is None else columns)
    log = Log(f"{file}", found[GYRO], found.get(ACCELEROMETER), found.get(MAGNETOMETER), tuple(taken))
    _require_overlap(log)
    return log


def _is_bag(file: Path) -> bool:
    if file.is_dir():
        return (file / METADATA_FILE).exists() or any(
            each.suffix.lower() in SUFFIXES or each.name.lower().endswith(".mcap.zstd") for each in file.glob("*")
        )
    return file.suffix.lower() in SUFFIXES


def _require_overlap(log: Log) -> None:
    """Refuse sensors of which one begins after another one has ended."""
    spans = {name: (int(each.t_ns.min()), int(each.t_ns.max())) for name, each in log.sensors.items()}
    for one, other in combinations(spans, 2):
        if max(spans[one][0], spans[other][0]) > min(spans[one][1], spans[other][1]):
            told = listed([f"{name} {spans[name][0] / NS:.9g} to {spans[name][1] / NS:.9g} s" for name in (one, other)])
            raise InputError(f"{log.name}: sensors do not overlap in time, {told}: record them together")
