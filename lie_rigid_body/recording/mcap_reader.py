"""Reading an MCAP file: every record framed, every checksum compared, nothing guessed.

The `mcap` library's own reader takes the end of a file for the end of a record; a cut would go unnoticed there.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk, Footer, Header, McapRecord, Metadata, Schema

from lie_rigid_body.bounded_input import LARGEST_CHUNK
from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.inflation import ZSTD_MAGIC, inflated, inflated_unverified, most_records
from lie_rigid_body.recording.mcap_contents import (
    FileSpan,
    Found,
    McapContents,
    Progress,
    RawMessages,
    RawTrack,
    TrackKey,
    Wanted,
)
from lie_rigid_body.recording.message_table import HEAD, NO_HINTS, MessageTable, Rows, find_messages
from lie_rigid_body.recording.output_file import RESCUE
from lie_rigid_body.recording.records import (
    MAGIC,
    RECORD_HEAD,
    ContradictionError,
    ExcessError,
    FileBytes,
    Place,
    parsed,
    records,
    require,
)
from lie_rigid_body.recording.summary import Summary, SummaryCheck
from lie_rigid_body.wording import counted

LARGEST_RECORD: Final = LARGEST_CHUNK + 2**16
"""Largest size of a record, bytes."""
_TOGETHER: Final[Mapping[tuple[int, int], int]] = {
    (Opcode.CHUNK, Opcode.MESSAGE_INDEX): 2 * LARGEST_RECORD,
    (Opcode.MESSAGE, Opcode.MESSAGE): 2**20,
}
"""Bytes from a record on within which those of some kind that follow it are taken together with it."""
_CHECKSUMS: Final[Mapping[int, tuple[int, int, str]]] = {
    Opcode.DATA_END: (0, RECORD_HEAD.size, "data section"),
    Opcode.FOOTER: (RECORD_HEAD.size + 16, RECORD_HEAD.size + 16, "summary"),
}
"""Records with a checksum: how many of their own bytes are under it, where it stands, and of what it is."""
_INDEX_HEAD: Final = struct.Struct("<HI")
"""Channel of a message index, and bytes of its rows."""
_NO_ROWS: Final = np.empty((0, 2), dtype="<u8")
_NO_SCHEMA: Final = Schema(data=b"", encoding="", id=0, name="")
_PROFILES: Final = ("ros2", "")
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": "it is an SQLite bag: record with 'ros2 bag record -s mcap', or convert it",
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}


@dataclass(frozen=True)
class McapOutline:
    """Places of the messages in an MCAP file that was found whole.

    Parameters
    ----------
    path : Path
    state : tuple of int
        Which file it was, and what it would not be any more if it changed.
    parts : list of (int, int, tuple of TrackKey)
        Bytes where each part with messages begins and ends, and of which tracks they are.
    channels : dict of TrackKey to list of int
    """

    path: Path
    state: tuple[int, ...]
    parts: list[tuple[int, int, tuple[TrackKey, ...]]] = field(default_factory=list)
    channels: dict[TrackKey, list[int]] = field(default_factory=dict)

    def read(self, keys: Collection[TrackKey], progress: Progress) -> Iterator[Found]:
        """Read the messages of some tracks, part by part; see `Outline.read`."""
        with FileBytes(self.path) as file:
            try:
                require(file.state() == self.state, "it is another file")
                before = 0
                for begin, end, there in self.parts:
                    channels = {key: self.channels[key] for key in there if key in keys}
                    if channels:
                        *_, table = _messages_of(file[begin:end], LARGEST_CHUNK, inflated_unverified)
                        yield _by_track(table, channels)
                        progress(end - before)
                        before = end
                require(file.state() == self.state, "it is another file")
            except BagError:
                raise
            except Exception as error:  # the libraries' parsers fail in many ways on changed bytes
                what = f"{self.path} changed while it was read: try again when nobody writes it"
                raise BagError(what) from error


def read_file(path: Path, contents: McapContents, wanted: Wanted) -> Iterator[tuple[int, Found]]:
    """Read a file, and count its messages.

    Parameters
    ----------
    path : Path
    contents : McapContents
        What it holds is added there.
    wanted : callable
        Which messages are given out. See `Wanted`.

    Yields
    ------
    position : int
        Bytes that were read.
    found : Found
        Messages that are wanted of the last part.

    Raises
    ------
    BagError
        If the file cannot be read, is no MCAP file, is cut off or damaged.
    """
    with FileBytes(path) as file:
        reader = _FileReader(file, contents, wanted)
        try:
            yield from reader.read()
        except (BagError, ModuleNotFoundError):
            raise
        except Exception as error:  # the library's parsers fail in many ways on damaged bytes
            raise BagError(f"{path} {_told(error, reader.at)}") from None


def _told(error: Exception, at: int) -> str:
    """Words for an error. No variable of a frame that it keeps may keep it, as both would stay, with all their data."""
    if isinstance(error, ContradictionError):
        return error.sentence.format(at=at, what=error)
    what = f"{type(error).__name__}: {error}".removesuffix(": ")
    return ContradictionError.sentence.format(at=at, what=what)


def _messages_of(
    raw: bytes, most: int, inflate: Callable[[Chunk], bytes] = inflated
) -> tuple[Chunk | None, list[Place], MessageTable]:
    """Chunk, if it is one, indexes behind it, and messages of a part of a file.

    Parameters
    ----------
    raw : bytes
        A chunk with the indexes behind it, or messages that stand in no chunk.
    most : int
        Largest number of records.
    inflate : callable, optional
        Gives the records of a chunk.
    """
    if raw[0] != Opcode.CHUNK:
        return None, [], find_messages(raw, NO_HINTS, most)
    first, *indexes = records(raw)
    chunk: Chunk = parsed(Opcode.CHUNK, raw[first.begin : first.end])
    rows = (raw[place.begin + _INDEX_HEAD.size : place.end] for place in indexes)
    hints = (np.frombuffer(row[: len(row) // 16 * 16], "<i8")[1::2] for row in rows)
    table = find_messages(inflate(chunk), np.concatenate([NO_HINTS, *hints]), most)
    end = len(table.data)
    require(end == chunk.uncompressed_size, f"no record that ends in its chunk stands at byte {end} of it")
    return chunk, indexes, table


class _FileReader:
    """One file, read from its start to its end.

    Attributes
    ----------
    at : int
        Byte where the record begins that is looked at.
    """

    def __init__(self, file: FileBytes, contents: McapContents, wanted: Wanted) -> None:
        self._file, self._contents, self._wanted = file, contents, wanted
        self._records_left = most_records(len(self._file))
        self._keys: dict[int, TrackKey] = {}
        self._outline = McapOutline(file.path, file.state())
        self._summary = Summary()
        self._check = SummaryCheck(self._summary)
        self._crc = zlib.crc32(MAGIC)  # of the data section, then of the summary
        self._bare_chunks = 0
        self.at, self._end = 0, len(MAGIC)

    def read(self) -> Iterator[tuple[int, Found]]:
        """Read all records; see `read_file`."""
        self._require_magic()
        opcode = 0
        for opcode, begin, end in self._parts():
            found = self._take(opcode, begin, self._file[begin:end])
            if found is not None:
                yield end, found
        if opcode != Opcode.FOOTER or self._file[self._end : self._end + len(MAGIC) + 1] != MAGIC:
            raise self._cut_off()

    def _require_magic(self) -> None:
        start, path = self._file[:16], self._file.path
        if not start:
            raise BagError(f"{path} is empty: record it again, it holds nothing to rescue")
        if not start.startswith(MAGIC):
            hint = next((text for magic, text in _OTHER_FORMATS.items() if start.startswith(magic)), "")
            raise BagError(f"{path} is not an MCAP file: {hint or 'it does not begin as one: give a bag'}")

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

    def _take(self, opcode: int, begin: int, raw: bytes) -> Found | None:
        """Take a part; return the messages of it that are wanted, or None if it is no part with messages."""
        self.at = begin
        self._verify_section(opcode, raw)
        self._check.place(opcode, begin, begin + len(raw))
        if opcode in (Opcode.CHUNK, Opcode.MESSAGE):
            return self._take_messages(begin, raw)
        self._take_record(opcode, raw[RECORD_HEAD.size :])
        return None

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

    def _take_record(self, opcode: int, content: bytes) -> None:
        """Take a record that is no part of one with messages; records of unknown kinds are left to others."""
        record = parsed(opcode, content)
        self._summary.add(record, self.at, RECORD_HEAD.size + len(content))
        match record:
            case Header():
                is_known = record.profile in _PROFILES
                require(is_known, f"its profile is {record.profile!r:.40}, that of a bag of ROS 2 is 'ros2'")
                self._contents.library = self._contents.library or record.library
            case Metadata():
                self._contents.metadata[record.name] = record.metadata
            case Footer():
                self._check.finish(record)
                self._finish()
            case McapRecord():
                self._check.said[opcode].append(record)

    def _finish(self) -> None:
        """Take the account of the whole file into that of the bag."""
        found, contents = self._summary, self._contents
        for channel in found.channels:
            self._outline.channels.setdefault(self._key(channel), []).append(channel)
            contents.tracks[self._key(channel)].count += found.counts[channel]
        contents.attachments += len(found.attachments)
        contents.files.append(FileSpan(self._file.path.name, found.counts.total(), found.first_ns, found.last_ns))
        contents.outlines.append(self._outline)

    def _key(self, number: int) -> TrackKey:
        """Track of a channel."""
        if number not in self._keys:
            channel = self._summary.channels[number]
            schema = self._summary.schemas.get(channel.schema_id, _NO_SCHEMA)
            key, definition = (channel.topic, schema.name), (schema.encoding, schema.data)
            track = self._contents.tracks.setdefault(key, RawTrack(*key, channel.message_encoding, definition))
            alike = (track.encoding, track.definition) == (channel.message_encoding, definition)
            require(alike, f"topic {channel.topic} has messages of two encodings or definitions")
            self._keys[number] = key
        return self._keys[number]

    def _take_messages(self, begin: int, raw: bytes) -> Found:
        """Take messages in a chunk or in none; return those that are wanted."""
        most = self._records_left if raw[0] == Opcode.CHUNK else len(raw)
        chunk, indexes, table = _messages_of(raw, most)
        for place in table.others:
            require(place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL), f"a record of kind {place.opcode:#04x} in a chunk")
        table.require_times()
        self._summary.add_messages(table)
        if chunk is not None:
            self._take_chunk(chunk, begin, indexes, raw, table)
        return self._wanted_of(table, begin, begin + len(raw))

    def _take_chunk(self, chunk: Chunk, begin: int, places: list[Place], raw: bytes, table: MessageTable) -> None:
        said = chunk.message_start_time, chunk.message_end_time
        require(said == table.span_ns or not table.index, f"the times of a chunk are {table.span_ns}, not {said}")
        self._records_left -= len(table.starts) + len(table.others)
        self._bare_chunks += not chunk.uncompressed_crc
        indexes = dict[int, int]()
        for place in places:
            self.at = begin + place.start
            channel = _verified_index(raw[place.begin : place.end], table.index)
            require(channel not in indexes, f"a chunk has two indexes of channel {channel}")
            indexes[channel] = self.at
        self.at = begin
        missing = table.index.keys() - indexes.keys() if indexes else ()
        require(not missing, f"a chunk has no index of channel {min(missing, default=0)}")
        behind = begin + (places[0].start if places else len(raw))
        self._summary.add_chunk(chunk, begin, indexes, behind, begin + len(raw))

    def _wanted_of(self, table: MessageTable, begin: int, end: int) -> Found:
        """Messages that are wanted of a part that stands between two bytes, which is noted."""
        channels: dict[TrackKey, list[int]] = {}
        for channel in table.index:
            channels.setdefault(self._key(channel), []).append(channel)
        self._outline.parts.append((begin, end, tuple(channels)))
        otherwise = table.heads["channel"][table.heads["log_time"] != table.heads["publish_time"]]
        for key, own in channels.items() if len(otherwise) else ():
            self._contents.tracks[key].published_otherwise += int(np.isin(otherwise, own).sum())
        return _by_track(table, {key: own for key, own in channels.items() if self._wanted(*key)})

    def _cut_off(self) -> BagError:
        self.at = self._end
        opcode, ends_well = self._file[self._end : self._end + 1], self._file[-len(MAGIC) :] == MAGIC
        is_record = len(self._file) - self._end >= RECORD_HEAD.size and opcode != b"\0"
        require(not (is_record and ends_well), "a record is longer than the file")
        count = self._summary.counts.total()
        holds = f"holds at least {counted(count, 'whole message')}" if count else "may hold whole messages"
        what = f"was cut off, or is still being written: it {holds}: rescue them with {RESCUE}"
        return BagError(f"{self._file.path} {what}")


def _verified_index(content: bytes, found: Mapping[int, Rows]) -> int:
    """Channel of a message index, which must be that of the messages found in its chunk."""
    channel: int
    channel, size = _INDEX_HEAD.unpack_from(content)
    require(size <= len(content) - _INDEX_HEAD.size, f"the index of channel {channel} is longer than its record")
    rows = np.frombuffer(content[_INDEX_HEAD.size :][:size], "<u8").reshape(-1, 2)
    is_same = np.array_equal(rows[np.argsort(rows[:, 1], kind="stable")], found.get(channel, _NO_ROWS))
    require(is_same, f"the index of channel {channel} is not that of its chunk's messages")
    return channel


def _by_track(table: MessageTable, channels: Mapping[TrackKey, Sequence[int]]) -> Found:
    """Messages of some tracks, each of which has several channels where there were several publishers or recorders."""
    found, starts = Found(), table.starts + HEAD.itemsize
    for key, own in channels.items():
        is_own = np.full(2**16, fill_value=False)
        is_own[own] = True
        rows = np.flatnonzero(is_own[table.heads["channel"]])
        found[key] = RawMessages.of(table.data, starts[rows], table.ends[rows], table.log_times[rows])
    return found
