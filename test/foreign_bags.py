"""Bags as other programs write them: the messages of a bag, which a test changes, and files of messages."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Iterator
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import mcap.records
import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, Writer

from lie_rigid_body.messages import Decoded, decode_places

PLAIN = CompressionType.NONE


class Message(NamedTuple):
    """A message as the `mcap` library reads it; those of one topic and another publisher are on another channel."""

    topic: str
    kind: str
    definition: bytes
    log_time: int
    publish_time: int
    data: bytes
    publisher: int = 0


def messages_of(bag: Path | bytes) -> list[Message]:
    """Messages of a whole file in their order; of the same files again they are kept."""
    return _read(bag) if isinstance(bag, bytes) else [*_kept(bag.read_bytes())]


@lru_cache(maxsize=4)
def _kept(content: bytes) -> list[Message]:
    return _read(content)


def _read(content: bytes) -> list[Message]:
    """Messages by the library's records; it takes none for longer than its fields, so their framing is done here."""
    schemas, channels, found = {0: Schema(0, b"", "", "")}, dict[int, Channel](), list[Message]()
    for opcode, data in _records_with_messages(content):
        stream = ReadDataStream(BytesIO(data))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            channels[channel.id] = channel
        elif opcode == Opcode.MESSAGE:
            one = mcap.records.Message.read(stream, len(data))
            channel = channels[one.channel_id]
            schema = schemas[channel.schema_id]
            times = one.log_time, one.publish_time
            found.append(Message(channel.topic, schema.name, schema.data, *times, one.data))
    return found


def _records_with_messages(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Records of the data section, and those in its chunks; what follows are hints."""
    for opcode, data in records_of(content):
        if opcode == Opcode.DATA_END:
            return
        if opcode == Opcode.CHUNK:
            chunk = Chunk.read(ReadDataStream(BytesIO(data)))
            stream, size = get_chunk_data_stream(chunk, validate_crc=True)
            yield from records_of(MAGIC + stream.read(size) + MAGIC)
        else:
            yield opcode, data


def bag_of(
    messages: Iterable[Message],
    library: str = "another recorder",
    *,
    topics: Iterable[tuple[str, str]] = (),
    encoding: str = "cdr",
    samples: int | None = None,
    **options: Any,
) -> bytes:
    """A file of messages by the writer of the `mcap` library.

    Parameters
    ----------
    messages : iterable of Message
    library : str, optional
        Who says to have written it.
    topics : iterable of (str, str), optional
        Topics and types that are declared whether they have messages or not.
    encoding : str, optional
    samples : int, optional
        Number of samples that the file says it has, as those of this package do.
    **options
        Those of the writer.
    """
    out = BytesIO()
    writer, channels = Writer(out, **options), dict[tuple[str, str, int], int]()
    writer.start("ros2", library)
    for topic, kind in topics:
        writer.register_channel(topic, encoding, writer.register_schema(kind, "ros2msg", b""))
    for count, (topic, kind, definition, log_time, publish_time, data, publisher) in enumerate(messages):
        key = topic, kind, publisher
        if key not in channels:
            schema = writer.register_schema(kind, "ros2msg", definition) if kind else 0
            metadata = {"publisher": str(publisher)}
            channels[key] = writer.register_channel(topic, encoding, schema, metadata)
        writer.add_message(channels[key], log_time % 2**64, data, publish_time % 2**64, count)
    if samples is not None:
        writer.add_metadata("lie_rigid_body", {"samples": str(samples)})
    writer.finish()
    return out.getvalue()


def laid_out(messages: Iterable[Message], library: str, chunk_size: int = 2**20) -> bytes:
    """A file of messages in plain chunks, without a summary: the writer of the library takes five times as long."""
    body = [MAGIC, record(Opcode.HEADER, text("ros2") + text(library))]
    channels: dict[tuple[str, str], int] = {}
    chunk = bytearray()
    index: dict[int, list[int]] = {}
    for count, (topic, kind, definition, log_time, publish_time, data, _) in enumerate(messages):
        number = channels.get((topic, kind), len(channels) + 1)
        if number > len(channels):
            channels[topic, kind] = number
            chunk += record(Opcode.SCHEMA, struct.pack("<H", number) + text(kind) + text("ros2msg") + sized(definition))
            chunk += record(Opcode.CHANNEL, struct.pack("<HH", number, number) + text(topic) + text("cdr") + bytes(4))
        index.setdefault(number, []).extend((log_time, len(chunk)))
        chunk += struct.pack("<BQHIQQ", 5, 22 + len(data), number, count, log_time, publish_time) + data
        if len(chunk) > chunk_size:
            body += indexed(chunk, index)
            chunk, index = bytearray(), {}
    content = b"".join([*body, *indexed(chunk, index)])
    end = record(Opcode.DATA_END, struct.pack("<I", zlib.crc32(content)))
    return content + end + record(Opcode.FOOTER, bytes(20)) + MAGIC


def indexed(data: bytes | bytearray, index: dict[int, list[int]]) -> Iterator[bytes]:
    """A chunk of records, not compressed, and where the messages of each channel are: their times and places."""
    head = struct.pack("<QQQI", 0, 0, len(data), zlib.crc32(data)) + text("") + struct.pack("<Q", len(data))
    yield record(Opcode.CHUNK, head + data)
    for number, places in index.items():
        yield record(Opcode.MESSAGE_INDEX, struct.pack("<H", number) + sized(struct.pack(f"<{len(places)}Q", *places)))


def record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def records_of(content: bytes) -> list[tuple[int, bytes]]:
    """Opcodes and contents of the records of a file, as far as they have a head."""
    at, found = len(MAGIC), list[tuple[int, bytes]]()
    while at + 9 <= len(content) - len(MAGIC):
        opcode, length = struct.unpack_from("<BQ", content, at)
        found.append((opcode, content[at + 9 : at + 9 + length]))
        at += 9 + length
    return found


def file_of(records: Iterable[tuple[int, bytes]]) -> bytes:
    """A file of records."""
    return MAGIC + b"".join(record(*one) for one in records) + MAGIC


def sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def text(value: str) -> bytes:
    return sized(value.encode())


def decode(payloads: Iterable[bytes], numbers: int, *, stamped: bool) -> Decoded:
    """The float64 numbers of messages."""
    payloads = list(payloads)
    sizes = np.array([len(payload) for payload in payloads], dtype=np.int64)
    ends = np.cumsum(sizes)
    return decode_places(b"".join(payloads), ends - sizes, ends, numbers, stamped=stamped)
