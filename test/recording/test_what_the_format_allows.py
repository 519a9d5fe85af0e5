"""What the MCAP format allows is read: of each form of a bag the messages are those of the bag, and it is certified."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
import zstandard
from forged import framed, message, plain
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import CompressionType, IndexType

from foreign_bags import bag_of, file_of, messages_of, record, records_of, text
from lie_rigid_body import Run, certify, simulate
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.mcap_contents import of_types
from lie_rigid_body.recording.records import MAGIC, record_bytes
from lie_rigid_body.recording.recovery import recover
from sampled import sampled

Found = list[tuple[str, int, bytes]]
Record = tuple[int, bytes]
BARE: dict[str, Any] = {
    "repeat_channels": False,
    "repeat_schemas": False,
    "use_statistics": False,
    "use_summary_offsets": False,
    "index_types": IndexType.NONE,
    "enable_crcs": False,
}
OPTIONS: dict[str, dict[str, Any]] = {
    **{name: {name: value} for name, value in BARE.items()},
    **{str(kind): {"index_types": kind} for kind in IndexType},
    "neither repeats": {"repeat_channels": False, "repeat_schemas": False},
    "bare": BARE,
    "no chunks": {"use_chunking": False},
    "no chunks, bare": {"use_chunking": False, **BARE},
    "a message a chunk": {"chunk_size": 1},
    **{str(kind): {"compression": kind, "chunk_size": 4000} for kind in CompressionType},
}


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("honest") / "bag.mcap"
    simulate(duration=1.0, motion="closed_form", imu_rate=50.0, gyro_spike_probability=0.2).to_bag(path)
    return path


def library_messages(path: Path) -> Found:
    return [(m.topic, m.log_time, m.data) for m in messages_of(path)]


def own_messages(path: Path) -> Found:
    """Messages topic by topic, as they are kept in the first pass, and as they are read again."""
    kept, again = BagFiles(path).contents(lambda *key: True), BagFiles(path).contents(of_types(()))
    found: Found = []
    for key in sorted(kept.tracks):
        found += [(key[0], *each) for each in kept.messages(key).payloads()]
        assert [*kept.messages(key).payloads()] == [*again.messages(key).payloads()]
        assert len(kept.messages(key)) == kept.tracks[key].count
    return found


def by_topic(messages: Found) -> Found:
    return sorted(messages, key=lambda each: each[0])


def is_read(path: Path, messages: Found) -> None:
    """All messages are read, and recovered; the bag is certified."""
    assert own_messages(path) == by_topic(messages)
    assert certify(path).passed
    found = recover(path, path.with_name("recovered.mcap"), overwrite=True)
    assert (found.messages, found.damaged, found.broken_at) == (len(messages), (), None)
    assert own_messages(path.with_name("recovered.mcap")) == by_topic(messages)


def copied(source: Path, target: Path, channels_each: int = 1, **options: Any) -> Path:
    """A copy of a bag by the `mcap` library, each topic on so many channels in turn, as where recordings are merged."""
    messages = [m._replace(publisher=number % channels_each) for number, m in enumerate(messages_of(source))]
    target.write_bytes(bag_of(messages, LIBRARY, **options))
    return target


@pytest.mark.parametrize("case", sampled(OPTIONS, every=3))
def test_what_a_writer_may_leave_out_is_not_missed(honest: Path, tmp_path: Path, case: str) -> None:
    is_read(copied(honest, tmp_path / "copy.mcap", **OPTIONS[case]), library_messages(honest))


def test_a_merge_has_several_channels_of_a_topic(honest: Path, tmp_path: Path) -> None:
    is_read(copied(honest, tmp_path / "merged.mcap", channels_each=3), library_messages(honest))


def padded(given: list[Record]) -> Iterator[Record]:
    """Fields of versions to come stand behind those of today; a message is all data."""
    for opcode, content in given:
        behind = b"" if opcode == Opcode.MESSAGE else b"to come"
        yield opcode, content + behind


def of_others(given: list[Record]) -> Iterator[Record]:
    """Records of applications and of versions to come, everywhere."""
    for opcode, content in given:
        yield opcode, content
        yield from ((other, b"anything") for other in (0x10, 0x7F, 0x80, 0xFF) if opcode != Opcode.FOOTER)


def inside(change: Callable[[list[Record]], Iterator[Record]], pack: Callable[[bytes], bytes]) -> Any:
    """Change the records in chunks, and compress them."""

    def changed(given: list[Record]) -> Iterator[Record]:
        for opcode, content in given:
            if opcode != Opcode.CHUNK:
                yield opcode, content
                continue
            chunk = Chunk.read(ReadDataStream(BytesIO(content)))
            data = b"".join(record(*one) for one in change(records_of(MAGIC + chunk.data + MAGIC)))
            chunk.uncompressed_size, chunk.uncompressed_crc, chunk.data = len(data), 0, pack(data)
            chunk.compression = "zstd" if pack is not bytes else ""
            yield opcode, record_bytes(chunk)[9:]

    return changed


def statistics_at_0(given: list[Record]) -> Iterator[Record]:
    """A writer took the log time 0 for none."""
    for opcode, content in given:
        yield opcode, content[:26] + struct.pack("<Q", 10**6) + content[34:] if opcode == Opcode.STATISTICS else content


def lying(given: list[Record]) -> Iterator[Record]:
    """Every number of indexes and of the summary is wrong."""
    hints = {Opcode.MESSAGE_INDEX, Opcode.CHUNK_INDEX, Opcode.STATISTICS, Opcode.SUMMARY_OFFSET}
    for opcode, content in given:
        yield opcode, bytes(each ^ 0x55 for each in content) if opcode in hints else content


FORMS: dict[str, Callable[[list[Record]], Iterator[Record]]] = {
    "padded records": padded,
    "records of others": of_others,
    "padded records in chunks": inside(padded, bytes),
    "records of others in chunks": inside(of_others, bytes),
    "several frames": inside(iter, lambda data: zstandard.compress(data[:99]) + zstandard.compress(data[99:])),
    "padded frames": inside(iter, lambda data: zstandard.compress(data) + bytes(16)),
    "statistics that begin later": statistics_at_0,
    "numbers of hints": lying,
}


@pytest.mark.parametrize("case", FORMS)
def test_what_the_format_allows_is_read(honest: Path, tmp_path: Path, case: str) -> None:
    plain_copy = copied(honest, tmp_path / "plain.mcap", compression=CompressionType.NONE, enable_crcs=False)
    changed = FORMS[case](records_of(plain_copy.read_bytes()))
    path = tmp_path / "changed.mcap"
    path.write_bytes(file_of(changed))
    is_read(path, library_messages(honest))


def test_a_run_of_each_form_has_the_same_bits(honest: Path, tmp_path: Path) -> None:
    own = Run.from_bag(honest)
    copy = Run.from_bag(copied(honest, tmp_path / "copy.mcap", channels_each=2, **BARE))
    assert (own.truth.attitude_xyzw == copy.truth.attitude_xyzw).all()
    assert (own.imu.gyro == copy.imu.gyro).all()


def test_a_message_without_a_type_is_read_beside_ours(tmp_path: Path) -> None:
    """Of schema 0, which is none, and with a definition that stands behind its message in a chunk."""
    channel = record(Opcode.CHANNEL, struct.pack("<HH", 1, 0) + text("/x") + text("cdr") + bytes(4))
    for order in itertools.permutations((channel, message(1), record(0xFF, b""))):
        path = tmp_path / "x.mcap"
        path.write_bytes(framed(plain(*order)))
        assert own_messages(path) == [("/x", 7, b"payload")]
