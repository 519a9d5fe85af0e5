"""One field of a bag altered, by a forger who leaves no checksum and keeps all else in order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import McapRecord
from mcap.writer import CompressionType, Writer

from lie_rigid_body import __version__

Payloads = Callable[[str, bytes], bytes]


def copy(
    source: Path,
    target: Path,
    change: Payloads = lambda topic, data: data,
    compression: CompressionType = CompressionType.NONE,
    last: int | None = None,
    count: int | None = None,
) -> Path:
    """Copy a bag as if this package had written it, with other payloads, without checksums, with an attachment.

    Parameters
    ----------
    source, target : Path
    change : callable, optional
        Of a topic and a payload: the payload to write.
    compression : CompressionType, optional
    last : int, optional
        The latest log time, ns, of what is copied.
    count : int, optional
        How many samples the writer says it wrote; by default as many as it did.
    """
    with source.open("rb") as stream, target.open("wb") as out:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        writer = Writer(out, compression=compression, enable_crcs=False)
        writer.start("ros2", f"lie_rigid_body {__version__}")
        channels = {}
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            number = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, "cdr", number, channel.metadata)
        samples = 0
        for _, channel, message in reader.iter_messages(log_time_order=False):
            if last is not None and message.log_time > last:
                continue
            samples += channel.topic == "/pose"
            data = change(channel.topic, message.data)
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time, message.sequence)
        writer.add_metadata("lie_rigid_body", {"samples": str(samples if count is None else count)})
        writer.add_attachment(0, 0, "photo", "image/png", b"pixels")
        writer.finish()
    return target


def _records(data: bytes, at: int, end: int) -> list[tuple[int, int, int]]:
    """Opcode, and begin and end of the content, of each record between two bytes."""
    found = []
    while at < end:
        length = int.from_bytes(data[at + 1 : at + 9], "little")
        found.append((data[at], at + 9, at + 9 + length))
        if data[at] == Opcode.CHUNK:
            begin = at + 9 + 32  # of a chunk without compression
            end_of_chunk = at + 9 + length
            found += _records(data, begin + 8, end_of_chunk) if data[begin - 4 : begin] == bytes(4) else []
        at += 9 + length
    return found


def forge(path: Path, **kinds: Callable[[Any], dict[str, object]]) -> Path:
    """Alter every record of some kinds, in the data section and where it is repeated; all lengths must stay.

    Parameters
    ----------
    path : Path
        A bag by `copy`, which is changed.
    **kinds : callable
        By name of the record: what to change in one, by field; nothing leaves it as it is.
    """
    data = bytearray(path.read_bytes())
    for opcode, begin, end in _records(bytes(data), 8, len(data) - 8):
        for kind in McapRecord.__subclasses__():
            if kind.__name__ in kinds and opcode == Opcode[_opcode_name(kind)]:
                altered = _altered(kind, bytes(data[begin:end]), kinds[kind.__name__])
                assert len(altered) == end - begin
                data[begin:end] = altered
    path.write_bytes(data)
    return path


def _opcode_name(kind: type) -> str:
    return "".join(f"_{c}" if c.isupper() else c for c in kind.__name__).strip("_").upper()


def _altered(kind: Any, content: bytes, change: Callable[[Any], dict[str, object]]) -> bytes:
    stream = ReadDataStream(BytesIO(content))
    record = kind.read(stream, len(content)) if kind.__name__ == "Message" else kind.read(stream)
    changed = change(record)
    if not changed:
        return content
    assert set(changed) <= {field.name for field in fields(kind)}
    builder = RecordBuilder()
    replace(record, **changed).write(builder)
    return bytes(builder.end())[9:]
