"""Reading an SQLite file of rosbag2 into raw messages by topic, where the library `rosbags` is installed."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.mcap_contents import FileSpan, McapContents, RawMessages, RawTrack, Wanted

SUFFIX: Final = ".db3"
"""Of the names of such files."""
_AT_ONCE: Final = 4096
"""Messages that are read together."""


def read_database(path: Path, wanted: Wanted, into: McapContents) -> Iterator[int]:
    """Add a file's messages to the tracks, some thousand at a time, in the order of their log times.

    Parameters
    ----------
    path : Path
    wanted : callable
        Which messages are kept until they are taken. See `Wanted`.
    into : McapContents

    Yields
    ------
    int
        About the bytes that were read.

    Raises
    ------
    BagError
        If the file cannot be read, or rosbags is not installed.
    """
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
            yield from _read(path, reader, wanted, into)
    except (BagError, MemoryError, GeneratorExit):
        raise
    except (AttributeError, KeyError, TypeError):  # SQLite takes values of any type in any column
        what = "a column of its tables has a value of another type, or one that is unknown"
        raise BagError(f"{path} cannot be read as an SQLite bag: {what}: restore a copy, or record again") from None
    except Exception as error:  # the library's, and those of the library below it
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise BagError(f"{path} cannot be read as an SQLite bag: {what:.80}: restore a copy, or record again") from None


def _read(path: Path, reader: Any, wanted: Wanted, into: McapContents) -> Iterator[int]:
    tracks = {connection.id: _track(connection, into) for connection in reader.connections}
    messages, size = reader.messages(), path.stat().st_size
    into.allow(size)
    total, count, first, last = max(1, reader.message_count), 0, 2**63 - 1, 0
    while some := list(islice(messages, _AT_ONCE)):
        by_track: dict[int, list[tuple[int, bytes]]] = {}
        for connection, time, data in some:
            for column, value, kind in (("timestamp", time, int), ("data", data, bytes)):
                if not isinstance(value, kind):
                    raise _wrong_type(path, connection.topic, column, value)
            by_track.setdefault(connection.id, []).append((time, data))
        for number, own in by_track.items():
            track = tracks[number]
            track.count += len(own)
            if wanted(track.topic, track.message_type):
                track.pieces.append(_piece(own))
                if into.keep(sum(len(data) for _, data in own), len(own)):
                    raise BagError(f"{path} has messages of {into.kept} bytes, more than is read: record it again")
        count += len(some)
        first, last = min(first, some[0][1]), max(last, some[-1][1])
        yield size * min(count, total) // total
    into.files.append(FileSpan(path.name, count, first, last))
    into.without_checksum += 1


def _wrong_type(path: Path, topic: str, column: str, value: object) -> BagError:
    wanted = "an integer" if column == "timestamp" else "a blob"
    found = {str: "text", float: "a real number", int: "an integer", bytes: "a blob"}.get(type(value), "nothing")
    what = f"a message on {topic} has {found} in the column {column}, where {wanted} belongs"
    return BagError(f"{path} is damaged: {what}: restore a copy, or record again")


def _track(connection: Any, into: McapContents) -> RawTrack:
    key, encoding = (connection.topic, connection.msgtype), connection.ext.serialization_format
    kind = "ros2msg" if connection.msgdef.format.name == "MSG" else ""
    return into.tracks.setdefault(key, RawTrack(*key, encoding, (kind, connection.msgdef.data.encode())))


def _piece(messages: list[tuple[int, bytes]]) -> RawMessages:
    ends = np.cumsum([len(data) for _, data in messages])
    starts = ends - [len(data) for _, data in messages]
    times = np.array([time for time, _ in messages], dtype=np.int64)
    return RawMessages(b"".join(data for _, data in messages), starts, ends, times)
