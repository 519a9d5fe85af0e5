"""Bags in SQLite, the default of rosbag2 until ROS 2 Humble: their topics, and their messages part by part."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

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

_TOPICS: Final = (
    "SELECT name, type, serialization_format, count(messages.id) FROM topics "
    "LEFT JOIN messages ON topic_id = topics.id GROUP BY topics.id"
)
"""Query of the topics, and how many messages each has."""
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
    if bag.files[0].suffix.lower() != SUFFIXES[1]:
        return bag.contents(wanted)
    contents = McapContents()
    for file in bag.files:
        with _opened(file) as connection:
            for name, kind, encoding, count in connection.execute(_TOPICS):
                contents.tracks.setdefault((name, kind), RawTopic(name, kind, encoding)).count += count
        contents.again.append(partial(_messages, file))
    return contents


def _messages(file: Path, keys: Collection[TopicKey], _: Progress) -> Iterator[ChunkMessages]:
    """Messages of some topics of a file, in the order in which they were recorded; nobody is told of the progress."""
    with _opened(file) as bag:
        for name, kind in keys:
            rows = bag.execute(
                "SELECT timestamp, data FROM messages JOIN topics ON topic_id = topics.id "
                "WHERE name = ? AND type = ? ORDER BY messages.id",
                (name, kind),
            )
            while found := rows.fetchmany(_PART):
                yield {(name, kind): RawMessages.of_payloads(found)}


@contextmanager
def _opened(file: Path) -> Iterator[sqlite3.Connection]:
    """A file opened for reading only."""
    import sqlite3  # which a Python may lack

    try:
        with closing(sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)) as bag:
            yield bag
    except (sqlite3.Error, TypeError, ValueError) as error:
        raise BagError(f"{file} cannot be read as a bag in SQLite: {error}: restore it, or record it again") from None
