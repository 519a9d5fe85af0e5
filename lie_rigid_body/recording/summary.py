"""Declarations and counts of an MCAP file: channels and schemas of its messages, and the summary at its end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from lie_rigid_body.recording.records import MAX_TIME, MessageTable, parsed, require


class Summary:
    """Summary of the records of a file.

    Attributes
    ----------
    schemas : dict of int to Schema
    channels : dict of int to Channel
    counts : Counter of int
        Messages of each channel that has any.
    first_ns, last_ns : int
        The earliest and the latest log time, ns; `MAX_TIME` and 0 without messages.
    chunks : list of ChunkIndex
    """

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.counts: Counter[int] = Counter()
        self.first_ns = MAX_TIME
        self.last_ns = 0
        self.chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []

    def read(self, opcode: int, content: bytes) -> Any:
        """Parse a record that stands in no chunk, and add what it declares.

        Raises
        ------
        DamageError
            See `declare` and `parsed`.
        """
        record = parsed(opcode, content)
        if isinstance(record, Schema | Channel):
            self.declare(record)
        return record

    def declare(self, record: Schema | Channel) -> None:
        """Add a schema or a channel.

        Raises
        ------
        DamageError
            If it repeats another one, and is not the same, or is a channel of no schema.
        """
        declared: dict[int, Any] = self.schemas
        if isinstance(record, Channel):
            is_known = record.schema_id in (0, *self.schemas)
            require(is_known, f"the schema of topic {record.topic:.100} is not declared before it")
            declared = self.channels
        same = declared.setdefault(record.id, record)
        require(same == record, f"it has two different records of {type(record).__name__.lower()} {record.id}")

    def add_messages(self, table: MessageTable) -> None:
        """Add the messages of a chunk, with the schemas and channels in it, or messages that stand in none.

        Raises
        ------
        DamageError
            See `read`; or if there is a message of a channel that is not declared. Then nothing is added.
        """
        schemas = {**self.schemas}
        channels = {**self.channels}
        try:
            for place in table.definitions:
                self.read(place.opcode, table.data[place.begin : place.end])
            unknown = min(table.index.keys() - self.channels.keys(), default=None)
            require(unknown is None, f"it has a message of channel {unknown}, which is not declared before it")
        except Exception:
            self.schemas = schemas
            self.channels = channels
            raise
        self.counts.update({channel: len(rows) for channel, rows in table.index.items()})
        first_ns, last_ns = table.span_ns
        self.first_ns = min(self.first_ns, first_ns)
        self.last_ns = max(self.last_ns, last_ns)

    def add_chunk(self, chunk: Chunk, begin: int, indexes: Mapping[int, int], end: int) -> None:
        """Add a chunk whose messages were added.

        Parameters
        ----------
        chunk : Chunk
        begin : int
            Byte where its record begins.
        indexes : mapping of int to int
            Bytes where the indexes of its messages begin, by channel.
        end : int
            Byte where the last of them ends, or without any its record.
        """
        behind = min(indexes.values(), default=end)
        self.chunks.append(
            ChunkIndex(
                message_start_time=chunk.message_start_time,
                message_end_time=chunk.message_end_time,
                chunk_start_offset=begin,
                chunk_length=behind - begin,
                message_index_offsets=dict(indexes),
                message_index_length=end - behind,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                uncompressed_size=chunk.uncompressed_size,
            )
        )

    def add_index(self, record: Metadata | Attachment, begin: int, length: int) -> None:
        """Add metadata or an attachment whose record begins at a byte and has a size."""
        if isinstance(record, Metadata):
            self._metadata.append(MetadataIndex(offset=begin, length=length, name=record.name))
            return
        self._attachments.append(
            AttachmentIndex(
                offset=begin,
                length=length,
                log_time=record.log_time,
                create_time=record.create_time,
                data_size=len(record.data),
                name=record.name,
                media_type=record.media_type,
            )
        )

    def groups(self) -> dict[int, list[McapRecord]]:
        """Records of the summary by their opcodes, in the order in which they are written."""
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(self.counts),
            chunk_count=len(self.chunks),
            message_count=self.counts.total(),
            message_start_time=self.first_ns if self.counts else 0,
            message_end_time=self.last_ns,
            metadata_count=len(self._metadata),
            schema_count=len(self.schemas),
        )
        return {
            Opcode.SCHEMA: [*self.schemas.values()],
            Opcode.CHANNEL: [*self.channels.values()],
            Opcode.STATISTICS: [statistics],
            Opcode.CHUNK_INDEX: [*self.chunks],
            Opcode.ATTACHMENT_INDEX: [*self._attachments],
            Opcode.METADATA_INDEX: [*self._metadata],
        }
