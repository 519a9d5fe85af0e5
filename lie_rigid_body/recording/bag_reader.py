"""Reading a bag into arrays: one of this package, or one that ``ros2 bag record`` made of the running node."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
import yaml

from lie_rigid_body import messages
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING, TWIST, TWIST_STAMPED, has_fields_of
from lie_rigid_body.recording import folder_metadata
from lie_rigid_body.recording.bag_writer import METADATA
from lie_rigid_body.recording.mcap_reader import McapContents, RawTrack, read_file

T = TypeVar("T")

_WANTED: Final = (POSE_STAMPED, TWIST_STAMPED, TWIST, STRING)


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
    published_otherwise : int
        Messages of the three topics whose time of publishing is not their log time.
    others : tuple of str
        What the bag holds besides, in words: topics and attachments.
    undefined : tuple of str
        Topics among the three whose message definition is left out, or in a language that is not compared.
    without_checksum : int
        Chunks, or files without chunks, whose bytes stand under no checksum.
    """

    library: str
    scenario_texts: list[tuple[int, str]]
    poses: PoseTrack
    twists: TwistTrack
    expected_samples: int | None
    published_otherwise: int = 0
    others: tuple[str, ...] = ()
    undefined: tuple[str, ...] = ()
    without_checksum: int = 0


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
    contents = McapContents()
    information = _information(path / "metadata.yaml") if path.is_dir() else None
    for file in _files(path, information):
        read_file(file, _WANTED, contents)
    if information is not None:
        folder_metadata.hold(path / "metadata.yaml", information, contents)
    pose = _find(path, contents, "pose", POSE_STAMPED)
    twist = _find(path, contents, "twist", TWIST_STAMPED, TWIST)
    scenario = _find(path, contents, "scenario", STRING)
    own = (pose, twist, scenario)
    texts = _decoded(path, scenario, lambda: [messages.decode_string(p, i) for i, p in enumerate(scenario.payloads)])
    return Recording(
        contents.library,
        list(zip(scenario.log_times_ns, texts, strict=True)),
        _pose_track(path, pose),
        _twist_track(path, twist),
        _expected_samples(path, contents),
        sum(a != b for track in own for a, b in zip(track.log_times_ns, track.publish_times_ns, strict=True)),
        _others(contents, own),
        tuple(track.topic for track in own if not _is_defined(path, track)),
        contents.without_checksum,
    )


def _others(contents: McapContents, own: tuple[RawTrack, ...]) -> tuple[str, ...]:
    rest = [track for track in contents.tracks.values() if track.count and not any(track is known for known in own)]
    topics = [f"{track.topic} ({track.count} messages)" for track in rest]
    return (*topics, *([f"{contents.attachments} attachments"] if contents.attachments else []))


def _is_defined(path: Path, track: RawTrack) -> bool:
    """Whether the track's schema has a text that can be compared; if so it must have the fields of the type."""
    encoding, text = track.definition
    if encoding != "ros2msg" or not text:
        return False
    if not has_fields_of(text.decode(errors="replace"), track.message_type):
        raise BagError(
            f"{path}: topic {track.topic}: the definition of {track.message_type} is not that of ROS 2, by which "
            "others read it: restore a copy, or record again"
        )
    return True


def _pose_track(path: Path, track: RawTrack) -> PoseTrack:
    decoded = _decoded(path, track, lambda: messages.decode(track.payloads, messages.POSE_NUMBERS, stamped=True))
    assert decoded.stamps_ns is not None
    numbers = decoded.numbers
    return PoseTrack(
        track.topic, _log_times(track), decoded.stamps_ns, numbers[:, 3:], numbers[:, :3], decoded.frame_ids
    )


def _twist_track(path: Path, track: RawTrack) -> TwistTrack:
    stamped = track.message_type == TWIST_STAMPED
    decoded: Decoded = _decoded(
        path, track, lambda: messages.decode(track.payloads, messages.TWIST_NUMBERS, stamped=stamped)
    )
    numbers = decoded.numbers
    return TwistTrack(
        track.topic, _log_times(track), decoded.stamps_ns, numbers[:, 3:], numbers[:, :3], decoded.frame_ids
    )


def _log_times(track: RawTrack) -> Integers:
    return np.array(track.log_times_ns, dtype=np.uint64).astype(np.int64)


def _decoded(path: Path, track: RawTrack, decode: Callable[[], T]) -> T:
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


def _files(path: Path, information: Mapping[str, Any] | None) -> list[Path]:
    """The MCAP files of a bag, in the order of recording."""
    if not path.is_dir():
        return [path]
    files = (
        sorted(path.glob("*.mcap"), key=_natural)
        if information is None
        else [path / str(name) for name in information["relative_file_paths"]]
    )
    if not files:
        raise BagError(f"{path} is a folder without MCAP files: give a bag")
    return files


def _information(metadata: Path) -> Mapping[str, Any] | None:
    """What a rosbag2 folder's metadata say, or None without metadata: a recorder that was killed."""
    if not metadata.exists():
        return None
    try:
        information: dict[str, Any] = yaml.safe_load(metadata.read_text(encoding="utf-8"))[
            "rosbag2_bagfile_information"
        ]
        list(information["relative_file_paths"])
    except (OSError, ValueError, TypeError, LookupError, yaml.YAMLError):
        raise BagError(f"{metadata} is not the metadata of a rosbag2 bag: remake it with 'ros2 bag reindex'") from None
    return information


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]
