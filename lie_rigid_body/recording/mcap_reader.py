"""Reading an MCAP file from its start to its end: every record framed, every checksum compared, nothing guessed.

What is read depends on the data section alone. Indexes, statistics and the rest of the summary are hints: they may be
left out, in whole or in part, and no message is another one if they are wrong.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Header, Metadata, Schema

from lie_rigid_body.foundation.arrays import items
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.recording.inflation import decompress, decompress_partial, other_format
from lie_rigid_body.recording.mcap_contents import (
    ChunkMessages,
    McapContents,
    Parts,
    Progress,
    RawMessages,
    RawTopic,
    TopicKey,
)
from lie_rigid_body.recording.records import (
    CHANGED,
    HEAD,
    MAGIC,
    MAX_RECORD_BYTES,
    RECORD_HEAD,
    RESCUE,
    WITH_MESSAGES,
    DamageError,
    ExcessError,
    FileBytes,
    MessageTable,
    Place,
    Rows,
    chunk_of,
    find_messages,
    parts,
    require,
)
from lie_rigid_body.recording.summary import Summary

_NO_ROWS: Final = np.empty((0, 2), dtype="<u8")
_NO_SCHEMA: Final = Schema(data=b"", encoding="", id=0, name="")
_PROFILES: Final = ("ros2", "")
_Place: TypeAlias = tuple[int, int, dict[TopicKey, list[int]]]
"""Bytes where a part with messages begins and ends, and the channels in it by their tracks."""


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
    found : ChunkMessages
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
        except DamageError as error:
            raise BagError(f"{path} {error.sentence.format(at=reader.at, what=error)}") from None


def _read_again(
    path: Path, state: tuple[int, ...], places: Iterable[_Place], keys: Collection[TopicKey], progress: Progress
) -> Iterator[ChunkMessages]:
    """Messages of some tracks in a file that was read before, and was in some state then; see `McapContents.read`."""
    with closing(FileBytes(path)) as file:
        try:
            for begin, end, there in places:
                channels = {key: own for key, own in there.items() if key in keys}
                yield _found_again(file[begin:end], channels) if channels else {}
                progress(end - begin)
            require(file.state() == state, "it is another file")
        except DamageError as error:
            raise BagError(f"{path} {CHANGED}") from error


def _found_again(raw: bytes, channels: Mapping[TopicKey, Sequence[int]]) -> ChunkMessages:
    """Messages of some tracks in a part whose checksum was compared when it was read first."""
    chunk, hints = chunk_of(raw)
    return _by_track(find_messages(decompress_partial(chunk) if chunk else raw, hints), channels)


class _FileReader:
    """One file, read from its start to its end.

    Attributes
    ----------
    at : int
        Byte where the record begins that is looked at.
    """

    def __init__(self, file: FileBytes, contents: McapContents) -> None:
        self._file = file
        self._contents = contents
        self._state = file.state()
        self._tracks: dict[int, RawTopic] = {}
        self._places: list[_Place] = []
        self._summary = Summary()
        self._crc = zlib.crc32(MAGIC)  # of the data section
        self._is_over = False  # the data section
        self.at = 0

    def read(self) -> Parts:
        """Read all records; see `read_file`."""
        self._require_magic()
        part = Place(0, 0, 0, len(MAGIC))
        for part in parts(self._file):
            self.at = part.start
            if self._is_over:
                self._take_hint(part)
                continue
            found = self._take(part)
            if part.opcode in WITH_MESSAGES:
                yield part.end - part.start, found
        if part.opcode != Opcode.FOOTER or self._file[part.end : part.end + len(MAGIC) + 1] != MAGIC:
            raise self._cut_off(part.end)
        require(self._is_over, "its data section has no end")
        self._finish()

    def _require_magic(self) -> None:
        start = self._file[:16]
        path = self._file.path
        if not start:
            raise BagError(f"{path} is empty: record it again, it holds nothing to rescue")
        if not start.startswith(MAGIC):
            hint = other_format(start) or "it does not begin as one: give a bag"
            raise BagError(f"{path} is not an MCAP file: {hint}")

    def _take(self, part: Place) -> ChunkMessages:
        """Take a part of the data section; return the messages of it that are wanted."""
        if part.end - part.begin > MAX_RECORD_BYTES:
            raise ExcessError(f"a record of {part.end - part.begin} bytes")
        raw = self._file[part.start : part.end]
        if part.opcode == Opcode.DATA_END:
            self._end_data(raw[RECORD_HEAD.size :])
            return {}
        self._crc = zlib.crc32(raw, self._crc)
        if part.opcode in WITH_MESSAGES:
            return self._take_messages(part, raw)
        if part.opcode == Opcode.ATTACHMENT:
            self._contents.attachments += 1
            return {}
        match self._summary.read(part.opcode, raw[RECORD_HEAD.size :]):
            case Header(profile=profile, library=library):
                if profile not in _PROFILES:
                    raise BagError(f"{self._file.path} is of profile {profile!r:.40}, not 'ros2': record it in ROS 2")
                self._contents.library = self._contents.library or library
            case Metadata(name=name, metadata=metadata):
                self._contents.metadata[name] = metadata
        return {}

    def _take_hint(self, part: Place) -> None:
        """Take a definition in the summary, which may be that of a topic without messages."""
        if part.opcode in (Opcode.SCHEMA, Opcode.CHANNEL) and part.end - part.begin <= MAX_RECORD_BYTES:
            with suppress(DamageError):
                self._summary.read(part.opcode, self._file[part.begin : part.end])

    def _end_data(self, content: bytes) -> None:
        """Compare the checksum of the data section."""
        declared = int.from_bytes(content[:4], "little")
        require(declared in (0, self._crc), f"the checksum of its data section is {self._crc:08x}, not {declared:08x}")
        self._is_over = True

    def _take_messages(self, part: Place, raw: bytes) -> ChunkMessages:
        """Take messages in a chunk or in none; return those that are wanted."""
        chunk, hints = chunk_of(raw)
        data = decompress(chunk) if chunk else raw
        table = find_messages(data, hints)
        is_whole = len(table.data) == len(data)
        require(is_whole, f"no record that ends in its chunk stands at byte {len(table.data)} of it")
        self._summary.add_messages(table)
        otherwise = table.heads["channel"][table.heads["log_time"] != table.heads["publish_time"]]
        channels: dict[TopicKey, list[int]] = {}
        for channel, rows in table.index.items():
            track = self._track(channel)
            track.count += len(rows)
            track.publish_time_mismatches += int(np.count_nonzero(otherwise == channel))
            channels.setdefault(track.key, []).append(channel)
        self._places.append((part.start, part.end, channels))
        return _by_track(table, {key: own for key, own in channels.items() if self._contents.wanted(*key)})

    def _track(self, number: int) -> RawTopic:
        """Track of a channel."""
        if number not in self._tracks:
            channel = self._summary.channels[number]
            schema = self._summary.schemas.get(channel.schema_id, _NO_SCHEMA)
            own = RawTopic(channel.topic, schema.name, channel.message_encoding, (schema.encoding, schema.data))
            track = self._contents.tracks.setdefault(own.key, own)
            require(track.encoding == own.encoding, f"topic {channel.topic} has messages of two encodings")
            self._tracks[number] = track
        return self._tracks[number]

    def _finish(self) -> None:
        """Add the topics without messages, and what reads the file again."""
        for number in self._summary.channels:
            self._track(number)
        self._contents.again.append(partial(_read_again, self._file.path, self._state, self._places))

    def _cut_off(self, end: int) -> BagError:
        """Error for a file whose last whole record ends at a byte."""
        self.at = end
        path = self._file.path
        is_record = len(self._file) - end >= RECORD_HEAD.size and self._file[end : end + 1] != b"\0"
        require(not (is_record and self._file[-len(MAGIC) :] == MAGIC), "a record is longer than the file")
        count = self._summary.counts.total()
        if self._is_over:
            behind = f"at byte {end}, behind all of its {counted(count, 'message')}"
            return BagError(f"{path} breaks off in its summary {behind}: write it whole with {RESCUE}")
        holds = f"holds at least {counted(count, 'whole message')}" if count else "may hold whole messages"
        return BagError(
            f"{path} was cut off behind byte {end}, or is still being written: it {holds}: rescue them with {RESCUE}"
        )


def _by_track(table: MessageTable, channels: Mapping[TopicKey, Sequence[int]]) -> ChunkMessages:
    """Messages of some tracks, each of which has several channels where there were several publishers or recorders."""
    found = ChunkMessages()
    for key, own in channels.items():
        several = [table.index.get(channel, _NO_ROWS) for channel in own]
        rows = several[0] if len(several) == 1 else _in_order(np.concatenate(several))
        times, starts = np.ascontiguousarray(rows.T).view(np.int64)
        lengths = items(table.data, starts + 1, 8).view("<i8")
        found[key] = RawMessages.of(table.data, starts + HEAD.itemsize, starts + RECORD_HEAD.size + lengths, times)
    return found


def _in_order(rows: Rows) -> Rows:
    """Rows of several channels in the order of their messages."""
    return rows[np.argsort(rows[:, 1], kind="stable")]
