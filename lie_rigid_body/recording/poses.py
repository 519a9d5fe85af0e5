"""Poses of others: trajectories in text files and in bags, and the knots of a path that follow from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, plain
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.batch import POSE
from lie_rigid_body.motion.path import MAX_KNOTS, Knots
from lie_rigid_body.recording.bag_files import SUFFIXES, BagFiles
from lie_rigid_body.recording.topic_messages import ATTITUDE_TYPES, read_attitudes
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.system.bounded_input import read_text, real

MAX_TRAJECTORY_BYTES: Final = 256 * 2**20
"""Largest size of a text file of poses, bytes: an hour at 500 Hz, with 17 digits a number."""
MAX_NORM_OFF: Final = 0.01
"""Largest distance of the norm of a quaternion in a file from 1: files round to three decimals and more."""
_MAX_NS: Final = 2**62
_LAYOUTS: Final = {
    (False, 8): (NS, (1, 2, 3), (4, 5, 6, 7)),
    (True, 8): (1, (1, 2, 3), (5, 6, 7, 4)),
    (True, 17): (1, (1, 2, 3), (5, 6, 7, 4)),
    (True, 5): (1, (), (1, 2, 3, 4)),
}
"""Layouts of lines, by whether commas separate their numbers, and by how many there are. Each has the nanoseconds of
its unit of time, the columns of the position, and those of the attitude x y z w. They are TUM, EuRoC (scalar first,
perhaps with velocity and biases behind the pose), and attitudes alone, whose position is 0."""
_KINDS: Final = "TUM (t x y z qx qy qz qw, s), EuRoC CSV (ns, position, qw qx qy qz) or t_ns,x,y,z,w"


def with_path(parameters: Mapping[str, object]) -> dict[str, object]:
    """Parameters of a scenario with the knots of its path, which are read from ``path_file``.

    They stay as they are where the motion is no path, or the knots are given.

    Raises
    ------
    InputError
        If the file has no poses that make knots.
    """
    given = dict(parameters)
    path_file, interval = (BY_NAME[name].read(given.get(name, BY_NAME[name].default)) for name in _OF_FILE)
    if given.get("motion") != "path" or not path_file or plain(given.get("path_knots")):
        return given
    try:
        knots = read_poses(str(path_file)).averaged(round(Decimal(repr(interval)) * NS))
    except InputError as error:
        raise ParameterError("path_file", str(error)) from None
    if len(knots.t_ns) > MAX_KNOTS:
        raise ParameterError(
            "path_interval",
            f"{interval:g} s leaves {len(knots.t_ns)} knots, more than {MAX_KNOTS}: give at least "
            f"{_ceiling(float(knots.t_ns[-1]) / NS / MAX_KNOTS):g} s, or a shorter path_file",
        )
    return {**given, "path_knots": knots.numbers()}


_OF_FILE: Final = ("path_file", "path_interval")


def _ceiling(seconds: float) -> float:
    """A time above one, s, of two digits."""
    return float(f"{1.1 * seconds:.2g}")


def read_poses(path: str | Path) -> Knots:
    """The poses of a text file or of a bag, their times counted from the first one.

    Raises
    ------
    InputError
        If it cannot be read, its times do not rise, or a quaternion is not near unit norm.
    """
    is_bag = Path(path).is_dir() or Path(path).suffix.lower() in SUFFIXES
    times, numbers = _of_bag(Path(path)) if is_bag else _of_text(str(path))
    lengths = quaternion.norm(numbers[:, 3:])
    if not np.isfinite(numbers).all() or (np.abs(lengths - 1.0) > MAX_NORM_OFF).any():
        i = int(np.argmax(~(np.isfinite(numbers).all(axis=1) & (np.abs(lengths - 1.0) <= MAX_NORM_OFF))))
        raise InputError(
            f"{path}: pose {i + 1} has a quaternion of the norm {lengths[i]:.6g}, or a number that is not finite: give "
            "unit quaternions"
        )
    since = np.array([time - times[0] for time in times], dtype=np.int64)
    if (np.diff(since) <= 0).any():
        i = int(np.argmax(np.diff(since) <= 0))
        raise InputError(
            f"{path}: pose {i + 2} is at {times[i + 1]} ns, which is not after the one before, {times[i]} ns: give "
            "rising times"
        )
    return Knots(since, numbers[:, :3], numbers[:, 3:] / lengths[:, np.newaxis])


def _of_bag(path: Path) -> tuple[list[int], Array]:
    """Stamps, ns, and poses, shape (N, 7), of the one topic of poses in a bag, or of the one that is called so."""
    contents = BagFiles(path).contents(lambda topic, kind: kind in ATTITUDE_TYPES)
    found = {topic.topic for topic in contents.tracks.values() if topic.count and topic.message_type in ATTITUDE_TYPES}
    called = [topic for topic in found if topic.rpartition("/")[2] == POSE] if len(found) > 1 else [*found]
    if len(called) != 1:
        raise InputError(
            f"{path} has poses on {listed(sorted(found)) or 'no topic'}: give a bag with one such topic, or with one "
            f"that is called .../{POSE}"
        )
    track = read_attitudes(path, contents, called[0])
    if track.position is None:
        raise InputError(f"{path}: topic {called[0]} has attitudes without positions: give one of poses")
    return track.stamps_ns.tolist(), np.column_stack([track.position, track.attitude_xyzw])


def _of_text(path: str) -> tuple[list[int], Array]:
    """Times, ns, and poses, shape (N, 7), of a text file."""
    times = list[int]()
    poses = list[list[float]]()
    for time, pose in _rows(path, read_text(path, MAX_TRAJECTORY_BYTES, kind="a file of poses")):
        times.append(time)
        poses.append(pose)
    if not times:
        raise InputError(f"{path} has no pose: give {_KINDS}")
    return times, np.array(poses)


def _rows(path: str, text: str) -> Iterator[tuple[int, list[float]]]:
    """Time, ns, and pose of each line that is no comment, nor the heading."""
    seen = False
    for number, line in enumerate(text.splitlines(), 1):
        content = line.partition("#")[0].strip()
        cells = [cell.strip() for cell in content.split(",")] if "," in content else content.split()
        is_heading = not seen and any(cell[:1].isalpha() for cell in cells)
        if not cells or is_heading:
            continue
        seen = True
        layout = _LAYOUTS.get(("," in content, len(cells)))
        if layout is None:
            raise InputError(f"{path}, line {number}: {shown(content)} is no pose: give {_KINDS}")
        unit, position, attitude = layout
        try:
            pose = [*(real(cells[i]) for i in position), *(real(cells[i]) for i in attitude)]
            time_ns = _nanoseconds(cells[0], unit)
        except ValueError:
            raise InputError(
                f"{path}, line {number}: {shown(content)} is not of numbers, or has no time: give {_KINDS}"
            ) from None
        yield time_ns, [*[0.0] * (3 - len(position)), *pose]


def _nanoseconds(text: str, unit: int) -> int:
    """A time in units of so many ns, as its decimal tells it, in ns; whole ones of a time in ns."""
    if not abs(real(text)) * unit < _MAX_NS:
        raise ValueError(f"no time: {text!r}")
    time = Decimal(text) * unit
    if unit == 1 and time != time.to_integral_value():
        raise ValueError(f"no whole ns: {text!r}")
    return round(time)
