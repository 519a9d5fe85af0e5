"""What a bag holds, of one file or of several: raw messages by topic, and where in the files they are."""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Final, TypeAlias

from lie_rigid_body.arrays import Integers
from lie_rigid_body.bounded_input import open_file
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.wording import short_repr

Wanted: TypeAlias = Callable[[str, str], bool]
"""Whether the messages of a topic, by its name and message type, are kept until they are taken."""

_KEPT_AT_LEAST: Final = 64 * 2**20
_KEPT_PER_BYTE: Final = 200
"""Limits of what a file's messages may take, bytes and bytes per byte of the file. What moves compresses to 1/20."""
_PER_MESSAGE: Final = 100
"""About the bytes that a message takes beside its content."""


@dataclass(frozen=True)
class RawMessages:
    """Messages of one track that stand in one chunk, undecoded, in file order.

    Parameters
    ----------
    data : bytes
        The chunk.
    starts, ends : ndarray of int64, shape (N,)
        Where in it each payload begins and ends.
    log_times_ns : ndarray of int64, shape (N,)
    """

    data: bytes
    starts: Integers
    ends: Integers
    log_times_ns: Integers


@dataclass
class RawTrack:
    """The messages of one type on one topic, undecoded, in file order.

    Attributes
    ----------
    topic, message_type, encoding : str
    definition : tuple of (str, bytes)
        Encoding and text of its schema.
    pieces : list of RawMessages
        Those not yet taken; empty when they were not wanted.
    count : int
        Messages, wanted or not.
    published_otherwise : int
        How many of them were not published at their log time.
    """

    topic: str
    message_type: str
    encoding: str
    definition: tuple[str, bytes] = ("", b"")
    pieces: list[RawMessages] = field(default_factory=list)
    count: int = 0
    published_otherwise: int = 0

    def take(self) -> list[RawMessages]:
        """The messages not yet taken, which the track then forgets."""
        pieces, self.pieces = self.pieces, []
        return pieces


@dataclass(frozen=True)
class FileSpan:
    """How many messages a file holds, and from when to when they were logged, ns."""

    name: str
    count: int
    first_ns: int
    last_ns: int

    __repr__ = short_repr


@dataclass(frozen=True)
class Outline:
    """Where the messages of a file are, that was found whole.

    Parameters
    ----------
    path : Path
    state : tuple of int
        Which file it was, and what it would not be any more if it changed.
    chunks : array of int
        The bytes where the records of its chunks begin; empty if messages stand outside of chunks.
    channels : dict of (topic, message type) to list of int
    chunks_of : dict of (topic, message type) to array of int
        Those of the chunks that have messages of a topic.
    largest_chunk : int
        Inflated, bytes.
    """

    path: Path
    state: tuple[int, ...]
    chunks: array[int]
    channels: dict[tuple[str, str], list[int]]
    chunks_of: dict[tuple[str, str], array[int]]
    largest_chunk: int

    __repr__ = short_repr


@dataclass
class McapContents:
    """The messages and metadata of a file, or of several that continue each other.

    Attributes
    ----------
    library : str
        The software that wrote the first file.
    tracks : dict of (topic, message type) to RawTrack
    metadata : dict of str to dict
        Metadata records by name.
    attachments : int
    files : list of FileSpan
    outlines : list of Outline
    without_checksum : int
        Chunks, or files without chunks, whose bytes stand under no checksum.
    kept, most_kept : int
        About the bytes that the messages not yet taken need, and how many they may: each file allows for its own.
    """

    library: str = ""
    tracks: dict[tuple[str, str], RawTrack] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: int = 0
    files: list[FileSpan] = field(default_factory=list)
    outlines: list[Outline] = field(default_factory=list)
    without_checksum: int = 0
    kept: int = 0
    most_kept: int = 0

    __repr__ = short_repr

    @property
    def message_count(self) -> int:
        """Messages on all topics."""
        return sum(track.count for track in self.tracks.values())

    def allow(self, size: int) -> None:
        """Allow for the messages of a file of so many bytes."""
        self.most_kept += max(_KEPT_AT_LEAST, _KEPT_PER_BYTE * size)

    def keep(self, size: int, messages: int) -> bool:
        """Count so many bytes of messages as kept; whether that is more than allowed."""
        self.kept += size + messages * _PER_MESSAGE
        return self.kept > self.most_kept


def of_types(types: Container[str]) -> Wanted:
    """Want the messages of some types, whatever their topics."""
    return lambda topic, message_type: message_type in types


def nothing(topic: str, message_type: str) -> bool:
    """Want no messages: they are counted."""
    return False


def state_of(stream: BinaryIO) -> tuple[int, ...]:
    """Which file an open one is, and what changes when it is written to."""
    status = os.fstat(stream.fileno())
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


def opened(path: Path) -> BinaryIO:
    """A bag's file, open to be read.

    Raises
    ------
    BagError
        If it cannot be.
    """
    try:
        return open_file(path)
    except InputError as error:
        raise BagError(str(error)) from None
    except FileNotFoundError:
        raise BagError(f"{path} does not exist: give the path of an MCAP file") from None
    except (OSError, ValueError) as error:
        raise BagError(f"{path} cannot be read: {reason(error)}: give another file") from None
