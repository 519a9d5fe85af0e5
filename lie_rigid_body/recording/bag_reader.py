"""Reading a bag into arrays: one of this package, or one that ``ros2 bag record`` made of the running node."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
import yaml

from lie_rigid_body import messages
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING, TWIST, TWIST_STAMPED
from lie_rigid_body.recording.bag_writer import METADATA
from lie_rigid_body.recording.mcap_reader import McapContents, RawTrack, read_file

T = TypeVar("T")

TYPES: Final = (POSE_STAMPED, TWIST_STAMPED, TWIST, STRING)
"""The message types of a recording."""


@dataclass(frozen=True)
class PoseTrack:
    """The messages of the pose topic, in file order.

    Parameters
    ----------
    topic : str
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,)
    attitudes_xyzw : ndarray, shape (N, 4)
        As recorded: not normalised, perhaps not finite.
    positions : ndarray, shape (N, 3)
    frame_ids : tuple of str
        The distinct frame names, in order of appearance.
    """

    topic: str
    log_times_ns: Integers
    stamps_ns: Integers
    attitudes_xyzw: Array
    positions: Array
    frame_ids: tuple[str, ...]


@dataclass(frozen=True)
class TwistTrack:
    """The messages of the twist topic, in file order.

    Parameters
    ----------
    topic : str
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,), or None
        None for a bare Twist.
    body_rates : ndarray, shape (N, 3)
        The angular part, rad/s.
    linear : ndarray, shape (N, 3)
        m/s
    frame_ids : tuple of str
        The distinct frame names, in order of appearance; empty for a bare Twist.
    """

    topic: str
    log_times_ns: Integers
    stamps_ns: Integers | None
    body_rates: Array
    linear: Array
    frame_ids: tuple[str, ...]


@dataclass(frozen=True)
class Recording:
    """The messages of a run that a bag holds.

    Parameters
    ----------
    library : str
        The software that wrote the file.
    scenario_texts : list of (int, str)
        Log time, ns, and JSON of every scenario message, in file order.
    poses : PoseTrack
    twists : TwistTrack
    expected_samples : int or None
        How many samples the writer says it wrote, where it does.
    """

    library: str
    scenario_texts: list[tuple[int, str]]
    poses: PoseTrack
    twists: TwistTrack
    expected_samples: int | None


def read_bag(path: str | Path) -> Recording:
    """Read a bag.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them.

    Returns
    -------
    Recording

    Raises
    ------
    BagError
        If it is no bag, cut off, damaged, or lacks one of the three topics; in one line, with the remedy.
    """
    path = Path(path)
    return recording_in(path, read_contents(path, TYPES))


def read_contents(path: Path, wanted: Collection[str]) -> McapContents:
    """The raw messages of a bag, a file or a folder of them, with the payloads of the wanted types.

    Raises
    ------
    BagError
        If it is no bag, cut off or damaged.
    """
    contents = McapContents()
    for file in _files(path):
        read_file(file, wanted, contents)
    return contents


def recording_in(path: Path, contents: McapContents) -> Recording:
    """The recording in a bag's contents, which hold the payloads of `TYPES`; see `read_bag`."""
    pose = _find(path, contents, "pose", POSE_STAMPED)
    twist = _find(path, contents, "twist", TWIST_STAMPED, TWIST)
    scenario = _find(path, contents, "scenario", STRING)
    texts = decoded(path, scenario, lambda: [messages.decode_string(p, i) for i, p in enumerate(scenario.payloads)])
    return Recording(
        contents.library,
        list(zip(scenario.log_times_ns, texts, strict=True)),
        _pose_track(path, pose),
        _twist_track(path, twist),
        _expected_samples(path, contents),
    )


def _pose_track(path: Path, track: RawTrack) -> PoseTrack:
    read = decoded(path, track, lambda: messages.decode(track.payloads, messages.POSE_NUMBERS, stamped=True))
    assert read.stamps_ns is not None
    numbers = read.numbers
    return PoseTrack(track.topic, _log_times(track), read.stamps_ns, numbers[:, 3:], numbers[:, :3], read.frame_ids)


def _twist_track(path: Path, track: RawTrack) -> TwistTrack:
    stamped = track.message_type == TWIST_STAMPED
    read: Decoded = decoded(
        path, track, lambda: messages.decode(track.payloads, messages.TWIST_NUMBERS, stamped=stamped)
    )
    numbers = read.numbers
    return TwistTrack(track.topic, _log_times(track), read.stamps_ns, numbers[:, 3:], numbers[:, :3], read.frame_ids)


def _log_times(track: RawTrack) -> Integers:
    return np.array(track.log_times_ns, dtype=np.uint64).astype(np.int64)


def decoded(path: Path, track: RawTrack, decode: Callable[[], T]) -> T:
    """What a decoder makes of a track; its errors name bag and topic."""
    if track.encoding != "cdr":
        raise BagError(f"{path}: topic {track.topic} is encoded as {track.encoding!r}: only cdr is read")
    try:
        return decode()
    except BagError as error:
        raise BagError(f"{path}: topic {track.topic}: {error}: record the bag again") from None


def _find(path: Path, contents: McapContents, ending: str, *types: str) -> RawTrack:
    """The one track of these types whose topic has the given last name, or else the only one of these types."""
    alike = [track for (_, message_type), track in contents.tracks.items() if message_type in types]
    found = [track for track in alike if track.topic.rpartition("/")[2] == ending]
    if not found and len(alike) == 1:
        found = alike  # remapped
    if not found:
        raise BagError(f"{path} has no topic .../{ending} of type {' or '.join(types)}; it has {_list(contents)}")
    if len(found) > 1:
        names = ", ".join(f"{track.topic} ({track.message_type})" for track in found)
        raise BagError(f"{path} has several topics .../{ending}: {names}: record those of one body")
    if not found[0].count:
        raise BagError(f"{path} has no message on {found[0].topic}: record it while the body is published")
    return found[0]


def _list(contents: McapContents) -> str:
    return ", ".join(f"{topic} ({kind})" for topic, kind in contents.tracks) or "no topic at all"


def _expected_samples(path: Path, contents: McapContents) -> int | None:
    text = contents.metadata.get(METADATA, {}).get("samples")
    if text is not None and not re.fullmatch("[0-9]{1,18}", text):
        raise BagError(f"{path} is damaged: its metadata counts {text!r} samples: record it again")
    return None if text is None else int(text)


def _files(path: Path) -> list[Path]:
    """The MCAP files of a bag, in the order of recording."""
    if not path.is_dir():
        return [path]
    listed = _listed_files(path / "metadata.yaml")
    files = sorted(path.glob("*.mcap"), key=_natural) if listed is None else [path / name for name in listed]
    if not files:
        raise BagError(f"{path} is a folder without MCAP files: give a bag")
    return files


def _listed_files(metadata: Path) -> list[str] | None:
    """The files that a rosbag2 folder's metadata name, or None without metadata: a recorder that was killed."""
    if not metadata.exists():
        return None
    try:
        information = yaml.safe_load(metadata.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [str(name) for name in information["relative_file_paths"]]
    except (OSError, ValueError, TypeError, LookupError, yaml.YAMLError):
        raise BagError(f"{metadata} is not the metadata of a rosbag2 bag: remake it with 'ros2 bag reindex'") from None
    return names


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]
