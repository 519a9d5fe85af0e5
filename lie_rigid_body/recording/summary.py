"""Summary of an MCAP file: made of its records as they are written, and held against that of a file that is read.

A reader that seeks believes a summary: a message that an index leaves out would not be in the bag for it.
"""

from __future__ import annotations

import struct
from collections import Counter, defaultdict
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, Final

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from lie_rigid_body.recording.records import (
    LAST_TIME,
    MESSAGE,
    ExcessError,
    MessageTable,
    parsed,
    record_bytes,
    require,
    size_of,
)
from lie_rigid_body.recording.sound_records import whole_records
from lie_rigid_body.system.bounded_input import LARGEST_DECLARATIONS

_IN_DATA: Final = frozenset(
    {
        Opcode.SCHEMA,
        Opcode.CHANNEL,
        Opcode.MESSAGE,
        Opcode.CHUNK,
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
_INDEXES: Final = {
    Opcode.CHUNK_INDEX: "chunks",
    Opcode.ATTACHMENT_INDEX: "attachments",
    Opcode.METADATA_INDEX: "metadata",
}


class Summary:
    """Summary of the records of a file.

    Attributes
    ----------
    schemas : dict of int to Schema
    channels : dict of int to Channel
    counts : Counter of int
        Messages of each channel that has any.
    first_ns, last_ns : int
        The earliest and the latest log time, ns; `LAST_TIME` and 0 without messages.
    chunks : list of ChunkIndex
    attachments : list of AttachmentIndex
    """

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.counts: Counter[int] = Counter()
        self.first_ns, self.last_ns = LAST_TIME, 0
        self.chunks: list[ChunkIndex] = []
        self.attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._declared = 0  # size of names, definitions and metadata, bytes

    def add(self, record: Any, begin: int, length: int) -> None:
        """Add a record that begins at a byte and has a size, if it is of a kind of which a summary tells.

        Raises
        ------
        ContradictionError
            If it is a schema or a channel that repeats another one, and is not the same, or a channel of no schema.
        """
        kind = type(record).__name__.lower()
        declared: Any = {"schema": self.schemas, "channel": self.channels}.get(kind)
        if isinstance(record, Metadata) or (declared is not None and record.id not in declared):
            self._declared += sum(map(size_of, vars(record).values()))
            if self._declared > LARGEST_DECLARATIONS:
                raise ExcessError(f"names and definitions of {self._declared} bytes")
        match record:
            case Metadata():
                self._metadata.append(MetadataIndex(offset=begin, length=length, name=record.name))
            case Attachment():
                self.attachments.append(
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
            case Channel():
                require(
                    record.schema_id in (0, *self.schemas),
                    f"the schema of topic {record.topic} is not declared before it",
                )
        if declared is not None:
            same = declared.setdefault(record.id, record)
            require(same == record, f"it has two different records of {kind} {record.id}")

    def add_messages(self, table: MessageTable) -> None:
        """Add the messages of a chunk, with the schemas and channels in it, or messages that stand in none.

        Raises
        ------
        ContradictionError
            See `add`; or if the chunk has other records, or a message of a channel that is not declared, or of a time
            beyond 64 bits. Then nothing is added.
        """
        before = {**self.schemas}, {**self.channels}
        try:
            for place in table.others:
                is_declaration = place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL)
                require(place.opcode != Opcode.MESSAGE, "a message record is too short")
                require(is_declaration, f"a record of kind {place.opcode:#04x} in a chunk")
                record = parsed(place.opcode, table.data[place.begin : place.end])
                # in a chunk the `mcap` library takes what follows the fields of a record for another one
                is_exact = record_bytes(record) == table.data[place.start : place.end]
                require(is_exact, "a definition in a chunk is longer than its fields")
                rows = table.index.get(record.id) if place.opcode == Opcode.CHANNEL else None
                is_late = rows is not None and record.id not in self.channels and rows[0, 1] < place.start
                require(not is_late, "a channel is declared behind its first message")
                self.add(record, place.start, 0)
            table.require_times()
            unknown = min(table.index.keys() - self.channels.keys(), default=None)
            require(unknown is None, f"it has a message of channel {unknown}, which is not declared before it")
        except Exception:
            self.schemas, self.channels = before
            raise
        self.counts.update({channel: len(rows) for channel, rows in table.index.items()})
        first_ns, last_ns = table.span_ns
        self.first_ns, self.last_ns = min(self.first_ns, first_ns), max(self.last_ns, last_ns)

    def known(self, data: bytes, span_ns: tuple[int, int], *, is_cut: bool) -> bytes:
        """Those messages of a damaged chunk that were written: on channels declared here or in it, within its times.

        They stand behind those declarations in it that are complete.
        """
        schemas, channels, declared, runs = {0, *self.schemas}, {*self.channels}, bytearray(), [(0, 0)]
        for place in whole_records(data, span_ns, is_cut=is_cut):
            content = data[place.begin : place.end]
            with suppress(ValueError, EOFError, struct.error):
                if place.opcode == Opcode.MESSAGE:
                    channel, _, *times = MESSAGE.unpack_from(content)
                    if channel in channels and span_ns[0] <= times[0] <= span_ns[1] and max(times) <= LAST_TIME:
                        begin = runs.pop()[0] if runs[-1][1] == place.start else place.start
                        runs.append((begin, place.end))
                    continue
                record = parsed(place.opcode, content)
                own = schemas if isinstance(record, Schema) else channels
                is_channel = isinstance(record, Channel) and record.schema_id in schemas
                if (isinstance(record, Schema) or is_channel) and record.id not in own:  # what is declared is right
                    own.add(record.id)
                    declared += record_bytes(record)
        return b"".join([declared, *(memoryview(data)[begin:end] for begin, end in runs)])

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

    def groups(self) -> dict[int, list[McapRecord]]:
        """Records of the summary by their opcodes, in the order in which they are written."""
        statistics = Statistics(
            attachment_count=len(self.attachments),
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
            Opcode.ATTACHMENT_INDEX: [*self.attachments],
            Opcode.METADATA_INDEX: [*self._metadata],
        }


class SummaryCheck:
    """Places of the records of a file that is read, and its own summary, held against the one that is made of it.

    Parameters
    ----------
    found : Summary
        Made of the records of the file as they are read.
    """

    def __init__(self, found: Summary) -> None:
        self._found = found
        self._opcodes: set[int] = set()
        self._said = defaultdict[int, list[Any]](list)
        self._groups: dict[int, tuple[int, int]] = {}
        self._begin: int | None = None  # of the summary
        self._in_data = 0, 0  # schemas and channels

    def place(self, opcode: int, begin: int, end: int, record: McapRecord | None) -> None:
        """Take the next record of the file and its place; for a part with messages it is that of the whole part.

        Raises
        ------
        ContradictionError
            If it is not where records of its kind belong.
        """
        require(bool(self._opcodes) or opcode == Opcode.HEADER, "it does not begin with a header")
        allowed = _IN_DATA if self._begin is None else _IN_SUMMARY
        is_in_place = opcode in allowed or opcode > Opcode.DATA_END or not self._opcodes
        require(is_in_place, f"a record {opcode:#x} is out of place")
        self._opcodes.add(opcode)
        if self._begin is not None:
            first, before = self._groups.get(opcode, (begin, begin))
            require(before == begin, "the groups of its summary are mixed")
            self._groups[opcode] = first, end
            self._said[opcode].append(record)
        elif opcode == Opcode.DATA_END:
            self._begin, self._in_data = end, (len(self._found.schemas), len(self._found.channels))

    def finish(self, footer: Footer) -> None:
        """Hold the whole summary of the file against the one that is made of it.

        Raises
        ------
        ContradictionError
            Naming the first thing that does not fit.
        """
        require(not self._opcodes >= {Opcode.CHUNK, Opcode.MESSAGE}, "messages stand outside its chunks")
        found = self._found.groups()
        for opcode, what in _INDEXES.items():
            # an index may be left out as a whole: then readers scan
            require(
                self._said[opcode] in ([], found[opcode]), f"the index of its {what} is not that of the {what} it has"
            )
        self._hold_repeats()
        self._hold_statistics(*found[Opcode.STATISTICS])
        self._hold_places(footer)

    def _hold_repeats(self) -> None:
        """Require that a reader which believes the summary is told of every topic that has messages."""
        if not any(self._said[opcode] for opcode in (Opcode.CHUNK_INDEX, Opcode.CHANNEL, Opcode.SCHEMA)):
            return  # it reads all
        schemas = {self._found.channels[channel].schema_id for channel in self._found.counts} - {0}
        for opcode, what, used in (
            (Opcode.CHANNEL, "channel", {*self._found.counts}),
            (Opcode.SCHEMA, "schema", schemas),
        ):
            missing = used - {record.id for record in self._said[opcode]}
            require(not missing, f"its summary lacks the {what} {min(missing, default=0)} of its messages")

    def _hold_statistics(self, found: Any) -> None:
        require(len(self._said[Opcode.STATISTICS]) <= 1, "it has two records of statistics")
        for said in self._said[Opcode.STATISTICS]:
            # some writers leave out those that no message uses, which stand in the summary alone
            allowed = dict(zip(("schema_count", "channel_count"), self._in_data, strict=True))
            if not self._found.counts:
                allowed |= {name: getattr(said, name) for name in ("message_start_time", "message_end_time")}
            said.channel_message_counts = Counter(said.channel_message_counts)  # which may have some of 0
            for name, value in vars(found).items():
                told = getattr(said, name)
                require(
                    told in (value, allowed.get(name, value)),
                    f"the {name} of its statistics is {told!r:.40}, where it has {value!r:.40}",
                )

    def _hold_places(self, footer: Footer) -> None:
        groups = {opcode: (begin, end - begin) for opcode, (begin, end) in self._groups.items()}
        end, _ = groups.pop(Opcode.FOOTER)
        offsets, _ = groups.pop(Opcode.SUMMARY_OFFSET, (end, 0))
        said = self._said[Opcode.SUMMARY_OFFSET]
        told = {
            offset.group_opcode: (offset.group_start, offset.group_length) for offset in said if offset.group_length
        }
        behind = [begin for begin, _ in groups.values() if said and begin > offsets]
        require(not behind, "a group of its summary stands behind the offsets")
        require(not said or told == groups, "the offsets of its summary are not those of its groups")
        for what, place, begin, is_there in (
            ("summary begins", footer.summary_start, self._begin, end != self._begin),
            ("offsets of the summary begin", footer.summary_offset_start, offsets, bool(said)),
        ):
            require(
                place == begin or not (is_there or place),
                f"its footer says that the {what} at byte {place}, not {begin}",
            )
