"""The messages of a bag that was found whole, read again: no checksum and no index is compared twice."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk

from lie_rigid_body.arrays import Booleans
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.decoding import byte_order
from lie_rigid_body.messages.layout import FRAME, numbers_after
from lie_rigid_body.recording.bag_files import BagFiles, Progress, unheard
from lie_rigid_body.recording.inflation import inflated_unverified
from lie_rigid_body.recording.inventory import MessageTable
from lie_rigid_body.recording.mcap_contents import McapContents, Outline, RawMessages
from lie_rigid_body.recording.mcap_reader import opened, state_of
from lie_rigid_body.recording.message_loops import FIND, TAKE, are_compiled, expect
from lie_rigid_body.recording.message_scan import FoundMessages, Layout
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.recording.track_decoding import Kind, TopicMessages, topic_messages

_RECORD: Final = struct.Struct("<BQ")
_PAYLOAD: Final = 31
"""Byte of a message record where its payload begins."""


class TopicReader:
    """The messages of a topic, chunk by chunk.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    key : tuple of (str, str)
        Topic and message type.
    varying : ndarray of bool, shape (numbers,)
        Which of the float64 fields of a message are its values; the others are part of its kind.
    stamped : bool
        Whether a std_msgs/Header comes first.
    """

    def __init__(self, path: Path, key: tuple[str, str], varying: Booleans, stamped: bool) -> None:
        self.key = key
        self._path, self._varying, self._stamped = path, varying, stamped
        self._layout: Layout | None = None
        self._kind_of_layout: Kind = ("", b"")
        self._before = 0
        self._begin(0)

    def _begin(self, rows: int) -> None:
        """Begin with none, and place for so many."""
        self.count, self._kinds = 0, dict[Kind, int]()
        self._log_times, self._stamps, self._kind = (np.empty(rows, dtype=np.int64) for _ in range(3))
        self._values = np.empty((rows, np.count_nonzero(self._varying)))

    def add(self, data: bytes, channels: Sequence[int]) -> None:
        """Take the messages of channels in a chunk."""
        if not channels:
            return
        if len(channels) == 1 and self._layout is not None:
            self._make_room(self._layout.most_in(data))
            rest = slice(self.count, None)
            arrays = self._log_times[rest], self._stamps[rest], self._values[rest]
            taken = self._layout.take(data, channels[0], *arrays)
            if taken is not None:
                if taken:
                    self._kind[self.count : self.count + taken] = self._number_of(self._kind_of_layout)
                self.count += taken
                return
        self._add_one_by_one(data, channels)

    def _number_of(self, kind: Kind) -> int:
        return self._kinds.setdefault(kind, len(self._kinds))

    def _make_room(self, rows: int) -> None:
        if self.count + rows > len(self._stamps):
            size = max(2 * len(self._stamps), self.count + rows)
            for name in ("_log_times", "_stamps", "_values", "_kind"):
                old = getattr(self, name)[: self.count]
                new = np.empty((size, *old.shape[1:]), dtype=old.dtype)
                new[: len(old)] = old
                setattr(self, name, new)

    def _add_one_by_one(self, data: bytes, channels: Sequence[int]) -> None:
        """In the general way, from which the layout of those that follow is learned."""
        piece = _piece(data, channels)
        first = self._before + self.count
        found = topic_messages(self._path, self.key[0], [piece], self._varying, self._stamped, first)
        if len(found) and len(found.kinds) == 1:
            self._learn(piece.data[piece.starts[0] : piece.ends[0]], found.kinds[0])
        self._make_room(len(found))
        rows = slice(self.count, self.count + len(found))
        self._log_times[rows], self._stamps[rows], self._values[rows] = (
            found.log_times_ns,
            found.stamps_ns,
            found.values,
        )
        self._kind[rows] = np.array([self._number_of(kind) for kind in found.kinds], dtype=np.int64)[found.kind]
        self.count = rows.stop

    def taken(self) -> TopicMessages:
        """The messages that were added, with which it begins anew."""
        rows = slice(0, self.count)
        columns = self._log_times[rows], self._stamps[rows], self._values[rows]
        found = TopicMessages(*columns, tuple(self._kinds), self._kind[rows])
        self._before += self.count
        self._begin(len(self._stamps))
        return found

    def _learn(self, payload: bytes, kind: Kind) -> None:
        take = TAKE.compiled_for(0)
        if take is None or byte_order(payload, 0) != "<":
            return
        frame_end = FRAME + int.from_bytes(payload[12:FRAME], "little") if self._stamped else 0
        start = numbers_after(frame_end) if self._stamped else 4
        self._layout = Layout(take, payload, start, frame_end, self._varying)
        self._kind_of_layout = kind


def may_read_again(outlines: Sequence[Outline], count: int) -> bool:
    """Whether the files can be read again so: in chunks, by loops that are compiled for so many messages."""
    if not _in_chunks(outlines):
        return False
    expect(count)
    return are_compiled()


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
                    content = stream.read(length)
                    progress(stream.tell() - before)
                    before = stream.tell()
                    data = inflated_unverified(Chunk.read(ReadDataStream(BytesIO(content))))
                    yield outline, data
                _require_same(outline, stream)
            except BagError:
                raise
            except OSError as error:
                raise BagError(f"{outline.path} cannot be read: {reason(error)}: copy it to a better place") from None
            except Exception as error:  # the libraries' parsers fail in many ways on changed bytes
                raise _changed(outline) from error


def _require_same(outline: Outline, stream: BinaryIO) -> None:
    if state_of(stream) != outline.state:
        raise _changed(outline)


def _changed(outline: Outline) -> BagError:
    return BagError(f"{outline.path} changed while it was read: try again when nobody writes it")


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
