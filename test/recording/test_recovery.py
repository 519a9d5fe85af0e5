"""Files that were cut or damaged: whole messages before that are recovered, and none that was not written."""

from __future__ import annotations

import random
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags import COMPRESSIONS
from lz4.frame import LZ4FrameDecompressor
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import Writer

from lie_rigid_body.certificate import certify
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.recovery import NothingWholeError, Recovery, recover
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
    times = [time for _, time, *_ in found]
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (min(times), max(times))
    return found


def records(content: bytes | bytearray) -> Iterator[tuple[int, int, int]]:
    """Opcode, begin and end of each record of a file."""
    begin = 8
    while begin < len(content) - 8:
        opcode, length = RECORD.unpack_from(content, begin)
        yield opcode, begin, begin + RECORD.size + length
        begin += RECORD.size + length


def place(content: bytes | bytearray, opcode: int, number: int = 0) -> int:
    """Where a record of a kind begins."""
    return [begin for kind, begin, _ in records(content) if kind == opcode][number]


def unpacked(compression: str, data: bytes | bytearray) -> bytes:
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    return LZ4FrameDecompressor().decompress(data) if compression else bytes(data)


def whole_in(content: bytes | bytearray, size: int, compression: str) -> int:
    """How many messages are whole in the first bytes of a file, by another way."""
    count = 0
    for opcode, begin, end in records(content):
        data = begin + RECORD.size + 32 + len(compression) + 8
        if opcode == Opcode.CHUNK and size > data:
            inner, at = unpacked(compression, content[data : min(end, size)]), 0
            while at + RECORD.size <= len(inner):
                kind, length = RECORD.unpack_from(inner, at)
                at += RECORD.size + length
                count += kind == Opcode.MESSAGE and at <= len(inner)
    return count


def recovered(content: bytes | bytearray, folder: Path) -> Recovery | None:
    """Recover a file of some content, which is only read; None if it holds nothing whole."""
    broken = folder / "broken.mcap"
    broken.write_bytes(content)
    try:
        return recover(broken, folder / "fixed.mcap", overwrite=True)
    except NothingWholeError:
        return None
    finally:
        assert broken.read_bytes() == content


def structural(content: bytes, step: int) -> list[int]:
    """Sizes at, before and after every boundary of the file's structure."""
    edges = {0, 8, len(content)} | {edge for _, begin, end in records(content) for edge in (begin, begin + 9, end)}
    sizes = sorted({edge + d for edge in edges for d in (-1, 0, 1) if 0 <= edge + d <= len(content)})
    return [*sizes[::step], len(content)]


@pytest.mark.parametrize("compression", sampled(COMPRESSIONS, every=3))
@pytest.mark.parametrize(("step", "drawn"), [(17, 10), pytest.param(3, 300, marks=pytest.mark.slow)])
def test_every_whole_message_of_a_cut_file_is_recovered(
    whole: dict[str, Path], tmp_path: Path, compression: str, step: int, drawn: int
) -> None:
    content = whole[compression].read_bytes()
    everything = messages(whole[compression])
    data_end = place(content, Opcode.DATA_END)
    for size in [*structural(content, step), *np.random.default_rng(7).integers(0, len(content), drawn).tolist()]:
        found = recovered(content[:size], tmp_path)
        count = whole_in(content, size, compression)
        assert (found.messages if found else 0) == count, size
        if found:
            assert messages(tmp_path / "fixed.mcap") == everything[:count], size
            assert (found.broken_at is None) == (size == len(content))
            assert found.in_summary == (data_end + 13 <= size < len(content)), size
            assert (found.damaged, found.is_altered) == ((), False)


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("part", [0.3, 0.71, 0.95])
def test_what_is_recovered_is_certified(whole: dict[str, Path], tmp_path: Path, compression: str, part: float) -> None:
    content = whole[compression].read_bytes()
    found = recovered(content[: int(part * len(content))], tmp_path)
    assert found is not None
    assert found.messages > 10
    assert certify(read_bag(tmp_path / "fixed.mcap")).passed


def test_a_file_that_breaks_off_in_its_summary_becomes_what_it_was(whole: dict[str, Path], tmp_path: Path) -> None:
    """Topics are counted, and not channels; a whole file stays what it is."""
    for path in whole.values():
        content = path.read_bytes()
        for size in (len(content), len(content) - 1, place(content, Opcode.STATISTICS) + 5):
            found = recovered(content[:size], tmp_path)
            assert found is not None
            assert (found.messages, found.topics) == (len(messages(path)), 5)
            assert (tmp_path / "fixed.mcap").read_bytes() == content


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("number", [0, 1])
def test_a_damaged_chunk_is_left_out_and_told(
    whole: dict[str, Path], tmp_path: Path, compression: str, number: int
) -> None:
    """The first one has the definitions, which the summary repeats; a bag that is cut off has them nowhere else."""
    content, everything = bytearray(whole[compression].read_bytes()), messages(whole[compression])
    first, second = place(content, Opcode.CHUNK, number), place(content, Opcode.CHUNK, number + 1)
    lost = [whole_in(content, at, compression) for at in (first, second)]
    content[(first + second) // 2] ^= 1
    found = recovered(content, tmp_path)
    assert found is not None
    assert (found.broken_at, found.damaged) == (None, (first,))
    assert messages(tmp_path / "fixed.mcap") == everything[: lost[0]] + everything[lost[1] :]
    if number == 0:
        assert recovered(content[: place(content, Opcode.DATA_END)], tmp_path) is None


@pytest.mark.parametrize("compression", sampled(COMPRESSIONS, every=3))
def test_zeros_that_a_loss_of_power_leaves_are_no_content(
    whole: dict[str, Path], tmp_path: Path, compression: str
) -> None:
    """Of the message in which they begin nobody knows; the one before may be left out with it."""
    content, everything = whole[compression].read_bytes(), messages(whole[compression])
    kept = 0
    for size in np.random.default_rng(9).integers(len(content) // 4, place(content, Opcode.DATA_END), 15).tolist():
        for zeros in (len(content) - size, 40, 100_000):
            found = recovered(content[:size] + bytes(zeros), tmp_path)
            there = messages(tmp_path / "fixed.mcap")
            assert found is not None
            assert there == everything[: found.messages], size
            if not compression:
                assert abs(whole_in(content, size, "") - found.messages) <= 1, size
            kept += found.messages
    assert kept > 120 * 15


@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_other_recorders_are_recovered(tmp_path: Path, chunked: bool) -> None:
    """Also where messages are in no chunk, and with what else a file may hold."""
    path = tmp_path / "other.mcap"
    with open(path, "wb") as out:
        writer = Writer(out, use_chunking=chunked, chunk_size=2000)
        writer.start("ros2", "another recorder")
        writer.add_attachment(1, 2, "calibration", "text/plain", b"anything")
        writer.add_metadata("vehicle", {"name": "sat"})
        schema = writer.register_schema("a/msg/B", "ros2msg", b"int8 a")
        channels = [writer.register_channel("/log", "cdr", schema, {"publisher": name}) for name in "ab"]
        for k in range(200):
            writer.add_message(channels[k % 2], 1000 * k, bytes([k] * 50), 1000 * k, k)
        writer.finish()
    content = path.read_bytes()
    begins = [begin for opcode, begin, _ in records(content) if opcode in (Opcode.CHUNK, Opcode.MESSAGE)]
    found = recovered(content[: begins[len(begins) // 2] + 30], tmp_path)
    assert found is not None
    assert 40 < found.messages < 160
    assert found.topics == 1
    with open(tmp_path / "fixed.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert [one.name for one in reader.iter_attachments()] == ["calibration"]
        assert [one.name for one in reader.iter_metadata()] == ["vehicle", "lie_rigid_body_cut_off"]
        assert [message.sequence for _, _, message in reader.iter_messages()][:3] == [0, 1, 2]


def test_data_that_a_checksum_of_all_contradicts_are_told(whole: dict[str, Path], tmp_path: Path) -> None:
    """As of a file whose chunks have none."""
    content = bytearray(whole[""].read_bytes())
    for opcode, begin, _ in records(content):
        if opcode == Opcode.CHUNK:
            content[begin + 33 : begin + 37] = bytes(4)
    found = recovered(content, tmp_path)
    assert found is not None
    assert (found.damaged, found.is_altered) == ((), True)


@pytest.mark.parametrize("seed", sampled(range(30), every=15))
def test_damage_anywhere_makes_nothing_up(whole: dict[str, Path], tmp_path: Path, seed: int) -> None:
    """Every message of a file is under a checksum: what is recovered was written, and other readers take it."""
    rng = random.Random(seed)
    compression = rng.choice([*COMPRESSIONS])
    content, everything = whole[compression].read_bytes(), messages(whole[compression])
    for _ in range(25):
        at, size = rng.randrange(8, len(content) - 8), rng.choice((1, 2, 16, 40, 500))
        rest = content[at + size :]
        harmed = rng.choice([rng.randbytes(size) + rest, rest, rng.randbytes(size) + content[at:], bytes(size) + rest])
        found = recovered(content[:at] + harmed, tmp_path)
        if found and place(content, Opcode.CHUNK) < at:
            kept = messages(tmp_path / "fixed.mcap")
            is_told = found.damaged or found.broken_at is not None or found.is_altered
            assert is_told or kept == everything
            if found.damaged or found.in_summary or found.broken_at is None:
                assert {*kept} <= {*everything} or found.is_altered
