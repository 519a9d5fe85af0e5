"""Reading an MCAP file: every record framed, every checksum compared, nothing guessed.

The `mcap` library's own reader takes the end of a file for the end of a record; a cut would go unnoticed there.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk, Footer, Header, Metadata, Schema

from lie_rigid_body.foundation.arrays import items
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.recording.inflation import inflated, most_records, other_format
from lie_rigid_body.recording.mcap_contents import (
    FileSpan,
    Found,
    McapContents,
    Parts,
    Progress,
    RawMessages,
    RawTrack,
    TrackKey,
)
from lie_rigid_body.recording.records import (
    CHANGED,
    HEAD,
    LARGEST_RECORD,
    MAGIC,
    NO_HINTS,
    RECORD_HEAD,
    RESCUE,
    ContradictionError,
    ExcessError,
    FileBytes,
    MessageTable,
    Place,
    Rows,
    find_messages,
    parsed,
    records,
    require,
)
from lie_rigid_body.recording.sound_records import DAMAGE
from lie_rigid_body.recording.summary import Summary, SummaryCheck
from lie_rigid_body.system.bounded_input import LARGEST_CHUNK

_TOGETHER: Final[Mapping[tuple[int, int], int]] = {
    (Opcode.CHUNK, Opcode.MESSAGE_INDEX): 2 * LARGEST_RECORD,
    (Opcode.MESSAGE, Opcode.MESSAGE): 2**20,
}
"""Reach in bytes, by kinds of records: records of these kinds within it are read together with the first."""
_WITH_MESSAGES: Final = (Opcode.CHUNK, Opcode.MESSAGE)
_CHECKSUMS: Final[Mapping[int, tuple[int, int, str]]] = {
    Opcode.DATA_END: (0, RECORD_HEAD.size, "data section"),
    Opcode.FOOTER: (RECORD_HEAD.size + 16, RECORD_HEAD.size + 16, "summary"),
}
"""Records with a checksum: the number of their own bytes under it, its place, and what it covers."""
_FOOTER: Final = struct.Struct("<QQI")
"""Content of the footer. It has no bytes behind: a reader that seeks finds it at this distance from the end."""
_INDEX_HEAD: Final = struct.Struct("<HI")
"""Channel of a message index, and bytes of its rows."""
_NO_ROWS: Final = np.empty((0, 2), dtype="<u8")
_NO_SCHEMA: Final = Schema(data=b"", encoding="", id=0, name="")
_Place: TypeAlias = tuple[int, int, dict[TrackKey, list[int]]]
"""Bytes where a part with messages begins and ends, and the channels in it by their tracks."""
_PROFILES: Final = ("ros2", "")


def read_file(path: Path, contents: McapContents) -> Parts:
    """Read a file, and count its messages.

    Parameters
    ----------
    path : Path
    contents : McapContents
        What it holds is added there.

    Yields
    ------
    size : int
        Bytes that were read.
    found : Found
        Those messages in them that are wanted.

    Raises
    ------
    BagError
        If the file cannot be read, is no MCAP file, is cut off or damaged.
    """
    with closing(FileBytes(path)) as file:
        reader = _FileReader(file, contents)
        try:
            yield from reader.read()
        except (BagError, ModuleNotFoundError):
            raise
        except Exception as error:  # the library's parsers fail in many ways on damaged bytes
            raise BagError(f"{path} {_told(error, reader.at)}") from None


def _read_again(
    path: Path, state: tuple[int, ...], places: Iterable[_Place], keys: Collection[TrackKey], progress: Progress
) -> Iterator[Found]:
    """Messages of some tracks in a file that was read before, and was in some state then; see `McapContents.read`."""
    with closing(FileBytes(path)) as file:
        try:
            require(file.state() == state, "it is another file")
            for begin, end, there in places:
                channels = {key: own for key, own in there.items() if key in keys}
                yield _found_again(file[begin:end], channels) if channels else {}
                progress(end - begin)
            require(file.state() == state, "it is another file")
        except BagError:
            raise
        except Exception as error:  # the libraries' parsers fail in many ways on changed bytes
            raise BagError(f"{path} {CHANGED}") from error


def _found_again(raw: bytes, channels: Mapping[TrackKey, Sequence[int]]) -> Found:
    """Messages of some tracks in a part whose checksum and indexes were compared when it was read first."""
    chunk, places = _chunk_of(raw)
    data = inflated(replace(chunk, uncompressed_crc=0)) if chunk else raw
    index = dict(_index(raw, place) for place in places)
    return _by_track(data, index or find_messages(data, NO_HINTS, LARGEST_CHUNK).index, channels)


def _told(error: Exception, at: int) -> str:
    """Words for an error. No variable of a frame that it keeps may keep it, as both would stay, with all their data."""
    if isinstance(error, ContradictionError):
        return error.sentence.format(at=at, what=error)
    words = f"{type(error).__name__}: {error}".removesuffix(": ")
    what = "a record that is none of its kind" if isinstance(error, DAMAGE) else words
    return ContradictionError.sentence.format(at=at, what=what)


def _chunk_of(raw: bytes) -> tuple[Chunk | None, list[Place]]:
    """Chunk, if it is one, and places of the indexes behind it, of a part of a file.

    Parameters
    ----------
    raw : bytes
        A chunk with the indexes behind it, or messages that stand in no chunk.
    """
    if raw[0] != Opcode.CHUNK:
        return None, []
    first, *indexes = records(raw)
    return parsed(Opcode.CHUNK, raw[first.begin : first.end]), indexes


def _index(raw: bytes, place: Place) -> tuple[int, Rows]:
    """Channel of a message index in some bytes, and its rows in the order of the messages."""
    channel, size = _INDEX_HEAD.unpack(raw[place.begin : min(place.begin + _INDEX_HEAD.size, place.end)])
    begin = place.begin + _INDEX_HEAD.size
    require(begin + size <= place.end, f"the index of channel {channel} is longer than its record")
    return channel, _in_order(np.frombuffer(raw[begin : begin + size], "<u8").reshape(-1, 2))


def _in_order(rows: Rows) -> Rows:
    """Rows of an index in the order of their messages, in which recorders write them."""
    starts = rows[:, 1]
    return rows if (starts[1:] >= starts[:-1]).all() else rows[np.argsort(starts, kind="stable")]


class _FileReader:
    """One file, read from its start to its end.

    Attributes
    ----------
    at : int
        Byte where the record begins that is looked at.
    """

    def __init__(self, file: FileBytes, contents: McapContents) -> None:
        self._file, self._contents, self._state = file, contents, file.state()
        self._records_left = most_records(len(self._file))
        self._tracks: dict[int, RawTrack] = {}
        self._places: list[_Place] = []
        self._summary = Summary()
        self._check = SummaryCheck(self._summary)
        self._crc = zlib.crc32(MAGIC)  # of the data section, then of the summary
        self._bare_chunks = 0
        self.at, self._end = 0, len(MAGIC)

    def read(self) -> Parts:
        """Read all records; see `read_file`."""
        self._require_magic()
        opcode = 0
        for opcode, begin, end in self._parts():
            found = self._take(opcode, begin, self._file[begin:end])
            if opcode in _WITH_MESSAGES:
                yield end - begin, found
        if opcode != Opcode.FOOTER or self._file[self._end : self._end + len(MAGIC) + 1] != MAGIC:
            raise self._cut_off()

    def _require_magic(self) -> None:
        start, path = self._file[:16], self._file.path
        if not start:
            raise BagError(f"{path} is empty: record it again, it holds nothing to rescue")
        if not start.startswith(MAGIC):
            hint = other_format(start) or "it does not begin as one: give a bag"
            raise BagError(f"{path} is not an MCAP file: {hint}")

    def _parts(self) -> Iterator[tuple[int, int, int]]:
        """Opcode of the first record of each part, and where the part begins and ends.

        A part is a chunk with the indexes behind it, or messages that stand in no chunk, or one other record.
        """
        part: list[Place] = []
        for place in records(self._file, len(MAGIC)):
            self.at, self._end = place.start, place.end
            if place.end - place.begin > LARGEST_RECORD:
                raise ExcessError(f"a record of {place.end - place.begin} bytes")
            if part and place.end - part[0].start > _TOGETHER.get((part[0].opcode, place.opcode), 0):
                yield part[0].opcode, part[0].start, part[-1].end
                part = []
            part.append(place)
            if place.opcode == Opcode.FOOTER:
                break
        if part:
            # behind a chunk that comes last in a file without a footer, indexes are cut off
            last = part[0] if part[0].opcode == Opcode.CHUNK else part[-1]
            yield part[0].opcode, part[0].start, last.end

    def _take(self, opcode: int, begin: int, raw: bytes) -> Found:
        """Take a part; return the messages of it that are wanted. Records of unknown kinds are left to others."""
        self.at = begin
        self._verify_section(opcode, raw)
        record = None if opcode in _WITH_MESSAGES else parsed(opcode, raw[RECORD_HEAD.size :])
        self._check.place(opcode, begin, begin + len(raw), record)
        if opcode in _WITH_MESSAGES:
            return self._take_messages(begin, raw)
        self._summary.add(record, begin, len(raw))
        match record:
            case Header():
                require(
                    record.profile in _PROFILES,
                    f"its profile is {record.profile!r:.40}, that of a bag of ROS 2 is 'ros2'",
                )
                self._contents.library = self._contents.library or record.library
            case Metadata():
                self._contents.metadata[record.name] = record.metadata
            case Footer():
                size = len(raw) - RECORD_HEAD.size
                require(size == _FOOTER.size, f"its footer has {size} bytes, not {_FOOTER.size}")
                mixed = len(self._contents.are_indexed) > 1
                require(not mixed, "some chunks have indexes of their messages, and some have none")
                self._check.finish(record)
                self._finish()
        return {}

    def _verify_section(self, opcode: int, raw: bytes) -> None:
        """Compare the checksum of the section that ends here, if one does."""
        if opcode not in _CHECKSUMS:
            self._crc = zlib.crc32(raw, self._crc)
            return
        own, at, what = _CHECKSUMS[opcode]
        found, declared = zlib.crc32(raw[:own], self._crc), int.from_bytes(raw[at : at + 4], "little")
        require(declared in (0, found), f"the checksum of its {what} is {found:08x}, not {declared:08x}")
        self._crc = 0
        if opcode == Opcode.DATA_END and not declared:
            self._contents.without_checksum += self._bare_chunks or not self._summary.chunks

    def _finish(self) -> None:
        """Add the contents of the whole file to those of the bag."""
        found, contents = self._summary, self._contents
        for channel in found.channels:
            self._track(channel).count += found.counts[channel]
        contents.attachments += len(found.attachments)
        contents.files.append(FileSpan(self._file.path.name, found.counts.total(), found.first_ns, found.last_ns))
        contents.again.append(partial(_read_again, self._file.path, self._state, self._places))

    def _track(self, number: int) -> RawTrack:
        """Track of a channel."""
        if number not in self._tracks:
            channel = self._summary.channels[number]
            schema = self._summary.schemas.get(channel.schema_id, _NO_SCHEMA)
            own = RawTrack(channel.topic, schema.name, channel.message_encoding, (schema.encoding, schema.data))
            track = self._tracks[number] = self._contents.tracks.setdefault(own.key, own)
            require(
                (track.encoding, track.definition) == (own.encoding, own.definition),
                f"topic {channel.topic} has messages of two encodings or definitions",
            )
        return self._tracks[number]

    def _take_messages(self, begin: int, raw: bytes) -> Found:
        """Take messages in a chunk or in none; return those that are wanted."""
        chunk, places = _chunk_of(raw)
        data = inflated(chunk) if chunk else raw
        indexes = dict[int, tuple[int, Rows]]()
        for place in places:
            self.at = begin + place.start
            channel, rows = _index(raw, place)
            require(channel not in indexes, f"a chunk has two indexes of channel {channel}")
            indexes[channel] = self.at, rows
        self.at = begin
        hints = (rows[:, 1].view(np.int64) for _, rows in indexes.values())
        most = self._records_left if chunk is not None else len(raw)
        table = find_messages(data, np.concatenate([NO_HINTS, *hints]), most)
        require(
            len(table.data) == len(data), f"no record that ends in its chunk stands at byte {len(table.data)} of it"
        )
        self._summary.add_messages(table)
        if chunk is not None:
            self._hold_chunk(chunk, table, indexes)
            starts = {channel: start for channel, (start, _) in indexes.items()}
            self._summary.add_chunk(chunk, begin, starts, begin + len(raw))
        return self._wanted_of(table, begin, begin + len(raw))

    def _hold_chunk(self, chunk: Chunk, table: MessageTable, indexes: Mapping[int, tuple[int, Rows]]) -> None:
        """Hold what a chunk and its indexes say against its messages."""
        said, begin = (chunk.message_start_time, chunk.message_end_time), self.at
        require(said == table.span_ns or not table.index, f"the times of a chunk are {table.span_ns}, not {said}")
        self._records_left -= len(table.starts) + len(table.others)
        self._bare_chunks += not chunk.uncompressed_crc
        for channel, (self.at, rows) in indexes.items():
            require(
                np.array_equal(rows, table.index.get(channel, _NO_ROWS)),
                f"the index of channel {channel} is not that of its chunk's messages",
            )
        self.at = begin
        missing = table.index.keys() - indexes.keys()
        require(not (indexes and missing), f"a chunk has no index of channel {min(missing, default=0)}")
        self._contents.are_indexed.update({bool(indexes)} if table.index else ())

    def _wanted_of(self, table: MessageTable, begin: int, end: int) -> Found:
        """Messages that are wanted of a part that stands between two bytes, which is noted."""
        otherwise = table.heads["channel"][table.heads["log_time"] != table.heads["publish_time"]]
        channels: dict[TrackKey, list[int]] = {}
        for channel in table.index:
            track = self._track(channel)
            track.published_otherwise += int(np.count_nonzero(otherwise == channel))
            channels.setdefault(track.key, []).append(channel)
        self._places.append((begin, end, channels))
        wanted = {key: own for key, own in channels.items() if self._contents.wanted(*key)}
        return _by_track(table.data, table.index, wanted)

    def _cut_off(self) -> BagError:
        self.at, path = self._end, self._file.path
        is_record = len(self._file) - self._end >= RECORD_HEAD.size and self._file[self._end : self._end + 1] != b"\0"
        require(not (is_record and self._file[-len(MAGIC) :] == MAGIC), "a record is longer than the file")
        count = self._summary.counts.total()
        holds = f"holds at least {counted(count, 'whole message')}" if count else "may hold whole messages"
        return BagError(f"{path} was cut off, or is still being written: it {holds}: rescue them with {RESCUE}")


def _by_track(data: bytes, index: Mapping[int, Rows], channels: Mapping[TrackKey, Sequence[int]]) -> Found:
    """Messages of some tracks, each of which has several channels where there were several publishers or recorders."""
    found = Found()
    for key, own in channels.items():
        several = [index.get(channel, _NO_ROWS) for channel in own]
        rows = several[0] if len(several) == 1 else _in_order(np.concatenate(several))
        times, starts = np.ascontiguousarray(rows.T).view(np.int64)
        lengths = items(data, starts + 1, 8).view("<i8")
        found[key] = RawMessages.of(data, starts + HEAD.itemsize, starts + RECORD_HEAD.size + lengths, times)
    return found
