"""Files that were cut anywhere: each message that is whole in them is recovered, and none that is not."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterator
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from bags import COMPRESSIONS
from lz4.frame import LZ4FrameDecompressor
from mcap.opcode import Opcode
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, Message, Schema
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, IndexType, Writer
from refused_bags import refused

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.inflation import salvaged
from lie_rigid_body.recording.mcap_contents import McapContents
from lie_rigid_body.recording.mcap_reader import read_file
from lie_rigid_body.recording.records import FileBytes, record_bytes
from lie_rigid_body.recording.recovery import NothingWholeError, recover
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from sampled import sampled

Found = tuple[str, int, int, bytes]
COUNT = 120
CHUNK = 9000
RECORD = struct.Struct("<BQ")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A bag of each compression, of some chunks."""
    folder = tmp_path_factory.mktemp("whole")
    scenario = Scenario.from_parameters({"motion": "closed_form", "rate": 50.0, "imu_rate": 20.0})
    for compression in COMPRESSIONS:
        simulation = Simulation(scenario)
        path = folder / f"{compression}.mcap"
        with BagWriter(path, stamped_twist=True, chunk_size=CHUNK, compression=compression) as bag:
            bag.begin_segment(simulation.segment)
            end = simulation.clock.stamp_ns(COUNT - 1)
            bag.write(BatchEncoder(scenario).encode(simulation.take_until(end, COUNT)))
    return {compression: folder / f"{compression}.mcap" for compression in COMPRESSIONS}


def messages(path: Path) -> list[Found]:
    """All messages in file order, by the `mcap` library, with every checksum compared."""
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        found = [
            (channel.topic, message.log_time, message.sequence, message.data)
            for _, channel, message in reader.iter_messages(log_time_order=False)
        ]
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(found)
    counts: dict[str, int] = {}
    for topic, *_ in found:
        counts[topic] = counts.get(topic, 0) + 1
    named = {summary.channels[key].topic: count for key, count in summary.statistics.channel_message_counts.items()}
    assert named == counts
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (
        min(time for _, time, *_ in found),
        max(time for _, time, *_ in found),
    )
    return found


def records(content: bytes | bytearray) -> Iterator[tuple[int, int, int]]:
    """Opcode, begin and end of each record of a file."""
    begin = 8
    while begin < len(content) - 8:
        opcode, length = RECORD.unpack_from(content, begin)
        yield opcode, begin, begin + RECORD.size + length
        begin += RECORD.size + length


def count_messages(data: bytes) -> int:
    count, begin = 0, 0
    while begin + RECORD.size <= len(data):
        opcode, length = RECORD.unpack_from(data, begin)
        begin += RECORD.size + length
        count += opcode == Opcode.MESSAGE and begin <= len(data)
    return count


def unpacked(compression: str, data: bytes) -> bytes:
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    return LZ4FrameDecompressor().decompress(data) if compression else data


def whole_in(content: bytes, size: int, compression: str) -> int:
    """How many messages are whole in the first bytes of a file, by another way."""
    count = 0
    for opcode, begin, end in records(content):
        if opcode == Opcode.CHUNK:
            data = begin + RECORD.size + 32 + len(compression) + 8
            if size > data:
                count += count_messages(unpacked(compression, content[data : min(end, size)]))
    return count


def cut(content: bytes, size: int, folder: Path) -> int:
    """Recover a file of which only the first bytes are left; return how many messages that gave."""
    broken, fixed = folder / "broken.mcap", folder / "fixed.mcap"
    broken.write_bytes(content[:size])
    try:
        recovery = recover(broken, fixed, overwrite=True)
    except BagError:
        return 0
    assert broken.read_bytes() == content[:size]
    assert (recovery.broken_at is None) == (size == len(content))
    assert recovery.broken_at is None or recovery.broken_at <= size
    assert recovery.damaged == ()
    return recovery.messages


def structural(content: bytes, step: int) -> list[int]:
    """Sizes at, before and after every boundary of the file's structure."""
    edges = {0, 8, len(content)} | {edge for _, begin, end in records(content) for edge in (begin, begin + 9, end)}
    sizes = sorted({edge + d for edge in edges for d in (-1, 0, 1) if 0 <= edge + d <= len(content)})
    return [*sizes[::step], len(content)]


def cuts_recover_what_is_whole(path: Path, compression: str, sizes: list[int], folder: Path) -> None:
    content, everything = path.read_bytes(), messages(path)
    for size in sizes:
        found = cut(content, size, folder)
        assert found == whole_in(content, size, compression), size
        if found:
            assert messages(folder / "fixed.mcap") == everything[:found], size


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_every_whole_message_of_a_cut_file_is_recovered(
    whole: dict[str, Path], tmp_path: Path, compression: str
) -> None:
    content = whole[compression].read_bytes()
    sizes = [*structural(content, 11), *np.random.default_rng(7).integers(0, len(content), 15).tolist()]
    cuts_recover_what_is_whole(whole[compression], compression, sizes, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_cuts_at_every_boundary_and_at_1000_random_places(
    whole: dict[str, Path], tmp_path: Path, compression: str
) -> None:
    content = whole[compression].read_bytes()
    sizes = [*structural(content, 1), *np.random.default_rng(8).integers(0, len(content), 1000).tolist()]
    cuts_recover_what_is_whole(whole[compression], compression, sizes, tmp_path)


@pytest.mark.parametrize("rest", [b"\0" * 500, b"\xff" * 500, b"\x05" * 500, bytes([5, 200, 0, 0, 0, 0, 1, 0]) * 60])
def test_what_a_disk_without_power_leaves_behind_a_cut_is_no_content(
    whole: dict[str, Path], tmp_path: Path, rest: bytes
) -> None:
    """A message that reaches into it is not filled up with it; the last one before it may be left out."""
    content, everything = whole[""].read_bytes(), messages(whole[""])
    broken, fixed, compared = tmp_path / "broken.mcap", tmp_path / "fixed.mcap", 0
    for size in np.random.default_rng(9).integers(len(content) // 4, len(content) // 2, 60).tolist():
        broken.write_bytes(content[:size] + rest)
        recovery = recover(broken, fixed, overwrite=True)
        assert messages(fixed) == everything[: recovery.messages], size
        if not recovery.damaged:  # else it reaches to the end of the chunk, whose checksum is then another
            compared += 1
            assert whole_in(content, size, "") - recovery.messages in (0, 1), size
    assert compared > 20


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("part", [0.3, 0.71, 0.95])
def test_what_is_recovered_is_certified(whole: dict[str, Path], tmp_path: Path, compression: str, part: float) -> None:
    content = whole[compression].read_bytes()
    assert cut(content, int(part * len(content)), tmp_path) > 10
    assert certify(read_bag(tmp_path / "fixed.mcap")).passed


def test_a_whole_file_stays_what_it_is(whole: dict[str, Path], tmp_path: Path) -> None:
    for compression, path in whole.items():
        content = path.read_bytes()
        cut(content, len(content), tmp_path)
        assert (tmp_path / "fixed.mcap").read_bytes() == content, compression


def test_a_damaged_chunk_is_left_out_and_told(whole: dict[str, Path], tmp_path: Path) -> None:
    content = bytearray(whole["zstd"].read_bytes())
    chunks = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK]
    content[chunks[1] + 100] ^= 1
    (tmp_path / "broken.mcap").write_bytes(content)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.broken_at, recovery.damaged) == (None, (chunks[1],))
    kept = messages(tmp_path / "fixed.mcap")
    everything = messages(whole["zstd"])
    assert len(kept) < len(everything)
    assert set(kept) < set(everything)


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_of_two_frames_is_written_anew_and_told(tmp_path: Path, compression: str) -> None:
    pack = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}[compression]
    channel = Channel(id=1, topic="/x", message_encoding="cdr", metadata={}, schema_id=0)
    head = record_bytes(Header(profile="ros2", library="another recorder"), channel)
    halves = [record_bytes(Message(1, number, b"data", number, 0)) for number in (5, 6)]
    for behind in (pack(halves[1]), pack(halves[1]) + b"garbage"):
        chunk = Chunk(compression, pack(halves[0]) + behind, 6, 5, 0, len(b"".join(halves)))
        (tmp_path / "broken.mcap").write_bytes(MAGIC + head + record_bytes(chunk))
        recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
        assert (recovery.messages, recovery.damaged, recovery.rewritten) == (2, (), (len(MAGIC + head),))
        assert [found[1] for found in messages(tmp_path / "fixed.mcap")] == [5, 6]


@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_other_recorders_are_recovered(whole: dict[str, Path], tmp_path: Path, chunked: bool) -> None:
    """Also where messages are in no chunk, and with what else a file may hold."""
    path = tmp_path / "other.mcap"
    with open(path, "wb") as out:
        writer = Writer(out, use_chunking=chunked, chunk_size=2000)
        writer.start("ros2", "another recorder")
        writer.add_attachment(1, 2, "calibration", "text/plain", b"anything")
        writer.add_metadata("vehicle", {"name": "sat"})
        channel = writer.register_channel("/log", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"int8 a"))
        for k in range(200):
            writer.add_message(channel, 1000 * k, bytes([k] * 50), 1000 * k, k)
        writer.finish()
    content = path.read_bytes()
    begins = [begin for opcode, begin, _ in records(content) if opcode in (Opcode.CHUNK, Opcode.MESSAGE)]
    assert 40 < cut(content, begins[len(begins) // 2] + 30, tmp_path) < 160
    with open(tmp_path / "fixed.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert [one.name for one in reader.iter_attachments()] == ["calibration"]
        assert [one.name for one in reader.iter_metadata()] == ["vehicle", "lie_rigid_body_cut_off"]
        assert [message.sequence for _, _, message in reader.iter_messages()][:3] == [0, 1, 2]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_definitions_in_a_damaged_chunk_are_taken_from_the_summary(
    whole: dict[str, Path], tmp_path: Path, compression: str
) -> None:
    """The chunks behind the first lack them; a bag that is cut off has them nowhere else."""
    content = bytearray(whole[compression].read_bytes())
    first, second, *_ = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK]
    content[(first + second) // 2] ^= 1
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    broken.write_bytes(content)
    recovery = recover(broken, fixed, overwrite=False)
    lost = whole_in(whole[compression].read_bytes(), second, compression)
    assert (recovery.broken_at, recovery.damaged) == (None, (first,))
    assert messages(fixed) == messages(whole[compression])[lost:]
    assert sum(size for size, _ in read_file(fixed, McapContents())) > 0
    broken.write_bytes(content[: len(content) // 2])
    with refused("no definitions"):
        recover(broken, fixed, overwrite=True)


def test_a_topic_whose_definition_is_lost_costs_no_other_a_message(tmp_path: Path) -> None:
    """A chunk may hold messages of a topic of which nothing tells any more, beside others, and declare topics."""
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    first, late = (Channel(id=k, topic=f"/{k}", message_encoding="cdr", metadata={}, schema_id=0) for k in (1, 2))
    first_one, late_one = (record_bytes(Message(k, 5, b"data", 5, 0)) for k in (1, 2))
    third = record_bytes(Channel(id=3, topic="/3", message_encoding="cdr", metadata={}, schema_id=0))
    parts = (first_one + record_bytes(late) + late_one, late_one, third + record_bytes(Message(3, 5, b"data", 5, 0)))
    chunks = [record_bytes(Chunk("", part, 5, 5, 0, len(part))) for part in parts]
    damaged = record_bytes(Chunk("zstd", record_bytes(first) + first_one, 5, 5, 0, 99))
    (tmp_path / "broken.mcap").write_bytes(MAGIC + head + damaged + b"".join(chunks))
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.topics, len(recovery.damaged)) == (3, 2, 2)
    assert sum(size for size, _ in read_file(tmp_path / "fixed.mcap", McapContents())) > 0


def test_a_topic_whose_type_is_lost_costs_no_other_a_message(tmp_path: Path) -> None:
    """A channel may stand in another chunk than its schema."""
    types = [Schema(id=k, name=f"a/msg/{k}", encoding="ros2msg", data=b"int8 a") for k in (1, 2)]
    topics = [Channel(id=k, topic=f"/{k}", message_encoding="cdr", metadata={}, schema_id=k) for k in (1, 2)]
    ones = [record_bytes(Message(k, 5, b"data", 5, 0)) for k in (1, 2)]
    part = record_bytes(types[1], *topics[1:]) + ones[1] + record_bytes(topics[0]) + ones[0]
    chunks = [Chunk("lz4", record_bytes(types[0]), 5, 5, 0, 99), Chunk("", part, 5, 5, 0, len(part))]
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    (tmp_path / "broken.mcap").write_bytes(MAGIC + head + record_bytes(*chunks))
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.topics, len(recovery.damaged)) == (1, 1, 2)
    with (tmp_path / "fixed.mcap").open("rb") as stream:
        assert [channel.topic for _, channel, _ in make_reader(stream).iter_messages()] == ["/2"]


def test_a_definition_behind_its_messages_costs_none(tmp_path: Path) -> None:
    """Every reader takes what is recovered, also of a chunk that a reader which does not seek refuses."""
    topic = Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0)
    part = record_bytes(Message(1, 5, b"data", 5, 0), topic)
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    (tmp_path / "broken.mcap").write_bytes(MAGIC + head + record_bytes(Chunk("", part, 5, 5, 0, len(part))))
    assert recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False).messages == 1
    with (tmp_path / "fixed.mcap").open("rb") as stream:
        assert len([*NonSeekingReader(stream).iter_messages()]) == 1


ODD = {
    "of a private kind": lambda content: bytes([0x85]) + content[1:],
    "of a kind that has no place": lambda content: bytes([9]) + content[1:],
    "logged beyond all times": lambda content: content[:22] + b"\x80" + content[23:],
    "published beyond all times": lambda content: content[:30] + b"\x80" + content[31:],
    "on a channel that nothing declares": lambda content: content[:9] + b"\x4d" + content[10:],
    "too short to be one": lambda content: record_bytes(Message(1, 0, b"", 0, 0))[:1] + RECORD.pack(0, 3)[1:] + b"abc",
}
"""Changes of the record of a message."""


@pytest.mark.parametrize("case", ODD)
def test_an_odd_record_in_a_chunk_without_checksum_costs_itself(tmp_path: Path, case: str) -> None:
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    topic = record_bytes(Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0))
    ones = [record_bytes(Message(1, time, b"data", time, 0)) for time in range(5, 15)]
    ones[4] = ODD[case](ones[4])
    data = topic + b"".join(ones)
    content = MAGIC + head + record_bytes(Chunk("", data, 14, 5, 0, len(data)), DataEnd(0), Footer(0, 0, 0)) + MAGIC
    (tmp_path / "broken.mcap").write_bytes(content)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.damaged) == (9, (len(MAGIC + head),))


def test_a_message_that_is_logged_outside_of_its_chunk_is_told(tmp_path: Path) -> None:
    """Neither it nor the head of the chunk stands under a checksum: one of them is altered."""
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    topic = record_bytes(Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0))
    data = topic + b"".join(record_bytes(Message(1, time, b"data", time, 0)) for time in (5, 0, 7))
    content = MAGIC + head + record_bytes(Chunk("", data, 7, 5, 0, len(data)), DataEnd(0), Footer(0, 0, 0)) + MAGIC
    (tmp_path / "broken.mcap").write_bytes(content)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.damaged, recovery.is_altered) == (3, (), True)


@pytest.mark.parametrize("has_summary", [True, False])
def test_a_chunk_of_definitions_alone_is_kept(tmp_path: Path, has_summary: bool) -> None:
    topic = record_bytes(Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0))
    ones = b"".join(record_bytes(Message(1, time, b"data", time, 0)) for time in range(5, 15))
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    chunks = record_bytes(Chunk("", topic, 0, 0, 0, len(topic)), Chunk("", ones, 14, 5, 0, len(ones)))
    end = record_bytes(DataEnd(0)), record_bytes(Footer(0, 0, 0)) + MAGIC
    data = MAGIC + head + chunks + end[0]
    summary = topic + record_bytes(Footer(len(data), 0, 0)) + MAGIC if has_summary else end[1]
    (tmp_path / "broken.mcap").write_bytes(data + summary)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.damaged, recovery.is_altered) == (10, (), False)
    assert len(messages(tmp_path / "fixed.mcap")) == 10


def test_a_damaged_definition_in_a_chunk_is_none_beside_that_in_the_summary(tmp_path: Path) -> None:
    right, wrong = (Schema(id=1, name="a/msg/B", encoding="ros2msg", data=text) for text in (b"int8 a", b"int8 b"))
    topic = Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=1)
    ones = b"".join(record_bytes(Message(1, time, b"data", time, 0)) for time in range(5, 15))
    part = record_bytes(wrong, topic) + ones + RECORD.pack(0x85, 0)
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    content = MAGIC + head + record_bytes(Chunk("", part, 14, 5, 0, len(part)), DataEnd(0))
    summary = record_bytes(right, topic, Footer(len(content), 0, 0)) + MAGIC
    (tmp_path / "broken.mcap").write_bytes(content + summary)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, len(recovery.damaged)) == (10, 1)
    with (tmp_path / "fixed.mcap").open("rb") as stream:
        assert {schema and schema.data for schema, *_ in make_reader(stream).iter_messages()} == {b"int8 a"}


@pytest.mark.parametrize("lost", [1, 512])
def test_the_summary_is_found_where_bytes_were_lost_before_it(tmp_path: Path, lost: int) -> None:
    """It tells of the topics whose definitions are damaged in the first chunk."""
    path = tmp_path / "whole.mcap"
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=2000)
        writer.start("ros2", "another recorder")
        topic = writer.register_channel("/1", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"int8 a"))
        for k in range(300):
            writer.add_message(topic, k, np.random.default_rng(k).bytes(30), k)
        writer.finish()
    content, everything = bytearray(path.read_bytes()), messages(path)
    chunks = [(begin, end) for opcode, begin, end in records(content) if opcode == Opcode.CHUNK]
    content[chunks[0][0] + 100] ^= 1
    del content[chunks[-2][0] + 200 : chunks[-2][0] + 200 + lost]
    path.write_bytes(content)
    recover(path, tmp_path / "fixed.mcap", overwrite=False)
    found = messages(tmp_path / "fixed.mcap")
    assert 200 < len(found) < 300
    assert [one for one in everything if one in found] == found


def test_the_summary_of_a_small_file_is_found_where_a_byte_was_lost_before_it(tmp_path: Path) -> None:
    path = tmp_path / "whole.mcap"
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=300, index_types=IndexType.CHUNK)
        writer.start("ros2", "another recorder")
        topic = writer.register_channel("/1", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"int8 a"))
        for k in range(40):
            writer.add_message(topic, k, np.random.default_rng(k).bytes(8), k)
        writer.finish()
    content = bytearray(path.read_bytes())
    chunks = [(begin, end) for opcode, begin, end in records(content) if opcode == Opcode.CHUNK]
    assert len(content) < 4000
    content[chunks[0][0] + 60] ^= 1
    del content[chunks[-1][0] + 60]
    path.write_bytes(content)
    recovery = recover(path, tmp_path / "fixed.mcap", overwrite=False)
    assert chunks[0][0] in recovery.damaged
    assert recovery.messages == len(messages(tmp_path / "fixed.mcap")) > 20


def test_a_definition_in_a_damaged_summary_is_none_beside_that_in_a_chunk(tmp_path: Path) -> None:
    """A chunk that is left out makes definitions be looked for, first where a checksum is right."""
    path = tmp_path / "whole.mcap"
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=500)
        writer.start("ros2", "another recorder")
        schema = writer.register_schema("a/msg/B", "ros2msg", b"int8 a")
        topics = [writer.register_channel(f"/{name}", "cdr", schema, {"says": "hello"}) for name in "ab"]
        for k in range(100):
            writer.add_message(topics[k > 50], k, bytes(30), k)
        writer.finish()
    content = bytearray(path.read_bytes())
    second = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK][1]
    content[second + 60] ^= 1
    content[content.rindex(b"hello")] ^= 2
    path.write_bytes(content)
    assert len(recover(path, tmp_path / "fixed.mcap", overwrite=False).damaged) == 1
    with (tmp_path / "fixed.mcap").open("rb") as stream:
        found = [(channel.topic, channel.metadata["says"]) for _, channel, _ in make_reader(stream).iter_messages()]
    assert found.count(("/b", "hello")) == 49


@pytest.mark.parametrize("behind", [b"\0", b"\xff", b""])
@pytest.mark.parametrize("compression", ["lz4", "zstd"])
def test_whole_blocks_of_an_unfinished_chunk_are_kept_whatever_follows(
    tmp_path: Path, compression: str, behind: bytes
) -> None:
    """Other data, or zeros and then the file as it was to be."""
    path, noise = tmp_path / "whole.mcap", np.random.default_rng(0)
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=2**21, compression=CompressionType[compression.upper()])
        writer.start("ros2", "another recorder")
        topic = writer.register_channel("/1", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"int8 a"))
        for k in range(2000):
            writer.add_message(topic, k, noise.bytes(200) + bytes(200), k)
        writer.finish()
    content = path.read_bytes()
    (chunk,) = [(begin, end) for opcode, begin, end in records(content) if opcode == Opcode.CHUNK]
    cut, zeros = (chunk[0] + chunk[1]) // 2, bytes(chunk[1] - (chunk[0] + chunk[1]) // 2)
    path.write_bytes(content[:cut] + (1000 * behind or zeros + content[chunk[1] :]))
    recovery = recover(path, tmp_path / "fixed.mcap", overwrite=False)
    assert recovery.messages > 2000 * (0.5 - 2 * 2**17 / 862_000)


@pytest.mark.parametrize(
    "wrong",
    [
        record_bytes(Message(1, 2**63, b"data", 5, 0)),
        record_bytes(Message(1, 5, b"data", 2**63, 0)),
        RECORD.pack(0x1A, 0),
        record_bytes(
            Channel(id=2, topic="/2", message_encoding="cdr", metadata={}, schema_id=0), Message(3, 5, b"", 5, 0)
        ),
        record_bytes(Channel(id=2, topic="/2", message_encoding="cdr", metadata={}, schema_id=9)),
    ],
    ids=["log time", "publish time", "kind", "channel", "schema"],
)
@pytest.mark.parametrize("chunked", [True, False])
def test_what_is_recovered_is_whole_for_every_reader(tmp_path: Path, wrong: bytes, chunked: bool) -> None:
    """Of chunks without a checksum and of none, with a record in the midst that no file may have."""
    head = record_bytes(Header(profile="ros2", library="another recorder"))
    channel = record_bytes(Channel(id=1, topic="/x", message_encoding="cdr", metadata={}, schema_id=0))
    good, late = (record_bytes(Message(number, 5, b"data", 5, 0)) for number in (1, 2))
    parts = [channel + good, good + wrong, late, good]
    if chunked:
        parts = [record_bytes(Chunk("", part, 5, 5, 0, len(part))) for part in parts]
    (tmp_path / "broken.mcap").write_bytes(MAGIC + head + b"".join(parts))
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert recovery.messages in (2, 3, 4)
    assert recovery.damaged
    assert sum(size for size, _ in read_file(tmp_path / "fixed.mcap", McapContents())) > 0


def test_a_chunk_that_claims_to_be_huge_is_left_out(whole: dict[str, Path], tmp_path: Path) -> None:
    content = bytearray(whole["zstd"].read_bytes())
    chunks = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK]
    for begin in chunks:
        struct.pack_into("<Q", content, begin + 9 + 16, 2**62)
        (tmp_path / "broken.mcap").write_bytes(content)
        if begin != chunks[-1]:
            recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
            assert recovery.damaged == tuple(at for at in chunks if at <= begin)
    with refused("nothing whole"):
        recover(tmp_path / "broken.mcap", tmp_path / "none.mcap", overwrite=False)
    assert not (tmp_path / "none.mcap").exists()


def test_a_stray_message_outside_of_chunks_is_left_out_and_told(tmp_path: Path) -> None:
    """It costs neither its neighbours nor the record that comes after them."""
    channel = Channel(id=1, topic="/x", message_encoding="cdr", metadata={}, schema_id=0)
    head = record_bytes(Header(profile="ros2", library="another recorder"), channel)
    good, stray = (record_bytes(Message(number, 5, b"data", 5, 0)) for number in (1, 9))
    broken = MAGIC + head + good + stray + good
    (tmp_path / "broken.mcap").write_bytes(broken)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.damaged) == (2, (len(MAGIC + head + good),))


def test_a_header_that_is_no_text_or_missing_leaves_nothing(tmp_path: Path) -> None:
    channel = record_bytes(Channel(id=1, topic="/x", message_encoding="cdr", metadata={}, schema_id=0))
    for head in (b"", b"\1\2\0\0\0\0\0\0\0\xff\xff", record_bytes(Header(profile="ros2", library="\u00e9"))[:-1]):
        (tmp_path / "broken.mcap").write_bytes(MAGIC + head + channel)
        with pytest.raises(NothingWholeError):
            recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
        assert not (tmp_path / "fixed.mcap").exists()


def test_a_file_that_is_packed_as_a_whole_has_the_remedy_of_one(whole: dict[str, Path], tmp_path: Path) -> None:
    """Whoever were told to record it again would give it up."""
    packed = tmp_path / "one.mcap.zstd"
    packed.write_bytes(zstandard.ZstdCompressor().compress(whole["zstd"].read_bytes()))
    with refused("packed as a whole"):
        recover(packed, tmp_path / "fixed.mcap", overwrite=False)


@pytest.mark.parametrize("opcode", sampled([0, Opcode.ATTACHMENT, Opcode.CHUNK], every=3))
def test_room_that_was_kept_for_more_is_not_read(whole: dict[str, Path], tmp_path: Path, opcode: int) -> None:
    """Some file systems leave a long tail of zeros, which takes no room on the disk, but would in memory."""
    content, path = whole["zstd"].read_bytes(), tmp_path / "broken.mcap"
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    with path.open("wb") as out:
        out.write(content[:end] + bytes([opcode]) + b"\xff" * 7)
        out.truncate(2**36)
    recovery = recover(path, tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.broken_at) == (len(messages(whole["zstd"])), end)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_chunks_longer_than_their_fields_that_follow_each_other_are_whole(
    whole: dict[str, Path], tmp_path: Path, compression: str
) -> None:
    """The format allows both: fields of a later version behind those that are known, and no indexes."""
    content, broken = whole[compression].read_bytes(), MAGIC
    for opcode, begin, end in records(content):
        if opcode == Opcode.HEADER:
            broken += content[begin:end]
        elif opcode == Opcode.CHUNK:
            broken += RECORD.pack(opcode, end - begin - RECORD.size + 4) + content[begin + RECORD.size : end] + b"more"
    broken += record_bytes(DataEnd(0), Footer(0, 0, 0)) + MAGIC
    (tmp_path / "longer.mcap").write_bytes(broken)
    recovery = recover(tmp_path / "longer.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.damaged, recovery.broken_at) == ((), None)
    assert messages(tmp_path / "fixed.mcap") == messages(whole[compression])


def flipped(content: bytes, at: int, bit: int) -> bytes:
    """The content with one bit of a byte flipped."""
    return content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :]


@pytest.mark.parametrize(
    ("compression", "summary"), sampled(itertools.product(COMPRESSIONS, ["whole", "damaged", "cut off"]), every=4)
)
def test_a_flipped_bit_of_a_length_costs_the_messages_of_that_record_alone(
    whole: dict[str, Path], tmp_path: Path, compression: str, summary: str
) -> None:
    content, everything = whole[compression].read_bytes(), messages(whole[compression])
    is_cut = summary == "cut off"
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    index = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK_INDEX][1]
    content = {"whole": content, "damaged": flipped(content, index + 5, 0), "cut off": content[:end]}[summary]
    lengths = [(opcode, begin, whole_in(content, begin, compression)) for opcode, begin, _ in records(content)]
    first = next(begin for opcode, begin, _ in lengths if opcode == Opcode.CHUNK)
    last = max(begin for opcode, begin, _ in lengths if opcode == Opcode.CHUNK)
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for i, (opcode, begin, before) in enumerate(lengths[: None if summary == "whole" else -1]):
        behind = lengths[i + 1][2] if begin < last else len(everything)
        if is_cut and begin in (first, last):  # one has the definitions, the other has none behind it
            continue
        broken.write_bytes(flipped(content, begin + 1 + i % 8, i % 7))
        recovery = recover(broken, fixed, overwrite=True)
        assert messages(fixed) == everything[:before] + everything[behind:], (opcode, begin)
        told = recovery.damaged[0] if recovery.damaged else recovery.broken_at
        assert opcode in (Opcode.HEADER, Opcode.FOOTER) or told == begin
        assert sum(size for size, _ in read_file(fixed, McapContents())) > 0


@pytest.mark.parametrize("bit", sampled(range(8), every=4))
def test_a_flipped_bit_of_an_opcode_costs_the_messages_of_that_record_alone(
    whole: dict[str, Path], tmp_path: Path, bit: int
) -> None:
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    lengths = [(opcode, begin, whole_in(content, begin, "zstd")) for opcode, begin, _ in records(content)]
    last = max(begin for opcode, begin, _ in lengths if opcode == Opcode.CHUNK)
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for i, (opcode, begin, before) in enumerate(lengths[1:], 1):
        broken.write_bytes(flipped(content, begin, bit))
        recovery = recover(broken, fixed, overwrite=True)
        behind = lengths[i + 1][2] if begin < last else len(everything)
        assert messages(fixed) == everything[:before] + everything[behind:], (opcode, begin)
        if opcode == Opcode.DATA_END:
            break
        assert begin in recovery.damaged, (opcode, begin)


def test_a_flipped_bit_of_the_magic_or_the_header_costs_no_message(whole: dict[str, Path], tmp_path: Path) -> None:
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    [(_, begin, end), *_] = records(content)
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for at, bit in (*((at, at % 8) for at in range(end)), *((begin, bit) for bit in range(8))):
        broken.write_bytes(flipped(content, at, bit))
        recovery = recover(broken, fixed, overwrite=True)
        assert messages(fixed) == everything, (at, bit)
        assert recovery.damaged in (((0,),) if at < begin else ((), (begin,))), (at, bit)


def test_what_stands_before_zeros_in_a_chunk_without_compression_is_kept(
    whole: dict[str, Path], tmp_path: Path
) -> None:
    """Where a disk lost power the file may be as long as it was to be."""
    content, everything = whole[""].read_bytes(), messages(whole[""])
    chunks = [(begin, end) for opcode, begin, end in records(content) if opcode == Opcode.CHUNK]
    begin, end = chunks[1]
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    before = whole_in(content, begin, "")
    for cut in ((begin + end) // 2, end - 1000, end - 990):
        for behind in (b"", content[end:]):
            broken.write_bytes(content[:cut] + bytes(end - cut) + (behind or bytes(5000)))
            recovery = recover(broken, fixed, overwrite=True)
            kept = whole_in(content[:cut], cut, "")
            left = everything[whole_in(content, chunks[2][0], "") :] if behind else []
            assert kept > before + 5
            assert messages(fixed) in (everything[: kept - 1] + left, everything[:kept] + left)
            assert begin in recovery.damaged


@pytest.mark.parametrize("garbage", [b"\x05 garbage", b"\x06 garbage", b"garbage \x05", b"\x09", b"\x09 garbage"])
def test_bytes_between_two_chunks_cost_nothing(whole: dict[str, Path], tmp_path: Path, garbage: bytes) -> None:
    """They move all that the summary tells of, and may begin as a message does."""
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    begin = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK][1]
    (tmp_path / "broken.mcap").write_bytes(content[:begin] + garbage + content[begin:])
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert messages(tmp_path / "fixed.mcap") == everything
    assert recovery.damaged == (begin,)


def loose(path: Path, count: int, payload: bytes) -> bytes:
    """A file of messages that are in no chunk, as of rosbag2's preset ``fastwrite``."""
    with path.open("wb") as out:
        writer = Writer(out, use_chunking=False)
        writer.start("ros2", "another recorder")
        channels = [writer.register_channel(topic, "cdr", 0) for topic in ("/a", "/b")]
        for k in range(count):
            writer.add_message(channels[k % 2], 1000 * k, payload + bytes([k]), 1000 * k, k)
        writer.finish()
    return path.read_bytes()


def test_a_flipped_bit_of_the_length_of_a_message_in_no_chunk_costs_that_message(tmp_path: Path) -> None:
    content = loose(tmp_path / "whole.mcap", 40, b"\xc8payload" * 9)
    everything, begins = messages(tmp_path / "whole.mcap"), [b for kind, b, _ in records(content) if kind == 5]
    for is_cut in (False, True):
        for k in range(40):
            broken = flipped(content, begins[k] + 1 + k % 8, 3 + k % 5)[: begins[-1] + 40 if is_cut else None]
            (tmp_path / "broken.mcap").write_bytes(broken)
            recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
            left = everything[:-1] if is_cut else everything
            assert messages(tmp_path / "fixed.mcap") == [one for one in left if one[2] != k]
            assert begins[k] in (*recovery.damaged, recovery.broken_at)


def test_a_flipped_bit_in_a_definition_costs_nothing_where_the_summary_repeats_it(tmp_path: Path) -> None:
    """In a file whose messages are in no chunk, of which none can be told from other bytes without it."""
    content = loose(tmp_path / "whole.mcap", 40, b"\xc8payload" * 9)
    everything = messages(tmp_path / "whole.mcap")
    begins = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHANNEL][:2]
    for at in [at for begin in begins for at in range(begin, begin + 9)]:
        for bit in range(8):
            (tmp_path / "broken.mcap").write_bytes(flipped(content, at, bit))
            recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
            assert messages(tmp_path / "fixed.mcap") == everything, (at, bit)


@pytest.mark.parametrize("harm", [b"", b"!!", b"garbage bytes"], ids=["a byte is gone", "a byte more", "many more"])
def test_a_damaged_definition_costs_its_topic_alone_where_nothing_repeats_it(tmp_path: Path, harm: bytes) -> None:
    """In a file whose messages are in no chunk, and that was cut off: also where the header lost or won bytes."""
    content = loose(tmp_path / "whole.mcap", 40, b"\xc8payload" * 9)
    everything = messages(tmp_path / "whole.mcap")
    begins = [begin for opcode, begin, _ in records(content) if opcode in (Opcode.HEADER, Opcode.CHANNEL)][:3]
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    for topic, begin in zip((None, "/a", "/b"), begins, strict=True):
        for at in range(begin, begin + 30):
            (tmp_path / "broken.mcap").write_bytes(content[:at] + harm + content[at + 1 : end])
            recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
            found = messages(tmp_path / "fixed.mcap")
            assert [one for one in found if one[0] in ("/a", "/b")] in (
                everything,
                [one for one in everything if one[0] != topic],
            ), at


@pytest.mark.parametrize("summary", ["whole", "none"])
def test_a_byte_that_is_missing_before_a_chunk_does_not_cost_that_one(
    whole: dict[str, Path], tmp_path: Path, summary: str
) -> None:
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    begin = [begin for opcode, begin, _ in records(content) if opcode == Opcode.CHUNK][1]
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    broken = content[: begin - 1] + content[begin : None if summary == "whole" else end]
    (tmp_path / "broken.mcap").write_bytes(broken)
    recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert messages(tmp_path / "fixed.mcap") == everything


@pytest.mark.parametrize("is_cut", [False, True], ids=["whole", "without a summary"])
def test_a_chunk_in_an_attachment_whose_length_is_damaged_is_none_of_the_file(
    whole: dict[str, Path], tmp_path: Path, is_cut: bool
) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    with broken.open("wb") as out:
        writer = Writer(out, chunk_size=100)
        writer.start("ros2", "another recorder")
        channel = writer.register_channel("/a", "cdr", 0)
        for k in range(20):
            if k == 10:
                writer.flush()
                writer.add_attachment(1, 2, "bag", "", whole["zstd"].read_bytes())
            writer.add_message(channel, 1000 * k, bytes(50), 1000 * k, k)
        writer.finish()
    content, everything = broken.read_bytes(), messages(broken)
    attachment = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.ATTACHMENT)
    rest = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END) if is_cut else None
    for at, bit in ((1, 4), (2, 3), (6, 7)):
        broken.write_bytes(flipped(content, attachment + at, bit)[:rest])
        recovery = recover(broken, fixed, overwrite=True)
        assert messages(fixed) == everything
        assert attachment in (*recovery.damaged, recovery.broken_at)


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of what is read of files, as it is."""
    sizes, given = list[int](), FileBytes.__getitem__

    def counted(file: FileBytes, part: slice) -> bytes:
        sizes.append(len(data := given(file, part)))
        return data

    monkeypatch.setattr(FileBytes, "__getitem__", counted)
    return sizes


def test_work_for_damaged_records_grows_with_the_file_alone(
    whole: dict[str, Path], tmp_path: Path, read: list[int]
) -> None:
    """Heads that claim what is behind them, each in the one before, and ever new ones where the last one ended."""
    broken = tmp_path / "broken.mcap"
    head = whole["zstd"].read_bytes()
    begin = next(begin for opcode, begin, _ in records(head) if opcode == Opcode.DATA_END)
    for size in (0, 1000):
        false = Chunk("", bytes(size), 0, 0, 1, size)
        piece = record_bytes(false)[: 49 + size]
        claims = RECORD.pack(Opcode.CHUNK, 2**20 + 40) + piece[9:41] + RECORD.pack(0, 2**20)[1:] + bytes(4)
        for nested in (piece + b"\0", claims + piece[41:] + b"\0"):
            sizes = []
            for count in (1100, 2200):
                read.clear()
                broken.write_bytes(head[:begin] + count * nested)
                recover(broken, tmp_path / "fixed.mcap", overwrite=True)
                sizes.append(sum(read))
            assert sizes[1] < 2.5 * sizes[0]


@pytest.mark.parametrize("compression", ["zstd", ""])
def test_work_for_chunks_within_each_other_grows_with_the_file_alone(
    tmp_path: Path, read: list[int], compression: str
) -> None:
    """Each claims to end where the first one ends, before what is no record; it is damaged, and has an index."""
    topic = record_bytes(Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0))
    part, sizes = topic + record_bytes(Message(1, 5, b"data", 5, 0)), list[int]()
    begin = MAGIC + record_bytes(
        Header(profile="ros2", library="another recorder"), Chunk("", part, 5, 5, 0, len(part))
    )
    head = len(record_bytes(Chunk(compression, b"", 0, 0, 0, 1)))
    for count in (1000, 2000):
        chunks = [Chunk(compression, bytes(head * rest), 0, k, 0, 1) for k, rest in enumerate(reversed(range(count)))]
        places = [len(begin) + head * k for k in range(count)]
        nested = b"".join(record_bytes(chunk)[:head] for chunk in chunks)
        content = begin + nested + b"\xff" * 100 + record_bytes(DataEnd(0))
        indexes = [
            ChunkIndex(head * (count - k), place, compression, head * (count - k - 1), 0, 0, {}, k, 1)
            for k, place in enumerate(places)
        ]
        read.clear()
        (tmp_path / "broken.mcap").write_bytes(content + record_bytes(*indexes, Footer(len(content), 0, 0)) + MAGIC)
        assert recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True).messages == 1
        sizes.append(sum(read))
    assert sizes[1] < 2.5 * sizes[0]


def test_work_for_false_ends_of_the_data_grows_with_the_file_alone(
    whole: dict[str, Path], tmp_path: Path, read: list[int]
) -> None:
    """Behind each may stand the summary, should bytes have been lost or won before it."""
    content, sizes = whole["zstd"].read_bytes(), list[int]()
    begin = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    end = record_bytes(DataEnd(0)) + RECORD.pack(Opcode.METADATA, 0)
    for count in (1000, 2000):
        read.clear()
        (tmp_path / "broken.mcap").write_bytes(content[:begin] + count * end + RECORD.pack(Opcode.METADATA, 2**40))
        recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
        sizes.append(sum(read))
    assert sizes[1] < 2.5 * sizes[0]


def test_work_for_frames_of_lz4_grows_with_them_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    given = list[int]()

    class Counting(LZ4FrameDecompressor):
        def decompress(self, data: bytes, max_length: int = -1) -> bytes:
            given.append(len(data))
            return bytes(super().decompress(data, max_length))

    monkeypatch.setattr(lz4.frame, "LZ4FrameDecompressor", Counting)
    sums, frame = list[int](), lz4.frame.compress(b"x")
    for count in (1000, 2000):
        given.clear()
        assert salvaged(Chunk("lz4", count * frame, 0, 0, 0, count)) == count * b"x"
        sums.append(sum(given))
    assert sums[1] < 2.5 * sums[0]


def test_a_chunk_that_lost_more_than_follows_it_costs_itself(tmp_path: Path) -> None:
    """A file that ends with a footer has no unfinished chunk, with a summary or without one."""
    topic = record_bytes(Channel(id=1, topic="/1", message_encoding="cdr", metadata={}, schema_id=0))
    noise = np.random.default_rng(0)
    data = [b"".join(record_bytes(Message(1, 5, noise.bytes(30), 5, 0)) for _ in range(count)) for count in (1, 30, 2)]
    data[0] = topic + data[0]
    chunks = [record_bytes(Chunk("lz4", lz4.frame.compress(part), 5, 5, 0, len(part))) for part in data]
    head = MAGIC + record_bytes(Header(profile="ros2", library="another recorder"))
    end = record_bytes(DataEnd(0), Footer(0, 0, 0)) + MAGIC
    (tmp_path / "broken.mcap").write_bytes(head + chunks[0] + chunks[1][:300] + chunks[1][-300:] + chunks[2] + end)
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=False)
    assert (recovery.messages, recovery.broken_at) == (3, None)


def test_an_altered_message_in_no_chunk_is_told_by_the_checksum_of_the_data(tmp_path: Path) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    with broken.open("wb") as out:
        writer = Writer(out, use_chunking=False, enable_data_crcs=True)
        writer.start("ros2", "another recorder")
        channel = writer.register_channel("/a", "cdr", 0)
        for k in range(5):
            writer.add_message(channel, k, b"payload", k, k)
        writer.finish()
    content = broken.read_bytes()
    assert not recover(broken, fixed, overwrite=True).is_altered
    broken.write_bytes(content.replace(b"payload", b"Payload", 1))
    recovery = recover(broken, fixed, overwrite=True)
    assert (recovery.is_altered, recovery.damaged, recovery.messages) == (True, (), 5)
    broken.write_bytes(flipped(content, 8, 1))  # of a record that is known to be damaged
    assert not recover(broken, fixed, overwrite=True).is_altered


def test_a_summary_that_no_footer_tells_of_is_told(whole: dict[str, Path], tmp_path: Path) -> None:
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    at = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.FOOTER) + RECORD.size
    (tmp_path / "broken.mcap").write_bytes(content[:at] + bytes(8) + content[at + 8 :])
    assert recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True).is_altered
    assert messages(tmp_path / "fixed.mcap") == everything


def test_messages_that_another_one_has_swallowed_are_told_by_the_number_in_the_summary(tmp_path: Path) -> None:
    content = loose(tmp_path / "whole.mcap", 40, b"\xc8payload" * 9)
    begins = [begin for opcode, begin, _ in records(content) if opcode == Opcode.MESSAGE]
    length = begins[20] - begins[10] - RECORD.size
    (tmp_path / "broken.mcap").write_bytes(
        content[: begins[10]] + RECORD.pack(Opcode.MESSAGE, length) + content[begins[10] + RECORD.size :]
    )
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert (recovery.messages, recovery.damaged, recovery.is_altered) == (31, (), True)


@pytest.mark.parametrize("layout", sampled(["chunks", "chunks without a summary", "no chunks"], every=2))
def test_the_damaged_length_of_an_attachment_costs_that_alone(tmp_path: Path, layout: str) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    with broken.open("wb") as out:
        writer = Writer(out, chunk_size=100, use_chunking=layout != "no chunks")
        writer.start("ros2", "another recorder")
        channel = writer.register_channel("/a", "cdr", 0)
        for k in range(60):
            if k == 10:
                writer.flush() if layout != "no chunks" else None
                writer.add_attachment(1, 2, "notes", "text/plain", b"text" * 20)
                writer.add_metadata("notes", {"name": "value"})
            writer.add_message(channel, 1000 * k, bytes(50), 1000 * k, k)
        writer.finish()
    content, everything = broken.read_bytes(), messages(broken)
    attachment = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.ATTACHMENT)
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    for at, bit in itertools.product(range(1, 9), range(8)):
        broken.write_bytes(flipped(content, attachment + at, bit)[: end if "without" in layout else None])
        recovery = recover(broken, fixed, overwrite=True)
        assert messages(fixed) == everything
        assert attachment in recovery.damaged
        with fixed.open("rb") as file:
            assert [record.name for record in make_reader(file).iter_metadata()][:1] == ["notes"]


def test_an_attachment_before_all_chunks_becomes_no_message(tmp_path: Path) -> None:
    """Its times and the length of its name are the channel and the times of a sound one."""
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    with broken.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("x", "", b"")
        channel = writer.register_channel("/x", "", schema)
        writer.add_attachment(0, channel, "notes", "text/plain", b"text")
        writer.add_message(channel, 10, b"payload", 10)
        writer.finish()
    content = bytearray(broken.read_bytes())
    attachment = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.ATTACHMENT)
    content[attachment] = Opcode.MESSAGE
    broken.write_bytes(content)
    assert recover(broken, fixed, overwrite=False).damaged == (attachment,)
    assert messages(fixed) == [("/x", 10, 0, b"payload")]


@pytest.mark.parametrize("kind", ["attachment", "metadata"])
def test_bytes_that_a_record_lost_or_won_cost_no_message_behind_it(tmp_path: Path, kind: str) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for is_chunked in (True, False):
        with broken.open("wb") as out:
            writer = Writer(out, chunk_size=100, use_chunking=is_chunked)
            writer.start("ros2", "another recorder")
            channel = writer.register_channel("/a", "cdr", 0)
            for k in range(20):
                if k == 10:
                    if is_chunked:
                        writer.flush()
                    if kind == "metadata":
                        writer.add_metadata("notes", {"name": "value" * 20})
                    else:
                        writer.add_attachment(1, 2, "notes", "text/plain", b"text" * 20)
                writer.add_message(channel, 1000 * k, bytes(50), 1000 * k, k)
            writer.finish()
        content, everything = broken.read_bytes(), messages(broken)
        at = content.index(b"notes") + 40
        for harmed in (content[:at] + content[at + 3 :], content[:at] + b"!!!" + content[at:]):
            broken.write_bytes(harmed)
            recover(broken, fixed, overwrite=True)
            assert messages(fixed) == everything


def test_a_damaged_name_of_a_topic_comes_from_the_summary(tmp_path: Path) -> None:
    content = loose(tmp_path / "whole.mcap", 4, b"payload")
    everything = messages(tmp_path / "whole.mcap")
    name = content.index(b"/b")
    (tmp_path / "broken.mcap").write_bytes(flipped(content, name + 1, 0))
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert (messages(tmp_path / "fixed.mcap"), len(recovery.damaged)) == (everything, 1)
    (tmp_path / "broken.mcap").write_bytes(flipped(content, content.rindex(b"/b") + 1, 0))
    recovery = recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert (messages(tmp_path / "fixed.mcap"), recovery.is_altered) == (everything, True)
    assert not recover(tmp_path / "whole.mcap", tmp_path / "fixed.mcap", overwrite=True).is_altered


def with_another(path: Path, content: bytes, *, is_attached: bool, is_chunked: bool) -> bytes:
    """A file with what may be another one in it, attached or as a message, between messages of its own."""
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=100, use_chunking=is_chunked)
        writer.start("ros2", "another recorder")
        channel, blob = (writer.register_channel(topic, "cdr", 0) for topic in ("/a", "/blob"))
        for k in range(40):
            if k == 20:
                if is_chunked:
                    writer.flush()
                writer.add_attachment(1, 2, "bag", "", content if is_attached else b"")
                writer.add_metadata("notes", {"name": "value"})
                writer.add_message(blob, 1000 * k, b"" if is_attached else content, 1000 * k, k)
            writer.add_message(channel, 1000 * k, bytes(50), 1000 * k, k)
        writer.finish()
    return path.read_bytes()


@pytest.mark.parametrize("is_chunked", [True, False])
@pytest.mark.parametrize("summary", [True, False])
def test_zeros_in_an_attached_bag_cost_that_alone(
    whole: dict[str, Path], tmp_path: Path, is_chunked: bool, summary: bool
) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for inner in (whole["zstd"].read_bytes(), loose(tmp_path / "inner.mcap", 40, b"payload")):
        content = with_another(broken, inner, is_attached=True, is_chunked=is_chunked)
        everything, end = messages(broken), next(b for opcode, b, _ in records(content) if opcode == Opcode.DATA_END)
        attachment = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.ATTACHMENT)
        for first, last in ((26, 226), (39, 99)):
            zeroed = content[: attachment + first] + bytes(last - first) + content[attachment + last :]
            broken.write_bytes(zeroed[: None if summary else end])
            recovery = recover(broken, fixed, overwrite=True)
            assert (messages(fixed), recovery.damaged) == (everything, (attachment,))


@pytest.mark.parametrize("is_chunked", [True, False])
def test_the_beginning_of_a_bag_in_a_message_hides_nothing_behind_it(
    whole: dict[str, Path], tmp_path: Path, is_chunked: bool
) -> None:
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    inner = loose(tmp_path / "inner.mcap", 40, b"payload")[:3000]
    content = with_another(broken, inner, is_attached=False, is_chunked=is_chunked)
    everything = [one for one in messages(broken) if one[0] == "/a"]
    metadata = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.METADATA)
    end = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    for harmed in (content[: metadata + 20] + content[metadata + 21 : end], flipped(content, metadata + 1, 0)[:end]):
        broken.write_bytes(harmed)
        recover(broken, fixed, overwrite=True)
        found = [one for one in messages(fixed) if one[0] == "/a"]
        assert len(found) >= len(everything) - is_chunked  # which stands in the chunk with the other


@pytest.mark.parametrize("kind", [Opcode.HEADER, Opcode.CHUNK])
def test_a_record_that_is_gone_costs_what_it_held(whole: dict[str, Path], tmp_path: Path, kind: Opcode) -> None:
    content, everything = whole["zstd"].read_bytes(), messages(whole["zstd"])
    begin, end = next((begin, end) for opcode, begin, end in records(content) if opcode == kind)
    (tmp_path / "broken.mcap").write_bytes(content[:begin] + content[end:])
    recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
    assert messages(tmp_path / "fixed.mcap") == everything[whole_in(content, end, "zstd") :]


def test_a_kind_of_0_costs_no_message_before_it(tmp_path: Path) -> None:
    content = loose(tmp_path / "whole.mcap", 40, b"payload")
    everything = messages(tmp_path / "whole.mcap")
    begins = [begin for opcode, begin, _ in records(content) if opcode in (Opcode.MESSAGE, Opcode.DATA_END)]
    for k, begin in enumerate(begins[1:], 1):
        (tmp_path / "broken.mcap").write_bytes(content[:begin] + b"\0" + content[begin + 1 :])
        recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
        assert messages(tmp_path / "fixed.mcap") == everything[:k] + everything[k + 1 :]


def test_work_for_attachments_that_claim_half_of_the_file_grows_with_the_file_alone(
    whole: dict[str, Path], tmp_path: Path, read: list[int]
) -> None:
    content = whole["zstd"].read_bytes()
    begin = next(begin for opcode, begin, _ in records(content) if opcode == Opcode.DATA_END)
    sizes = []
    for count in (1100, 2200):
        head = RECORD.pack(Opcode.ATTACHMENT, count * 29) + bytes(16) + struct.pack("<IIQ", 0, 0, count * 29 - 36)
        read.clear()
        (tmp_path / "broken.mcap").write_bytes(content[:begin] + bytes(9) + count * head.ljust(58, b"x"))
        recover(tmp_path / "broken.mcap", tmp_path / "fixed.mcap", overwrite=True)
        sizes.append(sum(read))
    assert sizes[1] < 2.5 * sizes[0]
