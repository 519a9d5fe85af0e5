"""Contents of a bag, in one file or several: topics with their messages counted, and where these are in the files."""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Integers, items
from lie_rigid_body.foundation.short_dataclass import short_dataclass

_NONE: Final = np.empty(0, dtype=np.int64)
TopicKey: TypeAlias = tuple[str, str]
"""Topic and message type."""
TopicNames: TypeAlias = Mapping[str, str]
"""Full names of topics by their relative names."""
TopicFilter: TypeAlias = Callable[[str, str], bool]
"""Whether the messages of a topic, by its name and message type, are kept when a bag is read first."""
Progress: TypeAlias = Callable[[int], object]
"""Takes notice of how many bytes more were read."""


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
        if len(sizes) and sizes[0] and (sizes == sizes[0]).all():
            return cls(items(data, starts, int(sizes[0])).view(np.uint8).data, sizes, log_times_ns)
        view = memoryview(data)
        parts = [view[start:end] for start, end in zip(starts.tolist(), ends.tolist(), strict=True)]
        return cls(memoryview(b"".join(parts)), sizes, log_times_ns)

    @classmethod
    def of_payloads(cls, found: Sequence[tuple[int, bytes]]) -> RawMessages:
        """Make messages of log times, ns, and payloads."""
        times, sizes = np.array([(time, len(data)) for time, data in found], dtype=np.int64).reshape(-1, 2).T
        return cls(memoryview(b"".join(data for _, data in found)), sizes, times)

    @classmethod
    def joined(cls, parts: Iterable[RawMessages]) -> RawMessages:
        """Messages that follow each other as one."""
        parts = list(parts)
        if len(parts) == 1:
            return parts[0]
        sizes = np.concatenate([_NONE, *(part.sizes for part in parts)])
        times = np.concatenate([_NONE, *(part.log_times_ns for part in parts)])
        return cls(memoryview(b"".join(part.data for part in parts)), sizes, times)

    def __len__(self) -> int:
        return len(self.sizes)

    def payloads(self) -> Iterator[tuple[int, bytes]]:
        """Log time, ns, and bytes of each message."""
        ends = np.cumsum(self.sizes)
        places = zip(self.log_times_ns.tolist(), (ends - self.sizes).tolist(), ends.tolist(), strict=True)
        return ((time, bytes(self.data[start:end])) for time, start, end in places)


ChunkMessages: TypeAlias = dict[TopicKey, RawMessages]
"""Messages in one part of a file, by topic and message type."""
Parts: TypeAlias = Iterator[tuple[int, ChunkMessages]]
"""Parts of a file in the order of reading: the size of each in bytes, and its messages."""


@dataclass
class RawTopic:
    """A topic with the messages of one type on it.

    Attributes
    ----------
    topic, message_type, encoding : str
    definition : tuple of (str, bytes)
        Encoding and text of its schema.
    count : int
        Messages.
    publish_time_mismatches : int
        How many of them were not published at their log time.
    """

    topic: str
    message_type: str
    encoding: str
    definition: tuple[str, bytes] = ("", b"")
    count: int = 0
    publish_time_mismatches: int = 0

    @property
    def key(self) -> TopicKey:
        """Topic and message type."""
        return self.topic, self.message_type


def of_types(types: Container[str]) -> TopicFilter:
    """Want the messages of some types, whatever their topics."""
    return lambda topic, message_type: message_type in types


nothing: Final = of_types(())
"""Want no messages: they are counted."""


def unheard(count: int) -> None:
    """Take no notice of progress."""


@short_dataclass(frozen=False)
class McapContents:
    """Messages and metadata of a file, or of several that continue each other.

    Attributes
    ----------
    wanted : callable
        Which messages are kept. See `TopicFilter`.
    kept : list of ChunkMessages
        Those messages, part by part.
    library : str
        The software that wrote the first file.
    tracks : dict of (topic, message type) to RawTopic
    metadata : dict of str to dict
        Metadata records by name.
    attachments : int
    again : list of callable
        For each file, which was found whole, a function that reads the messages of some tracks in it again.
    """

    wanted: TopicFilter = nothing
    kept: list[ChunkMessages] = field(default_factory=list)
    library: str = ""
    tracks: dict[TopicKey, RawTopic] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: int = 0
    again: list[Callable[[Collection[TopicKey], Progress], Iterator[ChunkMessages]]] = field(default_factory=list)

    def read(self, keys: Collection[TopicKey], progress: Progress = unheard) -> Iterator[ChunkMessages]:
        """Messages of some tracks, part by part, perhaps among others: those that were kept, or else read again.

        Parameters
        ----------
        keys : collection of TopicKey
        progress : callable, optional
            Called with the number of bytes of each part that is read again.

        Raises
        ------
        BagError
            If a file has changed since it was first read.
        """
        if all(self.wanted(*key) for key in keys):
            yield from self.kept
            return
        for read in self.again:
            yield from read(keys, progress)

    def messages(self, key: TopicKey) -> RawMessages:
        """All messages of a track."""
        return RawMessages.joined(found[key] for found in self.read([key]) if key in found)
