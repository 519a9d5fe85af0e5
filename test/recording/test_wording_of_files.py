"""What is said of an MCAP file that contradicts itself: at which byte, what, and what to do, in one line."""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import chdir
from functools import partial
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from forged import (
    CHANNELS,
    Change,
    chunk,
    flipped,
    forged,
    framed,
    honest,
    inserted,
    joined,
    left_out,
    message,
    place,
    plain,
    record,
    text,
)
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.mcap_contents import nothing

UNDECLARED = "it has a message of channel 999, which is not declared before it"
NONE_OF_ITS_KIND = "a record that is none of its kind"
REMEDY = ": restore a copy, or record again"
NOISE = np.random.default_rng(0).bytes(1000)
SKIPPABLE = struct.pack("<II", 0x184D2A50, 4) + b"abcd"
"""A frame that decompressors leave out."""
PACK: dict[str, Callable[[bytes], bytes]] = {
    "zstd": zstandard.ZstdCompressor(write_checksum=True).compress,
    "lz4": partial(lz4.frame.compress, content_checksum=True),
}
OF_STATISTICS = {
    "message_count": 0,
    "schema_count": 8,
    "channel_count": 10,
    "attachment_count": 14,
    "metadata_count": 18,
    "chunk_count": 22,
    "message_start_time": 26,
    "message_end_time": 34,
    "channel_message_counts": 48,
}
"""Bytes where the fields begin."""


def said_of(content: bytes, folder: Path) -> str:
    """The refusal of a file, without its path, which is short, as lines are."""
    (folder / "x.mcap").write_bytes(content)
    with chdir(folder), pytest.raises(BagError) as caught:
        BagFiles("x.mcap").contents(nothing)
    return str(caught.value).removeprefix("x.mcap ")


def test_the_honest_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(joined(honest()))
    contents = BagFiles(tmp_path / "x.mcap").contents(nothing)
    assert {track.topic: track.count for track in contents.tracks.values()} == {"/x": 3, "/y": 3}
    assert (contents.attachments, contents.metadata) == (1, {"vehicle": {"name": "sat"}})
    assert [(span.count, span.first_ns, span.last_ns) for span in contents.files] == [(6, 5, 7)]
    assert contents.without_checksum == 1


RECORDS: dict[str, tuple[Change, int, str]] = {
    "no header": (left_out(Opcode.HEADER), Opcode.CHUNK, "it does not begin with a header"),
    "another profile": (
        flipped(Opcode.HEADER, 4),
        Opcode.HEADER,
        "its profile is 'sos2', that of a bag of ROS 2 is 'ros2'",
    ),
    "data in the summary": (
        inserted(Opcode.STATISTICS, Opcode.MESSAGE, message(1)[9:]),
        Opcode.MESSAGE,
        "a record 0x5 is out of place",
    ),
    "an index without a chunk": (
        lambda records: records.insert(1, records[place(records, Opcode.MESSAGE_INDEX)]),
        Opcode.MESSAGE_INDEX,
        "a record 0x7 is out of place",
    ),
    "data without an end": (left_out(Opcode.DATA_END), Opcode.STATISTICS, "a record 0xb is out of place"),
    "a checksum of the data": (
        flipped(Opcode.DATA_END, 0),
        Opcode.DATA_END,
        "the checksum of its data section is {found}, not 00000001",
    ),
    "a checksum of the summary": (
        flipped(Opcode.FOOTER, 16),
        Opcode.FOOTER,
        "the checksum of its summary is {found}, not 00000001",
    ),
    "a schema that changes": (
        flipped(Opcode.SCHEMA, 6),
        Opcode.SCHEMA,
        "it has two different records of schema 1",
    ),
    "a channel that changes": (
        flipped(Opcode.CHANNEL, 8),
        Opcode.CHANNEL,
        "it has two different records of channel 1",
    ),
    "a channel of no schema": (
        inserted(Opcode.CHUNK, Opcode.CHANNEL, struct.pack("<HH", 1, 9) + text("/x") + text("cdr") + bytes(4)),
        Opcode.CHANNEL,
        "the schema of topic /x is not declared before it",
    ),
    "mixed groups": (
        inserted(Opcode.SUMMARY_OFFSET, Opcode.STATISTICS),
        -Opcode.STATISTICS,
        "the groups of its summary are mixed",
    ),
    "messages outside": (
        inserted(Opcode.ATTACHMENT, Opcode.MESSAGE, message(1)[9:]),
        Opcode.FOOTER,
        "messages stand outside its chunks",
    ),
    "the times of a chunk": (flipped(Opcode.CHUNK, 0), Opcode.CHUNK, "the times of a chunk are (5, 7), not (4, 7)"),
    "the size of a chunk": (
        flipped(Opcode.CHUNK, 16),
        Opcode.CHUNK,
        "a chunk does not inflate to the {size} bytes that it declares",
    ),
    "the checksum of a chunk": (flipped(Opcode.CHUNK, 24), Opcode.CHUNK, "the crc of a chunk is {found}, not 00000001"),
    "a length in a chunk": (
        flipped(Opcode.CHUNK, 38),
        Opcode.CHUNK,
        "a length in a record reaches beyond its end",
    ),
    "a time in an index": (
        flipped(Opcode.MESSAGE_INDEX, 6),
        Opcode.MESSAGE_INDEX,
        "the index of channel 1 is not that of its chunk's messages",
    ),
    "a place in an index": (
        flipped(Opcode.MESSAGE_INDEX, 14),
        Opcode.MESSAGE_INDEX,
        "the index of channel 1 is not that of its chunk's messages",
    ),
    "an index of another channel": (
        flipped(Opcode.MESSAGE_INDEX, 1),
        Opcode.MESSAGE_INDEX,
        "the index of channel 257 is not that of its chunk's messages",
    ),
    "the size of an index": (
        flipped(Opcode.MESSAGE_INDEX, 5),
        Opcode.MESSAGE_INDEX,
        "the index of channel 1 is longer than its record",
    ),
    "an index twice": (
        inserted(Opcode.MESSAGE_INDEX, Opcode.MESSAGE_INDEX),
        -Opcode.MESSAGE_INDEX,
        "a chunk has two indexes of channel 1",
    ),
    "an index left out": (
        left_out(Opcode.MESSAGE_INDEX),
        Opcode.CHUNK,
        "a chunk has no index of channel 1",
    ),
    "indexes of some chunks": (
        inserted(Opcode.ATTACHMENT, Opcode.CHUNK),
        Opcode.FOOTER,
        "some chunks have indexes of their messages, and some have none",
    ),
    "the index of chunks": (
        flipped(Opcode.CHUNK_INDEX, 0),
        Opcode.FOOTER,
        "the index of its chunks is not that of the chunks it has",
    ),
    "the index of attachments": (
        flipped(Opcode.ATTACHMENT_INDEX, 0),
        Opcode.FOOTER,
        "the index of its attachments is not that of the attachments it has",
    ),
    "the index of metadata": (
        flipped(Opcode.METADATA_INDEX, 0),
        Opcode.FOOTER,
        "the index of its metadata is not that of the metadata it has",
    ),
    "statistics twice": (
        inserted(Opcode.STATISTICS, Opcode.STATISTICS),
        Opcode.FOOTER,
        "it has two records of statistics",
    ),
    **{
        name: (flipped(Opcode.STATISTICS, at), Opcode.FOOTER, f"the {name} of its statistics is ")
        for name, at in OF_STATISTICS.items()
    },
    "the offsets": (
        flipped(Opcode.SUMMARY_OFFSET, 1),
        Opcode.FOOTER,
        "the offsets of its summary are not those of its groups",
    ),
    "a group behind the offsets": (
        lambda records: records.insert(-1, records.pop(place(records, Opcode.STATISTICS))),
        Opcode.FOOTER,
        "a group of its summary stands behind the offsets",
    ),
    "the footer, size": (  # of which readers take the last 29 bytes, and this one took the first
        lambda records: records.append((Opcode.FOOTER, records.pop()[1] + record(Opcode.FOOTER, bytes(20)))),
        Opcode.FOOTER,
        "its footer has 49 bytes, not 20",
    ),
    "the footer, summary": (
        flipped(Opcode.FOOTER, 0),
        Opcode.FOOTER,
        "its footer says that the summary begins at byte ",
    ),
    "the footer, offsets": (
        flipped(Opcode.FOOTER, 8),
        Opcode.FOOTER,
        "its footer says that the offsets of the summary begin at byte ",
    ),
}
"""Changes, kind of the record at which each is told (the second of its kind, if negative), and what is said."""


@pytest.mark.parametrize("case", RECORDS)
def test_a_record_that_is_not_as_others_say_is_refused_at_its_byte(tmp_path: Path, case: str) -> None:
    change, opcode, words = RECORDS[case]
    records = honest()
    change(records)
    number = place(records, abs(opcode))
    number += opcode < 0 and 1 + place(records[number + 1 :], -opcode)
    at = len(joined(records[:number])) - len(MAGIC)
    said, before, behind = said_of(joined(records), tmp_path), *words.partition("{")[::2]
    assert said.startswith(f"is damaged at byte {at}: {before}")
    assert said.endswith(behind.partition("}")[2] + REMEDY)


def frames(name: str) -> dict[str, tuple[bytes, str]]:
    """Chunks that are not one frame of a compression, and what is said of each."""
    pack = PACK[name]
    data = {
        "bytes behind": (pack(NOISE) + b"garbage", f"a chunk has 7 bytes behind its frame of {name}"),
        "the same again": (2 * pack(NOISE), f"a chunk has several frames of {name}, of which readers take one"),
        "two halves": (
            pack(NOISE[:500]) + pack(NOISE[500:]),
            f"a chunk has several frames of {name}, of which readers take one",
        ),
        "skippable first": (SKIPPABLE + pack(NOISE), f"a chunk does not begin with a frame of {name}"),
        "skippable last": (pack(NOISE) + SKIPPABLE, f"a chunk has 12 bytes behind its frame of {name}"),
        "no end": (pack(NOISE)[:-1], f"the {name} frame of a chunk has no end"),
        "damaged": (pack(NOISE)[:20] + bytes(900), "a chunk does not inflate to the 1000 bytes that it declares"),
    }
    return {f"{name}, {case}": (chunk(name, 1000, packed), words) for case, (packed, words) in data.items()}


CHANNEL = record(Opcode.CHANNEL, struct.pack("<HH", 1, 0) + text("/x") + text("cdr") + bytes(4))
CHUNKS: dict[str, tuple[bytes, str]] = {
    **frames("zstd"),
    **frames("lz4"),
    **{
        f"size {size}, {name or 'plain'}": (
            chunk(name, size, pack(bytes(1000))),
            f"a chunk does not inflate to the {size} bytes that it declares",
        )
        for name, pack in {"": bytes, **PACK}.items()
        for size in (0, 999, 1001, 10_000)
    },
    "a message of no channel": (plain(message(999)), UNDECLARED),
    "a message of no channel, in no chunk": (message(999), UNDECLARED),
    **{
        f"kind {kind}": (plain(record(kind, b"")), f"a record of kind {kind:#04x} in a chunk")
        for kind in (1, 2, 9, 15, 200)
    },
    "a chunk in a chunk": (plain(plain()), "a record of kind 0x06 in a chunk"),
    **{
        f"a channel and {case}": (
            plain(record(Opcode.CHANNEL, struct.pack("<HH", 1, 0) + text("/x") + text("cdr") + behind)),
            words,
        )
        for case, behind, words in (
            ("a message", bytes(4) + message(1), "a definition in a chunk is longer than its fields"),
            (
                "one name twice",
                struct.pack("<I", 20) + 2 * (text("a") + text("b")),
                "the metadata of a channel have another length than is said",
            ),
        )
    },
    "a channel behind its message": (  # of which readers that do not seek know nothing yet
        plain(message(1, time=0), CHANNEL),
        "a channel is declared behind its first message",
    ),
    "a name that is no text": (
        record(Opcode.SCHEMA, struct.pack("<HI", 1, 1) + b"\xf5" + text("ros2msg") + text("")),
        NONE_OF_ITS_KIND,
    ),
    "a short message": (plain(record(5, bytes(21))), "a message record is too short"),
    "zeros": (plain(bytes(9)), "no record that ends in its chunk stands at byte 0 of it"),
    "an unfinished record": (
        plain(record(3, b""), record(3, b"x")[:-1]),
        "no record that ends in its chunk stands at byte 9 of it",
    ),
    "an unfinished head": (plain(b"\5"), "no record that ends in its chunk stands at byte 0 of it"),
    "a late time": (
        plain(CHANNEL, message(1, time=2**63)),
        f"the log_time of a message is {2**63} ns, beyond {2**63 - 1}",
    ),
}
"""Records at byte 37, where the first behind the header begins, and what is said of each."""


@pytest.mark.parametrize("case", CHUNKS)
def test_a_chunk_is_refused_at_its_byte(tmp_path: Path, case: str) -> None:
    content, words = CHUNKS[case]
    assert said_of(framed(content), tmp_path) == f"is damaged at byte 37: {words}{REMEDY}"


def test_two_encodings_of_a_topic_are_refused(tmp_path: Path) -> None:
    channels = [
        record(Opcode.CHANNEL, struct.pack("<HH", number, 0) + text("/x") + text(encoding) + bytes(4))
        for number, encoding in zip(CHANNELS, ("cdr", "json"), strict=True)
    ]
    first, second = plain(*channels, message(1, time=0)), plain(message(2, time=0))
    at = 37 + len(first)
    words = "topic /x has messages of two encodings or definitions"
    assert said_of(framed(first, second), tmp_path) == f"is damaged at byte {at}: {words}{REMEDY}"


OTHERS = {
    "an unknown compression": (
        framed(chunk("brotli", 9, b"packed")),
        "is compressed with 'brotli', which is unknown here: rewrite it with 'mcap compress'",
    ),
    "a large chunk": (
        framed(chunk("zstd", 2**29, b"")),
        f"has at byte 37 a chunk of {2**29} bytes, more than is read: record it again",
    ),
    "many records": (
        framed(chunk("zstd", 9 * 10**5, zstandard.compress(record(3, b"") * 10**5))),
        "has at byte 37 too many records in chunks for its size, more than is read: record it again",
    ),
    "half a row of an index": (
        framed(plain(CHANNEL) + record(Opcode.MESSAGE_INDEX, struct.pack("<HI", 1, 8) + bytes(8))),
        f"is damaged at byte {37 + len(plain(CHANNEL))}: {NONE_OF_ITS_KIND}{REMEDY}",
    ),
    "a record beyond the end": (
        framed(struct.pack("<BQ", 4, 2**63)),
        f"is damaged at byte 37: a record is longer than the file{REMEDY}",
    ),
    "no end": (
        forged(lambda records: records.pop())[: -len(MAGIC)],
        "was cut off, or is still being written: it holds at least 6 whole messages: rescue them with "
        "'lie-rigid-body recover BROKEN -o FIXED'",
    ),
    "no messages and no end": (
        framed()[:40],
        "was cut off, or is still being written: it may hold whole messages: rescue them with "
        "'lie-rigid-body recover BROKEN -o FIXED'",
    ),
    "nothing": (b"", "is empty: record it again, it holds nothing to rescue"),
    "text": (b"hello", "is not an MCAP file: it does not begin as one: give a bag"),
    "the beginning of a beginning": (MAGIC[:-1], "is not an MCAP file: it does not begin as one: give a bag"),
    "ROS 1": (b"#ROSBAG V2.0\n", "is not an MCAP file: it is a ROS 1 bag: convert it with 'mcap convert'"),
    "SQLite": (
        b"SQLite format 3\x00...",
        "is not an MCAP file: it is an SQLite bag: convert it with 'ros2 bag convert', or record in MCAP, "
        "the default of Jazzy",
    ),
    "zstd": (
        zstandard.compress(framed()),
        "is not an MCAP file: it is zstd-compressed as a whole: unpack it with 'unzstd'",
    ),
}


@pytest.mark.parametrize("case", OTHERS)
def test_other_files_are_refused_with_a_remedy(tmp_path: Path, case: str) -> None:
    content, words = OTHERS[case]
    assert said_of(content, tmp_path) == words
