"""Comparison of what an MCAP file says of itself, in indexes, statistics and repeated records, with what it holds.

A reader that seeks believes them: a message that an index leaves out would not be in the bag for it.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any, Final

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
from lie_rigid_body.recording.indexes import attachment_index, chunk_index
from lie_rigid_body.recording.message_table import LAST_TIME, MessageTable, require

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


class Inventory:
    """Records of one file as they come, each held against those that speak of it."""

    def __init__(self) -> None:
        self._opcodes: Counter[int] = Counter()
        self._in_summary = False
        self._summary_start = 0
        self._repeatable: dict[tuple[type, int], Schema | Channel] = {}
        self._only_in_summary: Counter[type] = Counter()
        self._counts: Counter[int] = Counter()
        self._first, self._last = LAST_TIME, 0
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._said = defaultdict[type, list[Any]](list)  # records of the summary by their types
        self._groups: dict[int, tuple[int, int]] = {}

    @property
    def span(self) -> tuple[int, int, int]:
        """Count of messages, and the first and last time when one was logged, ns."""
        return self._counts.total(), self._first, self._last

    @property
    def chunk_count(self) -> int:
        """Number of chunks that were read whole."""
        return len(self._chunks)

    def record(self, opcode: int, position: int, length: int) -> None:
        """Note a record of the file at a byte, with its length without head; its place must be where it belongs."""
        require(bool(self._opcodes) or opcode == Opcode.HEADER, "it does not begin with a header")
        if self._opcodes and opcode <= Opcode.DATA_END:
            require(opcode in (_IN_SUMMARY if self._in_summary else _IN_DATA), f"a record {opcode:#x} is out of place")
        self._opcodes[opcode] += 1
        end = position + OPCODE_AND_LENGTH + length
        if self._in_summary:
            begin, before = self._groups.get(opcode, (position, position))
            require(before == position, "the groups of its summary are mixed")
            self._groups[opcode] = begin, end
        elif opcode == Opcode.DATA_END:
            self._in_summary, self._summary_start = True, end

    def repeatable(self, record: Schema | Channel) -> None:
        """Take a schema or a channel, which must be the same wherever it is repeated."""
        key = type(record), record.id
        self._only_in_summary[type(record)] += key not in self._repeatable and self._in_summary
        same = self._repeatable.setdefault(key, record) == record
        require(same, f"it has two different records of {type(record).__name__.lower()} {record.id}")

    def messages(self, table: MessageTable) -> None:
        """Count messages."""
        self._counts.update(table.counts)
        for entries in table.entries.values():
            self._first, self._last = min(self._first, entries.first_ns), max(self._last, entries.last_ns)

    def chunk(self, chunk: Chunk, table: MessageTable, position: int, length: int) -> None:
        """Take a chunk whose record begins at a byte, with its length without head, and the messages found in it."""
        if entries := table.entries.values():
            _agree("first time of a chunk", chunk.message_start_time, min(each.first_ns for each in entries))
            _agree("last time of a chunk", chunk.message_end_time, max(each.last_ns for each in entries))
        _agree("length of a chunk", chunk.uncompressed_size, len(table.data))
        self._chunks.append(chunk_index(chunk, position, OPCODE_AND_LENGTH + length))

    def message_index(self, content: bytes, table: MessageTable, position: int) -> None:
        """Take the index of one channel's messages in the last chunk, with the messages found in that."""
        channel, size = int.from_bytes(content[:2], "little"), int.from_bytes(content[2:6], "little")
        require(size <= len(content) - 6, f"the index of channel {channel} is longer than its record")
        found = table.entries[channel].rows.tobytes() if channel in table.entries else b""
        said = content[6 : 6 + size]
        if said != found:
            rows = np.frombuffer(said, dtype="<u8").reshape(-1, 2)
            said = rows[np.argsort(rows[:, 1], kind="stable")].tobytes()
        require(said == found, f"the index of channel {channel} is not that of its chunk's messages")
        index = self._chunks[-1]
        require(channel not in index.message_index_offsets, f"a chunk has two indexes of channel {channel}")
        index.message_index_offsets[channel] = position
        index.message_index_length += OPCODE_AND_LENGTH + len(content)

    def require_indexes(self, table: MessageTable) -> None:
        """Refuse a last chunk that has indexes, but not of all channels of the messages found in it."""
        missing = table.counts.keys() - self._chunks[-1].message_index_offsets.keys()
        require(not missing, f"a chunk has no index of channel {min(missing, default=0)}")

    def attachment(self, attachment: Attachment, position: int, length: int) -> None:
        """Take an attachment whose record begins at a byte, with its length without head."""
        self._attachments.append(attachment_index(attachment, position, OPCODE_AND_LENGTH + length))

    def metadata(self, metadata: Metadata, position: int, length: int) -> None:
        """Take a metadata record that begins at a byte, with its length without head."""
        self._metadata.append(MetadataIndex(offset=position, length=OPCODE_AND_LENGTH + length, name=metadata.name))

    def summary(self, record: object, length: int) -> None:
        """Take a record of the summary that is neither schema nor channel."""
        self._said[type(record)].append(record)

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
        for what, kind, found in (
            ("chunks", ChunkIndex, self._chunks),
            ("attachments", AttachmentIndex, self._attachments),
            ("metadata", MetadataIndex, self._metadata),
        ):
            said = self._said[kind]
            # an index may be left out as a whole: then readers scan
            require(not said or said == found, f"the index of its {what} is not that of the {what} it has")
        require(len(self._said[Statistics]) <= 1, "it has two records of statistics")
        for statistics in self._said[Statistics]:
            self._hold_statistics(statistics)
        self._hold_offsets(footer, position)

    def _hold_statistics(self, said: Statistics) -> None:
        counts = {channel: count for channel, count in said.channel_message_counts.items() if count}
        require(counts == dict(self._counts), "its counts of messages by channel are not those of its messages")
        schemas, channels = (sum(kind is known for known, _ in self._repeatable) for kind in (Schema, Channel))
        # some writers count those that no message uses, which stand in the summary alone
        schemas -= self._only_in_summary[Schema] * (said.schema_count != schemas)
        channels -= self._only_in_summary[Channel] * (said.channel_count != channels)
        found = {
            "number of its messages": (said.message_count, self._counts.total()),
            "number of its chunks": (said.chunk_count, len(self._chunks)),
            "number of its attachments": (said.attachment_count, len(self._attachments)),
            "number of its metadata records": (said.metadata_count, len(self._metadata)),
            "number of its schemas": (said.schema_count, schemas),
            "number of its channels": (said.channel_count, channels),
        }
        if self._counts:
            found["first time of all messages"] = said.message_start_time, self._first
            found["last time of all messages"] = said.message_end_time, self._last
        for what, numbers in found.items():
            _agree(what, *numbers)

    def _hold_offsets(self, footer: Footer, position: int) -> None:
        groups = {opcode: (begin, end - begin) for opcode, (begin, end) in self._groups.items()}
        groups.pop(Opcode.FOOTER)
        offsets, _ = groups.pop(Opcode.SUMMARY_OFFSET, (position, 0))
        said = {o.group_opcode: (o.group_start, o.group_length) for o in self._said[SummaryOffset] if o.group_length}
        require(
            not self._said[SummaryOffset] or said == groups, "the offsets of its summary are not those of its groups"
        )
        has_summary = position > self._summary_start
        require(
            footer.summary_start == self._summary_start or not (has_summary or footer.summary_start),
            f"its footer says that the summary begins at byte {footer.summary_start}, not {self._summary_start}",
        )
        require(
            footer.summary_offset_start == offsets or not (self._said[SummaryOffset] or footer.summary_offset_start),
            f"its footer says that the summary's offsets begin at byte {footer.summary_offset_start}, not {offsets}",
        )


def require_in_chunk(opcode: int) -> None:
    """Refuse a record that may not stand in a chunk."""
    require(opcode in _IN_CHUNK, f"a record of kind {opcode:#04x} in a chunk")


def _agree(what: str, said: int, found: int) -> None:
    require(said == found, f"the {what} is {found}, not {said}")
