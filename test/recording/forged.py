"""Forged MCAP files: the records of an honest one, changed, left out or put in, and such as no writer makes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, Writer

from foreign_bags import file_of, record, records_of, text

Record = tuple[int, bytes]
Change = Callable[[list[Record]], object]
CHANNELS = (1, 2)


def message(channel: int, payload: bytes = b"payload", time: int = 7) -> bytes:
    return record(Opcode.MESSAGE, struct.pack("<HIQQ", channel, 0, time, time) + payload)


def chunk(compression: str, size: int, data: bytes) -> bytes:
    head = struct.pack("<QQQI", 0, 0, size, 0) + text(compression) + struct.pack("<Q", len(data))
    return record(Opcode.CHUNK, head + data)


def plain(*inner: bytes) -> bytes:
    """A chunk of some records, not compressed."""
    data = b"".join(inner)
    return chunk("", len(data), data)


def framed(*records: bytes) -> bytes:
    """A file of some records, the first at byte 37."""
    head = record(Opcode.HEADER, text("ros2") + text("a forger"))
    end = record(Opcode.DATA_END, bytes(4)) + record(Opcode.FOOTER, bytes(20))
    return MAGIC + head + b"".join(records) + end + MAGIC


def honest() -> list[Record]:
    """Records of a file with everything that a file may have, without checksums."""
    stream = BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE, enable_crcs=False)
    writer.start("ros2", "a forger")
    schema = writer.register_schema("a/msg/B", "ros2msg", b"int8 a")
    channels = [writer.register_channel(f"/{name}", "cdr", schema) for name in "xy"]
    assert channels == [*CHANNELS]
    for time in (5, 6, 7):
        for channel in channels:
            writer.add_message(channel, time, b"payload", time)
    writer.flush()
    writer.add_attachment(1, 2, "calibration", "text/plain", b"anything")
    writer.add_metadata("vehicle", {"name": "sat"})
    writer.finish()
    return records_of(stream.getvalue())


def forged(change: Change) -> bytes:
    """The honest file after a change to the list of its records."""
    records = honest()
    change(records)
    return file_of(records)


def place(records: list[Record], opcode: int) -> int:
    """Number of the first record of a kind."""
    return next(i for i, (each, _) in enumerate(records) if each == opcode)


def flipped(opcode: int, at: int) -> Change:
    """A bit of the first record of a kind is flipped."""

    def change(records: list[Record]) -> None:
        i = place(records, opcode)
        content = bytearray(records[i][1])
        content[at] ^= 1
        records[i] = opcode, bytes(content)

    return change


def inserted(before: int, opcode: int, content: bytes | None = None) -> Change:
    """A record is put in before the first of a kind; without content it is a copy of the first of its own kind."""

    def change(records: list[Record]) -> None:
        copied = content if content is not None else records[place(records, opcode)][1]
        records.insert(place(records, before), (opcode, copied))

    return change


def left_out(opcode: int) -> Change:
    """The first record of a kind is left out."""
    return lambda records: records.pop(place(records, opcode))
