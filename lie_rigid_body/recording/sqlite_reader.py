"""Reading an SQLite file of rosbag2 into raw messages by topic, where the library `rosbags` is installed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.mcap_contents import FileSpan, McapContents, Parts, RawMessages, RawTrack, TrackKey
from lie_rigid_body.recording.records import LAST_TIME

SUFFIX: Final = ".db3"
"""Suffix of the names of such files."""
_AT_ONCE: Final = 4096
"""Number of messages that are read together."""


def read_database(path: Path, contents: McapContents) -> Parts:
    """Read a file, and count its messages, some thousand at a time, in the order of their log times.

    Parameters
    ----------
    path : Path
    contents : McapContents
        What it holds is added there.

    Yields
    ------
    size : int
        Bytes that were read, about.
    found : Found
        Those messages among the last ones that are wanted.

    Raises
    ------
    BagError
        If the file cannot be read, or rosbags is not installed.
    """
    with _opened(path) as reader:
        tracks = {(track := _track(connection, contents)).key: track for connection in reader.connections}
        count, first, last = 0, LAST_TIME, 0
        for size, found in _read(path, reader, tracks):
            for key, messages in found.items():
                tracks[key].count += len(messages)
                count += len(messages)
                first, last = min(first, int(messages.log_times_ns.min())), max(last, int(messages.log_times_ns.max()))
            yield size, {key: messages for key, messages in found.items() if contents.wanted(*key)}
    contents.files.append(FileSpan(path.name, count, first, last))
    contents.again.append(partial(_read_again, path))
    contents.without_checksum += 1


def _read_again(path: Path, keys: Collection[TrackKey]) -> Parts:
    with _opened(path) as reader:
        yield from _read(path, reader, keys)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Context of a reader of the file, whose errors are told in one line."""
    try:
        from rosbags.rosbag2 import Reader
    except ModuleNotFoundError:
        raise BagError(
            f"{path} is an SQLite bag: install the library that reads it, pip install 'lie-rigid-body[sqlite]', or "
            "record with 'ros2 bag record -s mcap'"
        ) from None
    if not path.exists():
        raise BagError(f"{path} does not exist: give the path of a bag")
    try:
        with Reader(path) as reader:
            yield reader
    except (BagError, MemoryError):
        raise
    except Exception as error:  # the library's, and those of the library below it
        what = " ".join(f"{type(error).__name__}: {error}".split())
        if isinstance(error, AttributeError | KeyError | TypeError):  # SQLite takes values of any type in any column
            what = "a column of its tables has a value of another type, or one that is unknown"
        raise BagError(f"{path} cannot be read as an SQLite bag: {what:.80}: restore a copy, or record again") from None


def _read(path: Path, reader: Any, keys: Collection[TrackKey]) -> Parts:
    """Bytes that were read, about, and messages of some tracks, some thousand at a time."""
    own = [connection for connection in reader.connections if (connection.topic, connection.msgtype) in keys]
    messages, size = reader.messages(own), path.stat().st_size
    total = max(1, sum(connection.msgcount for connection in own))
    while own and (some := list(islice(messages, _AT_ONCE))):
        by_track: dict[TrackKey, list[tuple[int, bytes]]] = {}
        for connection, time, data in some:
            for column, value, kind in (("timestamp", time, int), ("data", data, bytes)):
                if not isinstance(value, kind):
                    raise _wrong_type(path, connection.topic, column, value)
            by_track.setdefault((connection.topic, connection.msgtype), []).append((time, data))
        yield size * len(some) // total, {key: RawMessages.of_payloads(of) for key, of in by_track.items()}


def _wrong_type(path: Path, topic: str, column: str, value: object) -> BagError:
    wanted = "an integer" if column == "timestamp" else "a blob"
    found = {str: "text", float: "a real number", int: "an integer", bytes: "a blob"}.get(type(value), "nothing")
    what = f"a message on {topic} has {found} in the column {column}, where {wanted} belongs"
    return BagError(f"{path} is damaged: {what}: restore a copy, or record again")


def _track(connection: Any, contents: McapContents) -> RawTrack:
    key, encoding = (connection.topic, connection.msgtype), connection.ext.serialization_format
    kind = "ros2msg" if connection.msgdef.format.name == "MSG" else ""
    return contents.tracks.setdefault(key, RawTrack(*key, encoding, (kind, connection.msgdef.data.encode())))
