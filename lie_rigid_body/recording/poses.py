"""Poses of others: trajectories in text files and in bags, and the knots of a path that follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers, plain
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import NS, decimal_ns
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.batch import POSE
from lie_rigid_body.motion.path import RISING, Knots, refuse_first, require_path
from lie_rigid_body.scenario.parameter_table import read_parameters
from lie_rigid_body.system.bounded_input import read_text, real

MAX_TRAJECTORY_BYTES: Final = 256 * 2**20
"""Largest size of a text file of poses, bytes: an hour at 500 Hz, with 17 digits a number."""
MAX_NORM_ERROR: Final = 0.01
"""Largest distance of the norm of a quaternion in a file from 1: files round to three decimals and more."""
_LAYOUTS: Final = {
    (False, 8): (NS, [1, 2, 3, 4, 5, 6, 7]),
    (True, 8): (1, [1, 2, 3, 5, 6, 7, 4]),
    (True, 17): (1, [1, 2, 3, 5, 6, 7, 4]),
    (True, 5): (1, [-1, -1, -1, 1, 2, 3, 4]),
}
"""Layouts of lines, by whether commas separate their numbers, and by how many there are. Each has the nanoseconds of
its unit of time, and the columns of position and attitude x y z w; that of a zero is −1. They are TUM, EuRoC (scalar
first, perhaps with velocity and biases behind the pose), and attitudes alone."""
_KINDS: Final = "TUM (t x y z qx qy qz qw, s), EuRoC CSV (ns, position, qw qx qy qz) or t_ns,x,y,z,w"


def with_path(parameters: Mapping[str, object]) -> dict[str, object]:
    """Parameters of a scenario with the knots of its path, which are read from ``path_file``.

    They stay as they are where the motion is no path, or the knots are given.

    Raises
    ------
    InputError
        If a parameter is invalid, or the file has no poses that make a path.
    """
    given = {name: plain(value) for name, value in parameters.items()}
    values: dict[str, Any] = read_parameters(given) if given.get("motion") == "path" else {}
    if values.get("path_knots") or not values.get("path_file"):
        return given
    try:
        knots = read_poses(values["path_file"]).averaged(decimal_ns(values["path_interval"]))
    except InputError as error:
        raise ParameterError("path_file", str(error)) from None
    require_path(knots)
    return {**given, "path_knots": knots.numbers()}


def read_poses(path: str | Path) -> Knots:
    """The poses of a text file or of a bag, their times counted from the first one.

    Raises
    ------
    InputError
        If it cannot be read, its times do not rise, or a quaternion is not near unit norm.
    BagError
        If it is a bag that cannot be read.
    """
    times, poses = stamped_poses(path)
    since = times - times[0]
    refuse_first(f"{path}", "pose", since / NS, {RISING: np.diff(since, prepend=-1) <= 0})
    return Knots(since, poses[:, :3], poses[:, 3:])


def stamped_poses(path: str | Path, topic: str | None = None) -> tuple[Integers, Array]:
    """Stamps, ns, and poses, shape (N, 7), of a text file or of a bag; without a position it is 0.

    Parameters
    ----------
    path : str or Path
    topic : str, optional
        Topic of the bag, of any type with an attitude. By default the one of poses, or of several that is called so.

    Raises
    ------
    InputError
        If it cannot be read, or a quaternion is not near unit norm.
    BagError
        If it is a bag that cannot be read.
    """
    times, poses = _of_bag(Path(path), topic) if is_bag(path) else _of_text(path)
    lengths = quaternion.norm(poses[:, 3:])
    faults = {
        "has a number that is not finite: give finite ones": ~np.isfinite(poses).all(axis=1),
        f"has a quaternion whose norm is not 1 to {MAX_NORM_ERROR:g}: give unit quaternions": (
            ~(np.abs(lengths - 1.0) <= MAX_NORM_ERROR)
        ),
    }
    refuse_first(f"{path}", "pose", (times - times[0]) / NS, faults)
    return times, np.column_stack([poses[:, :3], poses[:, 3:] / lengths[:, np.newaxis]])


def is_bag(path: str | Path) -> bool:
    """Whether a path is that of a bag, and not of a text file."""
    from lie_rigid_body.recording.bag_files import SUFFIXES  # a node without a path needs nothing that reads bags

    return Path(path).is_dir() or Path(path).suffix.lower() in SUFFIXES


def _of_bag(path: Path, topic: str | None) -> tuple[Integers, Array]:
    """Stamps, ns, and poses of a topic, or of the one of poses."""
    from lie_rigid_body.recording.sqlite_reader import bag_contents
    from lie_rigid_body.recording.topic_messages import ATTITUDE_TYPES, POSE_TYPES, read_attitudes

    contents = bag_contents(path, lambda _, kind: kind in ATTITUDE_TYPES)
    if topic is None:
        found = sorted(
            each.topic for each in contents.tracks.values() if each.count and each.message_type in POSE_TYPES
        )
        named = [each for each in found if f"/{each}".endswith(f"/{POSE}")] if len(found) > 1 else found
        if len(named) != 1:
            raise InputError(
                f"{path} has poses on {listed(found) or 'no topic'}: give a bag with one such topic, or one .../{POSE}"
            )
        topic = named[0]
    track = read_attitudes(path, contents, topic)
    position = np.zeros((len(track), 3)) if track.position is None else track.position
    return track.stamps_ns, np.column_stack([position, track.attitude_xyzw])


def _of_text(path: str | Path) -> tuple[Integers, Array]:
    """Times, ns, and poses, shape (N, 7), of a text file. Its comments and its heading are left out."""
    from lie_rigid_body.recording.logs.times import nanoseconds

    times = list[int]()
    poses = list[list[float]]()
    for number, line in enumerate(read_text(path, MAX_TRAJECTORY_BYTES, kind="a file of poses").splitlines(), 1):
        cells = line.replace(",", " ").split()
        if not cells or line[0] == "#" or (line[0].isalpha() and not times):
            continue
        try:
            unit, columns = _LAYOUTS["," in line, len(cells)]
            numbers = [*map(real, cells), 0.0]
            times.append(nanoseconds(cells[0], unit))
        except (KeyError, ArithmeticError, ValueError):
            raise InputError(f"{path}, line {number}: {shown(line)} is no pose: give {_KINDS}") from None
        poses.append([numbers[column] for column in columns])
    if not times:
        raise InputError(f"{path} has no pose: give {_KINDS}")
    return np.array(times), np.array(poses)
