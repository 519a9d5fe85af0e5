"""Reading a bag into arrays: one of this package, or one that ``ros2 bag record`` made of the running node."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from lie_rigid_body import messages
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.bounded_input import load_yaml, read_text
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING, TWIST, TWIST_STAMPED, has_fields_of
from lie_rigid_body.recording import folder_metadata
from lie_rigid_body.recording.bag_writer import METADATA
from lie_rigid_body.recording.mcap_reader import ZSTD_MAGIC, McapContents, RawMessages, RawTrack, read_file
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.wording import listed, short_repr

_BATCH: Final = 32_768
"""Messages of poses and twists that a batch holds at least, but for the last one."""
_WHY: Final = {"scenario": ", which tells body, motion and frames, whatever --inertia says"}
LARGEST_METADATA: Final = 2**20
"""Largest size of the metadata.yaml of a folder, bytes."""


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

    __repr__ = short_repr


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

    __repr__ = short_repr


Track = TypeVar("Track", PoseTrack, TwistTrack)


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

    __repr__ = short_repr

    @property
    def pose_topic(self) -> str:
        """Name of the topic of the poses."""
        return self.poses.topic

    @property
    def twist_topic(self) -> str:
        """Name of the topic of the twists."""
        return self.twists.topic

    @property
    def stamped(self) -> bool:
        """Whether twists have stamps of their own."""
        return self.twists.stamps_ns is not None

    def batches(self) -> Iterator[tuple[PoseTrack, TwistTrack]]:
        """All poses and twists, as `Bag.batches` reads them."""
        yield self.poses, self.twists


class Bag:
    """A bag that is read in batches, as often as they are wanted: its memory does not grow with its length.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them. It is read once to its end, and what is damaged refused.
    progress : callable, optional
        Called with the number of bytes that were read since it was called last, in every pass.

    Attributes
    ----------
    library, scenario_texts, expected_samples, published_otherwise, others, undefined, without_checksum
        As in `Recording`.
    pose_topic, twist_topic : str
    stamped : bool
        Whether twists have stamps of their own.

    Raises
    ------
    BagError
        If it is no bag, cut off, damaged, or lacks one of the three topics; in one line, with the remedy.
    """

    def __init__(self, path: str | Path, progress: Callable[[int], object] = lambda count: None) -> None:
        self._path, self._progress = Path(path), progress
        metadata = self._path / "metadata.yaml"
        try:
            information = _information(metadata) if self._path.is_dir() else None
            self._files = _files(self._path, information)
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: give the path of an MCAP file") from None
        contents = McapContents()
        for _ in self._read(contents, (STRING,)):
            pass
        if information is not None:
            folder_metadata.hold(metadata, information, contents)
        pose = _find(self._path, contents, "pose", POSE_STAMPED)
        twist = _find(self._path, contents, "twist", TWIST_STAMPED, TWIST)
        scenario = _find(self._path, contents, "scenario", STRING)
        own = (pose, twist, scenario)
        for track in own:
            if track.encoding != "cdr":
                raise BagError(f"{self._path}: topic {track.topic} is encoded as {track.encoding!r}: give one in cdr")
        self._pose, self._twist = ((track.topic, track.message_type) for track in (pose, twist))
        self.pose_topic, self.twist_topic, self.stamped = pose.topic, twist.topic, twist.message_type == TWIST_STAMPED
        self.library = contents.library
        self.scenario_texts = self._texts(scenario)
        self.expected_samples = _expected_samples(self._path, contents)
        self.published_otherwise = sum(track.published_otherwise for track in own)
        self.others = _others(contents, own)
        self.undefined = tuple(track.topic for track in own if not _is_defined(self._path, track))
        self.without_checksum = contents.without_checksum

    def batches(self) -> Iterator[tuple[PoseTrack, TwistTrack]]:
        """All poses and twists in file order, some ten thousand at a time."""
        contents, decoded = McapContents(), [0, 0]
        for position in itertools.chain(self._read(contents, (self._pose[1], self._twist[1])), [None]):
            tracks = [contents.tracks.get(key) for key in (self._pose, self._twist)]
            waiting = sum(len(piece.starts) for track in tracks if track for piece in track.pieces)
            if position is None or waiting >= _BATCH:
                pieces = [[] if track is None else track.take() for track in tracks]
                yield self._poses(pieces[0], decoded[0]), self._twists(pieces[1], decoded[1])
                decoded = [n + sum(len(p.starts) for p in taken) for n, taken in zip(decoded, pieces, strict=True)]
            for track in contents.tracks.values():
                if (track.topic, track.message_type) not in (self._pose, self._twist):
                    track.take()
            if position is None or waiting >= _BATCH:
                contents.kept = 0

    def load(self) -> Recording:
        """The whole bag in memory."""
        poses, twists = zip(*self.batches(), strict=True)
        return Recording(
            self.library,
            self.scenario_texts,
            _joined(poses),
            _joined(twists),
            self.expected_samples,
            self.published_otherwise,
            self.others,
            self.undefined,
            self.without_checksum,
        )

    def _read(self, contents: McapContents, wanted: tuple[str, ...]) -> Iterator[int]:
        for file in self._files:
            before = 0
            for position in read_file(file, wanted, contents):
                self._progress(position - before)
                before = position
                yield position

    def _texts(self, scenario: RawTrack) -> list[tuple[int, str]]:
        found: list[tuple[int, str]] = []
        pieces = scenario.take()
        if pieces[0].data[pieces[0].starts[0] :].startswith(ZSTD_MAGIC):
            raise BagError(
                f"{self._path}: its messages are compressed one by one: record without '--compression-mode message', "
                "or unpack it with 'ros2 bag convert'"
            )
        for piece in pieces:
            for time, start, end in zip(piece.log_times_ns.tolist(), piece.starts, piece.ends, strict=True):
                with self._named(scenario.topic):
                    found.append((time, messages.decode_string(piece.data[start:end], len(found))))
        return found

    def _poses(self, pieces: list[RawMessages], first: int) -> PoseTrack:
        with self._named(self._pose[0]):
            log_times, decoded = _decoded(pieces, messages.POSE_NUMBERS, stamped=True, first=first)
        assert decoded.stamps_ns is not None
        numbers = decoded.numbers
        return PoseTrack(self._pose[0], log_times, decoded.stamps_ns, numbers[:, 3:], numbers[:, :3], decoded.frame_ids)

    def _twists(self, pieces: list[RawMessages], first: int) -> TwistTrack:
        with self._named(self._twist[0]):
            log_times, decoded = _decoded(pieces, messages.TWIST_NUMBERS, stamped=self.stamped, first=first)
        numbers = decoded.numbers
        return TwistTrack(
            self._twist[0], log_times, decoded.stamps_ns, numbers[:, 3:], numbers[:, :3], decoded.frame_ids
        )

    @contextmanager
    def _named(self, topic: str) -> Iterator[None]:
        try:
            yield
        except BagError as error:
            raise BagError(f"{self._path}: topic {topic}: {error}: record the bag again") from None


def read_bag(path: str | Path) -> Recording:
    """Read a bag into memory.

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
    return Bag(path).load()


def _decoded(pieces: list[RawMessages], numbers: int, *, stamped: bool, first: int) -> tuple[Integers, Decoded]:
    """Log times and contents of messages, the first of which has a number."""
    data = b"".join([piece.data for piece in pieces])
    offsets = np.cumsum([0, *(len(piece.data) for piece in pieces)]).tolist()[: len(pieces)]
    starts, ends, log_times = (
        np.concatenate([np.empty(0, dtype=np.int64), *columns])
        for columns in (
            [piece.starts + at for piece, at in zip(pieces, offsets, strict=True)],
            [piece.ends + at for piece, at in zip(pieces, offsets, strict=True)],
            [piece.log_times_ns for piece in pieces],
        )
    )
    return log_times, messages.decode_places(data, starts, ends, numbers, stamped=stamped, first=first)


def _joined(tracks: Sequence[Track]) -> Track:
    """Tracks that continue each other as one."""
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(track, name) for track in tracks])
        for name, value in vars(tracks[0]).items()
        if isinstance(value, np.ndarray)
    }
    frames = dict.fromkeys(frame for track in tracks for frame in track.frame_ids)
    return replace(tracks[0], frame_ids=tuple(frames), **columns)


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


def _find(path: Path, contents: McapContents, ending: str, *types: str) -> RawTrack:
    """The one track of these types whose topic has the given last name, or else the only one of these types."""
    alike = [track for (_, message_type), track in contents.tracks.items() if message_type in types]
    found = [track for track in alike if track.topic.rpartition("/")[2] == ending]
    if not found and len(alike) == 1:
        found = alike  # remapped
    if not found:
        wanted = f"topic .../{ending} ({' or '.join(types)}{_WHY.get(ending, '')})"
        raise BagError(f"{path} has no {wanted}: record it; there are {_list(contents)}")
    if len(found) > 1:
        names = listed([f"{track.topic} ({track.message_type})" for track in found])
        raise BagError(f"{path} has several topics .../{ending}: {names}: record those of one body")
    if not found[0].count:
        raise BagError(f"{path} has no message on {found[0].topic}: record it while the body is published")
    return found[0]


def _list(contents: McapContents) -> str:
    return listed([topic for topic, _ in contents.tracks]) or "no topic at all"


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
        information: dict[str, Any] = load_yaml(read_text(metadata, LARGEST_METADATA), str(metadata))[
            "rosbag2_bagfile_information"
        ]
        names = [str(name) for name in information["relative_file_paths"]]
    except (InputError, TypeError, LookupError):
        raise BagError(f"{metadata} is not the metadata of a rosbag2 bag: remake it with 'ros2 bag reindex'") from None
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise BagError(f"{metadata} names {twice[0]} twice: remake it with 'ros2 bag reindex'")
    return information


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]
