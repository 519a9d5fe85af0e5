"""The messages of a bag that was found whole, read again: no checksum and no index is compared twice."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeVar

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.decoding import byte_order
from lie_rigid_body.messages.layout import FRAME, numbers_after
from lie_rigid_body.recording.bag_files import BagFiles, Progress, unheard
from lie_rigid_body.recording.inflation import inflated_unverified
from lie_rigid_body.recording.mcap_contents import McapContents, Outline, RawMessages, opened, state_of
from lie_rigid_body.recording.message_loops import FIND, HEAD, TAKE, are_compiled, expect
from lie_rigid_body.recording.message_scan import FoundMessages, Layout
from lie_rigid_body.recording.message_table import MessageTable
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.recording.track_decoding import Kind, TopicMessages, topic_messages

_RECORD: Final = struct.Struct("<BQ")
T = TypeVar("T")
_LARGEST_CHUNK_AHEAD: Final = 8 * 2**20
"""Bytes of a chunk, inflated, up to which what is in it is decoded ahead. Recorders make them of some MB at most."""
_PART: Final = 2**20
"""Bytes of a chunk, inflated, whose messages are taken at once: places for as many as it might have come first."""
_PAYLOAD: Final = 31
"""Byte of a message record where its payload begins."""


@dataclass
class Topic:
    """A topic whose messages are read.

    Parameters
    ----------
    key : tuple of (str, str)
        Topic and message type.
    varying : ndarray of bool, shape (numbers,)
        Which of the float64 fields of a message are its values; the others are part of its kind.
    stamped : bool
        Whether a std_msgs/Header comes first.
    expected : int
        How many messages there will be to take at once, if that is known: room for them is made at first.
    layout : Layout or None
        How its messages are laid out, as soon as one was read.
    kind_of_layout : Kind
        Of messages that are laid out so.
    kinds : dict of Kind to int
        Those of the messages not yet taken, numbered.
    before : int
        Messages that were taken.
    """

    key: tuple[str, str]
    varying: Booleans
    stamped: bool
    expected: int = 0
    layout: Layout | None = None
    kind_of_layout: Kind = ("", b"")
    kinds: dict[Kind, int] = field(default_factory=dict)
    before: int = 0

    def number_of(self, kind: Kind) -> int:
        """The number of a kind, which is new if there was none like it."""
        return self.kinds.setdefault(kind, len(self.kinds))

    def decoded(self, path: Path, piece: RawMessages, before: int) -> TopicMessages:
        """Messages decoded in the general way, before which so many were added since the last were taken."""
        return topic_messages(path, self.key[0], [piece], self.varying, self.stamped, self.before + before)

    def learn(self, payload: bytes, kind: Kind) -> None:
        """Take a message for how all are laid out."""
        if byte_order(payload, 0) != "<":
            return
        frame_end = FRAME + int.from_bytes(payload[12:FRAME], "little") if self.stamped else 0
        start = numbers_after(frame_end) if self.stamped else 4
        self.layout, self.kind_of_layout = Layout(payload, start, frame_end, self.varying), kind


class TopicsReader:
    """The messages of some topics, chunk by chunk.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    topics : sequence of Topic
    """

    def __init__(self, path: Path, topics: Sequence[Topic]) -> None:
        self._path, self._topics = path, topics
        self._widths = np.array([np.count_nonzero(topic.varying) for topic in topics], dtype=np.int64)
        self._expected = np.array([topic.expected for topic in topics], dtype=np.int64)
        self._begin(np.zeros(len(topics), dtype=np.int64))

    def _begin(self, rows: Integers) -> None:
        """Begin with no message, and place for so many of each topic."""
        self._rows = rows
        self._taken = np.zeros((len(self._topics), 2), dtype=np.int64)
        self._times_at, self._words_at = (np.append(0, np.cumsum(sizes)) for sizes in (rows, rows * self._widths))
        self._log_times, self._stamps, self._kind = (np.empty(self._times_at[-1], dtype=np.int64) for _ in range(3))
        self._words = np.empty(self._words_at[-1], dtype=np.int64)
        self._channels: Mapping[tuple[str, str], Sequence[int]] | None = None

    @property
    def count(self) -> int:
        """Messages that were added since the last were taken."""
        return int(self._taken[:, 0].sum())

    def _values(self, i: int) -> Array:
        """Place for the values of a topic, shape (rows, width)."""
        words = self._words[self._words_at[i] : self._words_at[i + 1]]
        return words.view(np.float64).reshape(-1, self._widths[i])

    def add(self, data: bytes, channels: Mapping[tuple[str, str], Sequence[int]]) -> None:
        """Take the messages in a chunk of a file, in which topics have these channels."""
        before = self._taken[:, 0].tolist()
        is_learned = TAKE.compiled_for(0) is not None and self._learn(data, channels)
        if is_learned or channels is not self._channels:
            self._lay_out(channels)
        if self._take is not None:
            self._make_room(self._taken[:, 0] + self._is_laid_out * (len(data) // self._sizes + 1))
            self._taken[:, 1] = self._is_laid_out
            arrays = self._layouts, self._alike, self._places, self._taken, self._log_times, self._stamps, self._words
            self._take(np.frombuffer(data, dtype=np.uint8), *arrays)
        # of a topic that is laid out otherwise nothing counts that the loop took
        for i, (topic, (count, sound)) in enumerate(zip(self._topics, self._taken.tolist(), strict=True)):
            if not sound:
                self._taken[i, 0] = before[i]
                self._add_one_by_one(i, data, channels.get(topic.key, ()))
            elif count > before[i]:
                self._kind[self._places_of(i, before[i], count - before[i])] = topic.number_of(topic.kind_of_layout)

    def _learn(self, data: bytes, channels: Mapping[tuple[str, str], Sequence[int]]) -> bool:
        """Learn the layouts that are not known from the first messages in a chunk; return whether there was one."""
        unknown = [(i, topic) for i, topic in enumerate(self._topics) if topic.layout is None]
        is_learned = False
        for table in _tables(data) if unknown else ():
            for i, topic in [*unknown]:
                own = np.flatnonzero(np.isin(table.channels, channels.get(topic.key, ())))
                if not len(own):
                    continue
                unknown.remove((i, topic))
                payload = data[table.starts[own[0]] + _PAYLOAD : table.ends[own[0]]]
                with suppress(BagError):  # it is told in the general way
                    first = topic.decoded(self._path, _alone(payload), int(self._taken[i, 0]))
                    topic.learn(payload, first.kinds[0])
                    is_learned = True
        return is_learned

    def _lay_out(self, channels: Mapping[tuple[str, str], Sequence[int]]) -> None:
        """Have those topics taken by the compiled loop whose layout is known."""
        self._channels = channels
        self._take: Any = TAKE.compiled_for(0)
        own = [(topic.layout, channels.get(topic.key, ())) for topic in self._topics]
        known = [layout if self._take is not None and len(numbers) == 1 else None for layout, numbers in own]
        self._is_laid_out = np.array([layout is not None for layout in known])
        alike, places = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
        table = []
        for i, layout in enumerate(known):
            if layout is None:
                table.append([-1, *[0] * 8])
                continue
            begins = sum(map(len, alike)), sum(map(len, places))
            alike.append(layout.alike)
            places.append(layout.places)
            spans = begins[0], begins[0] + len(layout.alike), begins[1], begins[1] + len(layout.places)
            table.append(
                [own[i][1][0], layout.size, layout.stamped, *spans, int(self._times_at[i]), int(self._words_at[i])]
            )
        self._layouts = np.array(table, dtype=np.int64)
        self._alike, self._places = np.concatenate(alike), np.concatenate(places)
        self._sizes = np.array([HEAD + (0 if layout is None else layout.size) for layout in known])

    def _make_room(self, rows: Integers) -> None:
        if (rows <= self._rows).all():
            return
        old = [self._of_topic(i) for i in range(len(self._topics))]
        channels, taken = self._channels, self._taken
        self._begin(np.where(rows > self._rows, np.maximum(2 * self._rows, rows + self._expected), self._rows))
        self._taken = taken
        for i, columns in enumerate(old):
            self._fill(i, 0, *columns)
        if channels is not None:
            self._lay_out(channels)

    def _of_topic(self, i: int) -> tuple[Integers, Integers, Array, Integers]:
        """Log times, stamps, values and kinds of the messages of a topic."""
        rows = self._places_of(i, 0, int(self._taken[i, 0]))
        return self._log_times[rows], self._stamps[rows], self._values(i)[: self._taken[i, 0]], self._kind[rows]

    def _places_of(self, i: int, first: int, count: int) -> slice:
        begin = int(self._times_at[i]) + first
        return slice(begin, begin + count)

    def _fill(self, i: int, first: int, log_times: Integers, stamps: Integers, values: Array, kind: Integers) -> None:
        rows = self._places_of(i, first, len(stamps))
        self._log_times[rows], self._stamps[rows], self._kind[rows] = log_times, stamps, kind
        self._values(i)[first : first + len(stamps)] = values

    def _add_one_by_one(self, i: int, data: bytes, channels: Sequence[int]) -> None:
        """In the general way, from which the layout of those that follow is learned anew."""
        if not channels:
            return
        topic, first = self._topics[i], int(self._taken[i, 0])
        found = topic.decoded(self._path, _piece(data, channels), first)
        if len(found.kinds) == 1:
            topic.layout = None  # all of them are alike, but not like those before
        rows = self._taken[:, 0].copy()
        rows[i] += len(found)
        self._make_room(rows)
        numbers = np.array([topic.number_of(kind) for kind in found.kinds], dtype=np.int64)
        self._fill(i, first, found.log_times_ns, found.stamps_ns, found.values, numbers[found.kind])
        self._taken[i, 0] = rows[i]

    def taken(self) -> list[TopicMessages]:
        """The messages of each topic that were added, with which it begins anew."""
        found = []
        for i, topic in enumerate(self._topics):
            log_times, stamps, values, kind = self._of_topic(i)
            found.append(TopicMessages(log_times, stamps, values, tuple(topic.kinds), kind))
            topic.before, topic.kinds = topic.before + len(stamps), {}
        self._begin(self._rows)
        return found


def may_read_again(outlines: Sequence[Outline], count: int) -> bool:
    """Whether the files can be read again so: in chunks, by loops that are compiled for so many messages."""
    if not _in_chunks(outlines):
        return False
    expect(count)
    return are_compiled()


def one_ahead(items: Iterator[T], outlines: Sequence[Outline]) -> Iterator[T]:
    """The same items, which are made of the chunks of files; another thread makes the next while one is used.

    Not where a chunk is so large that two of them would take much memory.

    Parameters
    ----------
    items : iterator
        An error in making one is raised in its place.
    outlines : sequence of Outline
    """
    if any(outline.largest_chunk > _LARGEST_CHUNK_AHEAD for outline in outlines):
        yield from items
        return
    with ThreadPoolExecutor(1) as other:
        coming = other.submit(list[T], islice(items, 1))
        while item := coming.result():
            coming = other.submit(list[T], islice(items, 1))
            yield item.pop()


def _in_chunks(outlines: Sequence[Outline]) -> bool:
    return bool(outlines) and all(outline.chunks for outline in outlines)


def pieces_again(path: Path, outlines: Sequence[Outline], key: tuple[str, str]) -> Iterator[RawMessages]:
    """The messages of a topic of a bag that was found whole, piece by piece, from the chunks that have any.

    Parameters
    ----------
    path : Path
        Of the bag. Where its messages stand outside of chunks, it is read to its end.
    outlines : sequence of Outline
        Of its files.
    key : tuple of (str, str)
        Topic and message type.
    """
    if _in_chunks(outlines):
        own = [replace(each, chunks=each.chunks_of[key]) for each in outlines if key in each.chunks_of]
        for outline, data in chunks(own, unheard):
            yield _piece(data, outline.channels[key])
        return
    contents = McapContents()
    for _ in BagFiles(path).read(contents, lambda *given: given == key):
        yield from contents.tracks[key].take() if key in contents.tracks else ()
        contents.kept = 0
    yield from contents.tracks[key].take()


def chunks(outlines: Sequence[Outline], progress: Progress) -> Iterator[tuple[Outline, bytes]]:
    """The records of each chunk of the files, with the file that they are in.

    Raises
    ------
    BagError
        If a file is not what it was when it was outlined.
    """
    for outline in outlines:
        with opened(outline.path) as stream:
            try:
                _require_same(outline, stream)
                before = 0
                for place in outline.chunks:
                    stream.seek(place)
                    _, length = _RECORD.unpack(stream.read(_RECORD.size))
                    data = inflated_unverified(Chunk.read(ReadDataStream(BytesIO(stream.read(length)))))
                    progress(stream.tell() - before)
                    before = stream.tell()
                    yield outline, data
                _require_same(outline, stream)
            except BagError:
                raise
            except OSError as error:
                raise BagError(f"{outline.path} cannot be read: {reason(error)}: copy it to a better place") from None
            except Exception as error:  # the libraries' parsers fail in many ways on changed bytes
                raise _changed(outline) from error


def parts_of(data: bytes) -> Iterator[bytes]:
    """The records of a chunk, of a large one in parts."""
    begin = 0
    for table in _tables(data) if len(data) > 2 * _PART else ():
        while begin + _PART < table.ends.max(initial=0):
            end = int(table.ends[np.searchsorted(table.ends, begin + _PART)])
            yield data[begin:end]
            begin = end
    yield data[begin:] if begin else data


def _require_same(outline: Outline, stream: BinaryIO) -> None:
    if state_of(stream) != outline.state:
        raise _changed(outline)


def _changed(outline: Outline) -> BagError:
    return BagError(f"{outline.path} changed while it was read: try again when nobody writes it")


def _alone(payload: bytes) -> RawMessages:
    """A message by itself."""
    return RawMessages(payload, *(np.array([number], dtype=np.int64) for number in (0, len(payload), 0)))


def _piece(data: bytes, channels: Sequence[int]) -> RawMessages:
    """The messages of channels in a chunk."""
    starts, ends, log_times = ([np.empty(0, dtype=np.int64)] for _ in range(3))
    for table in _tables(data):
        own = np.isin(table.channels, list(channels))
        starts.append(table.starts[own] + _PAYLOAD)
        ends.append(table.ends[own])
        log_times.append(table.log_times[own])
    return RawMessages(data, np.concatenate(starts), np.concatenate(ends), np.concatenate(log_times))


def _tables(data: bytes) -> Iterator[MessageTable]:
    """The messages of a chunk, with the compiled loop or without."""
    find = FIND.compiled_for(0)
    found = None if find is None else FoundMessages(find, data)
    position, places = 0, array("q")
    while position < len(data):
        if found is not None and (table := found.at(position)) is not None:
            yield table
            position = int(table.ends[-1])
            continue
        opcode, length = _RECORD.unpack_from(data, position)
        end = position + _RECORD.size + length
        if opcode == Opcode.MESSAGE:
            places.extend((position, end))
        position = end
    bounds = np.array(places, dtype=np.int64).reshape(-1, 2)
    yield MessageTable.of(data, bounds[:, 0], bounds[:, 1])
