"""Bags in SQLite, the default of rosbag2 until ROS 2 Humble: their topics, and their messages part by part."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_files import SUFFIXES, BagFiles
from lie_rigid_body.recording.mcap_contents import (
    ChunkMessages,
    McapContents,
    Progress,
    RawMessages,
    RawTopic,
    TopicFilter,
    TopicKey,
)

if TYPE_CHECKING:
    import sqlite3

_PART: Final = 10_000
"""Messages that are read at once."""


def bag_contents(path: str | Path, wanted: TopicFilter) -> McapContents:
    """Topics of a bag in MCAP, whose messages that are wanted are kept, or in SQLite, whose messages are read again.

    Raises
    ------
    BagError
        If it is no bag, or cut off or damaged.
    """
    bag = BagFiles(path)
    if not any(file.suffix.lower() == SUFFIXES[1] for file in bag.files):
        return bag.contents(wanted)
    contents = McapContents()
    for file in bag.files:
        _count(file, contents)
        contents.again.append(partial(_messages, file))
    return contents


def _count(file: Path, contents: McapContents) -> None:
    """Put the topics of a file, and how many messages each has, into the contents."""
    with _opened(file) as bag:
        rows = bag.execute(
            "SELECT name, type, serialization_format, count(messages.id) FROM topics "
            "LEFT JOIN messages ON topic_id = topics.id GROUP BY topics.id"
        )
        for name, kind, encoding, count in rows:
            contents.tracks.setdefault((name, kind), RawTopic(name, kind, encoding)).count += count


def _messages(file: Path, keys: Collection[TopicKey], progress: Progress) -> Iterator[ChunkMessages]:
    """Messages of some topics of a file, in the order in which they were recorded."""
    with _opened(file) as bag:
        for name, kind in keys:
            rows = bag.execute(
                "SELECT timestamp, data FROM messages JOIN topics ON topic_id = topics.id "
                "WHERE name = ? AND type = ? ORDER BY messages.id",
                (name, kind),
            )
            while found := rows.fetchmany(_PART):
                progress(sum(len(data) for _, data in found))
                yield {(name, kind): RawMessages.of_payloads(found)}


@contextmanager
def _opened(file: Path) -> Iterator[sqlite3.Connection]:
    """A file opened for reading only."""
    import sqlite3  # which a Python may lack

    try:
        with closing(sqlite3.connect(f"file:{quote(str(file.resolve()))}?mode=ro", uri=True)) as bag:
            yield bag
    except (sqlite3.Error, TypeError, ValueError) as error:
        raise BagError(f"{file} cannot be read as a bag in SQLite: {error}: restore it, or record it again") from None
