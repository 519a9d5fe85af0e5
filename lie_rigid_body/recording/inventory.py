"""What an MCAP file says of itself, in indexes, statistics and repeated records, held against what it holds.

A reader that seeks believes them: a message that an index leaves out would not be in the bag for it.
"""

from __future__ import annotations

from array import array
from collections import Counter
from itertools import accumulate, pairwise
from typing import Final, TypeVar

import numpy as np
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lie_rigid_body.recording.chunk import OPCODE_AND_LENGTH
from lie_rigid_body.recording.message_table import LAST_TIME, ContradictionError, MessageTable, require

_IN_DATA: Final = frozenset(
    {
        Opcode.SCHEMA,
        Opcode.CHANNEL,
        Opcode.MESSAGE,
        Opcode.CHUNK,
        Opcode.MESSAGE_INDEX,
        Opcode.ATTACHMENT,
        Opcode.METADATA,
        Opcode.DATA_END,
    }
)
_IN_SUMMARY: Final = frozenset(
    {
        Opcode.SCHEMA,
        Opcode.CHANNEL,
        Opcode.STATISTICS,
        Opcode.CHUNK_INDEX,
        Opcode.ATTACHMENT_INDEX,
        Opcode.METADATA_INDEX,
        Opcode.SUMMARY_OFFSET,
        Opcode.FOOTER,
    }
)
_IN_CHUNK: Final = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE})

_ENTRY: Final = np.dtype([("log_time", "<u8"), ("start", "<u8")])
"""Of a message in the index of its channel."""

R = TypeVar("R", Schema, Channel)


class Inventory:
    """The records of one file as they come, each held against those that speak of it."""

    def __init__(self) -> None:
        self._opcodes: Counter[int] = Counter()
        self._in_summary = False
        self._summary_start = 0
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._only_in_summary: Counter[type] = Counter()
        self._counts: Counter[int] = Counter()
        self._first, self._last = LAST_TIME, 0
        self._entries: dict[int, bytes] | None = None  # of the chunk whose message indexes are being read
        self._indexed: set[int] = set()
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._chunk_indexes: list[ChunkIndex] = []
        self._attachment_indexes: list[AttachmentIndex] = []
        self._metadata_indexes: list[MetadataIndex] = []
        self._groups: dict[int, tuple[int, int]] = {}
        self._offsets: list[SummaryOffset] = []
        self._statistics: Statistics | None = None

    @property
    def chunk_count(self) -> int:
        """Chunks that were read whole."""
        return len(self._chunks)

    @property
    def chunk_places(self) -> array[int]:
        """The bytes where the records of the chunks begin."""
        return array("q", (chunk.chunk_start_offset for chunk in self._chunks))

    @property
    def largest_chunk(self) -> int:
        """The size of the largest one, inflated, bytes."""
        return max((chunk.uncompressed_size for chunk in self._chunks), default=0)

    @property
    def span(self) -> tuple[int, int, int]:
        """Count of messages, and the first and last time when one was logged, ns."""
        return self._counts.total(), self._first, self._last

    def record(self, opcode: int, position: int, length: int) -> None:
        """Note a record of the file at a byte, with its length without head; its place must be where it belongs."""
        if not self._opcodes and opcode != Opcode.HEADER:
            raise ContradictionError("it does not begin with a header")
        if self._opcodes and opcode <= Opcode.DATA_END:
            require(opcode in (_IN_SUMMARY if self._in_summary else _IN_DATA), f"a record {opcode:#x} is out of place")
        self._opcodes[opcode] += 1
        if opcode != Opcode.MESSAGE_INDEX:
            self._end_chunk()
        end = position + OPCODE_AND_LENGTH + length
        if self._in_summary:
            begin, before = self._groups.get(opcode, (position, position))
            require(before == position, "the groups of its summary are mixed")
            self._groups[opcode] = begin, end
        elif opcode == Opcode.DATA_END:
            self._in_summary, self._summary_start = True, end

    def schema(self, schema: Schema) -> None:
        """Take a schema, which must be the same wherever it is repeated."""
        self._repeatable(self._schemas, schema, "schema")

    def channel(self, channel: Channel) -> None:
        """Take a channel, which must be the same wherever it is repeated."""
        self._repeatable(self._channels, channel, "channel")

    def _repeatable(self, known: dict[int, R], record: R, what: str) -> None:
        if record.id not in known and self._in_summary:
            self._only_in_summary[type(record)] += 1
        if known.setdefault(record.id, record) != record:
            raise ContradictionError(f"it has two different records of {what} {record.id}")

    def messages(self, table: MessageTable) -> None:
        """Count messages."""
        self._counts.update(table.counts)
        if len(table.starts):
            self._first, self._last = min(self._first, table.span[0]), max(self._last, table.span[1])

    def chunk(self, chunk: Chunk, table: MessageTable, position: int, length: int) -> None:
        """Take a chunk whose record begins at a byte, with its length without head, and the messages found in it."""
        if len(table.starts):
            _agree("first time of a chunk", chunk.message_start_time, table.span[0])
            _agree("last time of a chunk", chunk.message_end_time, table.span[1])
        _agree("length of a chunk", chunk.uncompressed_size, len(table.data))
        self._entries, self._indexed = _entries(table), set()
        self._chunks.append(
            ChunkIndex(
                message_start_time=chunk.message_start_time,
                message_end_time=chunk.message_end_time,
                chunk_start_offset=position,
                chunk_length=OPCODE_AND_LENGTH + length,
                message_index_offsets={},
                message_index_length=0,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                uncompressed_size=chunk.uncompressed_size,
            )
        )

    def message_index(self, content: bytes, position: int) -> None:
        """Take the index of one channel's messages in the chunk before it."""
        require(self._entries is not None, "a message index follows no chunk")
        assert self._entries is not None
        channel, size = int.from_bytes(content[:2], "little"), int.from_bytes(content[2:6], "little")
        require(size <= len(content) - 6, f"the index of channel {channel} is longer than its record")
        found, said = self._entries.get(channel, b""), content[6 : 6 + size]
        if said != found:
            said = np.sort(np.frombuffer(said, dtype=_ENTRY), order="start", kind="stable").tobytes()
        require(said == found, f"the index of channel {channel} is not that of its chunk's messages")
        require(channel not in self._indexed, f"a chunk has two indexes of channel {channel}")
        self._indexed.add(channel)
        index = self._chunks[-1]
        index.message_index_offsets[channel] = position
        index.message_index_length += OPCODE_AND_LENGTH + len(content)

    def _end_chunk(self) -> None:
        if self._entries is not None and self._indexed:
            missing = self._entries.keys() - self._indexed
            require(not missing, f"a chunk has no index of channel {min(missing, default=0)}")
        self._entries = None

    def attachment(self, attachment: Attachment, position: int, length: int) -> None:
        """Take an attachment whose record begins at a byte, with its length without head."""
        self._attachments.append(
            AttachmentIndex(
                offset=position,
                length=OPCODE_AND_LENGTH + length,
                log_time=attachment.log_time,
                create_time=attachment.create_time,
                data_size=len(attachment.data),
                name=attachment.name,
                media_type=attachment.media_type,
            )
        )

    def metadata(self, metadata: Metadata, position: int, length: int) -> None:
        """Take a metadata record that begins at a byte, with its length without head."""
        self._metadata.append(MetadataIndex(offset=position, length=OPCODE_AND_LENGTH + length, name=metadata.name))

    def summary(self, record: object) -> None:
        """Take a record of the summary that is neither schema nor channel."""
        if isinstance(record, Statistics):
            require(self._statistics is None, "it has two records of statistics")
            self._statistics = record
        elif isinstance(record, SummaryOffset):
            self._offsets.append(record)
        elif isinstance(record, ChunkIndex):
            self._chunk_indexes.append(record)
        elif isinstance(record, AttachmentIndex):
            self._attachment_indexes.append(record)
        elif isinstance(record, MetadataIndex):
            self._metadata_indexes.append(record)

    def finish(self, footer: Footer, position: int) -> None:
        """Hold the whole summary, whose footer begins at a byte, against what was read.

        Raises
        ------
        ContradictionError
            Naming the first thing that does not fit.
        """
        require(self._in_summary, "its data section has no end")
        require(
            not (self._opcodes[Opcode.CHUNK] and self._opcodes[Opcode.MESSAGE]), "messages stand outside its chunks"
        )
        self._hold_indexes()
        if self._statistics is not None:
            self._hold_statistics(self._statistics)
        self._hold_offsets(footer, position)

    def _hold_indexes(self) -> None:
        for what, said, found in (
            ("chunks", self._chunk_indexes, self._chunks),
            ("attachments", self._attachment_indexes, self._attachments),
            ("metadata", self._metadata_indexes, self._metadata),
        ):
            # an index may be left out as a whole: then readers scan
            require(not said or said == found, f"the index of its {what} is not that of the {what} it has")

    def _hold_statistics(self, said: Statistics) -> None:
        _agree("number of its messages", said.message_count, self._counts.total())
        counts = {channel: count for channel, count in said.channel_message_counts.items() if count}
        require(counts == dict(self._counts), "its counts of messages by channel are not those of its messages")
        _agree("number of its chunks", said.chunk_count, len(self._chunks))
        _agree("number of its attachments", said.attachment_count, len(self._attachments))
        _agree("number of its metadata records", said.metadata_count, len(self._metadata))
        # some writers count those that no message uses, which stand in the summary alone
        for what, count, known, kind in (
            ("schemas", said.schema_count, len(self._schemas), Schema),
            ("channels", said.channel_count, len(self._channels), Channel),
        ):
            if count != known - self._only_in_summary[kind]:
                _agree(f"number of its {what}", count, known)
        if self._counts:
            _agree("first time of all messages", said.message_start_time, self._first)
            _agree("last time of all messages", said.message_end_time, self._last)

    def _hold_offsets(self, footer: Footer, position: int) -> None:
        groups = {opcode: (begin, end - begin) for opcode, (begin, end) in self._groups.items()}
        groups.pop(Opcode.FOOTER)
        offsets, _ = groups.pop(Opcode.SUMMARY_OFFSET, (position, 0))
        said = {o.group_opcode: (o.group_start, o.group_length) for o in self._offsets if o.group_length}
        require(not self._offsets or said == groups, "the offsets of its summary are not those of its groups")
        has_summary = position > self._summary_start
        require(
            footer.summary_start == self._summary_start or not (has_summary or footer.summary_start),
            f"its footer says that the summary begins at byte {footer.summary_start}, not {self._summary_start}",
        )
        require(
            footer.summary_offset_start == offsets or not (self._offsets or footer.summary_offset_start),
            f"its footer says that the summary's offsets begin at byte {footer.summary_offset_start}, not {offsets}",
        )


def _entries(table: MessageTable) -> dict[int, bytes]:
    """For each channel the index of its messages in a chunk, as it is written: log time and start of each."""
    order = np.argsort(table.channels, kind="stable")
    entries = np.empty(len(order), dtype=_ENTRY)
    entries["log_time"], entries["start"] = table.log_times[order], table.starts[order]
    bounds = pairwise(accumulate(table.counts.values(), initial=0))
    return {channel: entries[begin:end].tobytes() for channel, (begin, end) in zip(table.counts, bounds, strict=True)}


def require_in_chunk(opcode: int) -> None:
    """Refuse a record that may not stand in a chunk."""
    require(opcode in _IN_CHUNK, f"a record of kind {opcode:#04x} in a chunk")


def _agree(what: str, said: int, found: int) -> None:
    require(said == found, f"the {what} is {found}, not {said}")
