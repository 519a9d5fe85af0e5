"""The readings of a log, each sensor with its own stamps, and what was taken for what."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.recording.bag_files import METADATA_FILE, SUFFIXES
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER, Vectors, read_bag
from lie_rigid_body.recording.logs.columns import GivenColumns, read_tables
from lie_rigid_body.system.bounded_input import as_path

SENSORS: Final = (GYRO, ACCELEROMETER, MAGNETOMETER)
_ROS_1: Final = ".bag"
_OF_BAGS: Final = (*SUFFIXES, ".mcap.zstd", METADATA_FILE)


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
        return {name: vectors for name in SENSORS if (vectors := getattr(self, name)) is not None}


def read_log(
    path: str | Path,
    *,
    imu: str | None = None,
    magnetometer: str | None = None,
    columns: GivenColumns | None = None,
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
        remedy = f"convert it by rosbags-convert --src {file} --dst {file.with_suffix('')}"
        raise InputError(f"{file} is a bag of ROS 1: {remedy}")
    if _is_bag(file):
        if columns:
            raise InputError(f"{file} is a bag, which has no columns: choose topics by imu and magnetometer")
        found, taken = read_bag(file, imu, magnetometer)
    else:
        if imu or magnetometer:
            raise InputError(f"{file} is no bag, and has no topics: name its columns by columns")
        found, taken = read_tables(file, columns or {})
    log = Log(f"{file}", taken=tuple(taken), **found)
    times = {name: vectors.t_ns for name, vectors in log.sensors.items()}
    require_overlap(log.name, times, "record them together")
    return log


def _is_bag(path: Path) -> bool:
    files = path.iterdir() if path.is_dir() else [path]
    return any(file.name.lower().endswith(_OF_BAGS) for file in files)


def require_overlap(name: str, times: Mapping[str, Integers], remedy: str) -> None:
    """Refuse times, ns, of which some begin after others have ended.

    Parameters
    ----------
    name : str
        Name of the log.
    times : mapping of str to ndarray of int64
    remedy : str
    """
    early = min(times, key=lambda each: times[each].max())
    late = max(times, key=lambda each: times[each].min())
    end_s = times[early].max() / NS
    begin_s = times[late].min() / NS
    if begin_s > end_s:
        told = f"{early} ends at {end_s:.9g} s, {late} begins at {begin_s:.9g} s"
        raise InputError(f"{name}: {early} and {late} do not overlap in time, {told}: {remedy}")
