"""Contents of a bag, in one file or several: topics with their messages counted, and where these are in the files."""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Integers, windows
from lie_rigid_body.wording import short_repr

TrackKey: TypeAlias = tuple[str, str]
"""Topic and message type."""
Wanted: TypeAlias = Callable[[str, str], bool]
"""Whether the messages of a topic, by its name and message type, are read."""
Progress: TypeAlias = Callable[[int], object]
"""Takes notice of how many bytes more were read."""

_PER_MESSAGE: Final = 100
"""Memory that a message takes beside its content, about, bytes."""


@dataclass(frozen=True)
class RawMessages:
    """Messages of one track, undecoded, in file order.

    Parameters
    ----------
    data : memoryview
        Their payloads, one after the other.
    sizes : ndarray of int64, shape (N,)
        Bytes of each.
    log_times_ns : ndarray of int64, shape (N,)
    """

    data: memoryview
    sizes: Integers
    log_times_ns: Integers

    @classmethod
    def of(cls, data: bytes, starts: Integers, ends: Integers, log_times_ns: Integers) -> RawMessages:
        """Messages whose payloads stand between places of some data."""
        sizes = ends - starts
        if len(sizes) and (sizes == sizes[0]).all():
            return cls(windows(data, int(sizes[0]))[starts].reshape(-1).data, sizes, log_times_ns)
        view = memoryview(data)
        parts = [view[start:end] for start, end in zip(starts.tolist(), ends.tolist(), strict=True)]
        return cls(memoryview(b"".join(parts)), sizes, log_times_ns)

    @classmethod
    def of_payloads(cls, found: Sequence[tuple[int, bytes]]) -> RawMessages:
        """Messages of log times, ns, and payloads."""
        times, sizes = np.array([(time, len(data)) for time, data in found], dtype=np.int64).reshape(-1, 2).T
        return cls(memoryview(b"".join(data for _, data in found)), sizes, times)

    @classmethod
    def joined(cls, parts: Sequence[RawMessages]) -> RawMessages:
        """Messages that follow each other as one."""
        if len(parts) == 1:
            return parts[0]
        none = np.empty(0, dtype=np.int64)
        sizes, times = ([none, *(getattr(part, name) for part in parts)] for name in ("sizes", "log_times_ns"))
        return cls(memoryview(b"".join(part.data for part in parts)), np.concatenate(sizes), np.concatenate(times))

    def __len__(self) -> int:
        return len(self.sizes)

    def pieces(self, count: int) -> Iterator[RawMessages]:
        """Cut into pieces of so many messages; at least one piece."""
        ends = np.append(0, np.cumsum(self.sizes))
        for begin in range(0, max(len(self), 1), count):
            rows = slice(begin, begin + count)
            data = self.data[ends[begin] : ends[min(begin + count, len(self))]]
            yield RawMessages(data, self.sizes[rows], self.log_times_ns[rows])

    def payloads(self) -> Iterator[tuple[int, bytes]]:
        """Log time, ns, and bytes of each message."""
        ends = np.cumsum(self.sizes)
        places = zip(self.log_times_ns.tolist(), (ends - self.sizes).tolist(), ends.tolist(), strict=True)
        return ((time, bytes(self.data[start:end])) for time, start, end in places)


Found: TypeAlias = dict[TrackKey, RawMessages]
"""Messages of the wanted tracks in a part of a file."""


@dataclass
class RawTrack:
    """Messages of one type on one topic, undecoded, in file order.

    Attributes
    ----------
    topic, message_type, encoding : str
    definition : tuple of (str, bytes)
        Encoding and text of its schema.
    pieces : list of RawMessages
        Those that were kept, and not yet taken.
    count : int
        Messages, kept or not.
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

    @property
    def key(self) -> TrackKey:
        """Topic and message type."""
        return self.topic, self.message_type

    def take(self) -> RawMessages:
        """Messages not yet taken, which the track then forgets."""
        pieces, self.pieces = self.pieces, []
        return RawMessages.joined(pieces)


@dataclass(frozen=True)
class FileSpan:
    """Number of messages in a file, and from when to when they were logged, ns."""

    name: str
    count: int
    first_ns: int
    last_ns: int

    __repr__ = short_repr


class Outline(Protocol):
    """Places of the messages in a file that was found whole."""

    def read(self, keys: Collection[TrackKey], progress: Progress) -> Iterator[Found]:
        """Read the messages of some tracks, part by part.

        Parameters
        ----------
        keys : collection of TrackKey
        progress : callable
            Called with the number of bytes that were read since it was called last.

        Raises
        ------
        BagError
            If the file is not what it was when it was outlined.
        """


@dataclass
class McapContents:
    """Messages and metadata of a file, or of several that continue each other.

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
    """

    library: str = ""
    tracks: dict[TrackKey, RawTrack] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: int = 0
    files: list[FileSpan] = field(default_factory=list)
    outlines: list[Outline] = field(default_factory=list)
    without_checksum: int = 0

    __repr__ = short_repr

    @property
    def message_count(self) -> int:
        """Messages on all topics."""
        return sum(track.count for track in self.tracks.values())

    def keep(self, found: Found) -> int:
        """Keep messages in their tracks; return about how many bytes of memory they take."""
        for key, messages in found.items():
            self.tracks[key].pieces.append(messages)
        return sum(len(messages.data) + len(messages) * _PER_MESSAGE for messages in found.values())

    def read(self, keys: Collection[TrackKey], progress: Progress) -> Iterator[Found]:
        """Read the messages of some tracks again, part by part; see `Outline.read`."""
        for outline in self.outlines:
            yield from outline.read(keys, progress)


def of_types(types: Container[str]) -> Wanted:
    """Want the messages of some types, whatever their topics."""
    return lambda topic, message_type: message_type in types


def nothing(topic: str, message_type: str) -> bool:
    """Want no messages: they are counted."""
    return False
