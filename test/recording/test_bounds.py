"""Every length that a file says is held against a bound: each is set to its largest, and the memory is measured."""

from __future__ import annotations

import json
import struct
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import pytest
from forged import Record, honest
from refused_bags import refused as refused_as

from foreign_bags import PLAIN, Message, bag_of, decode, file_of, messages_of, sized
from lie_rigid_body import simulate
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.definition import OF_TABLE
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.evaluate import main as evaluate
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.league.table import rows_of
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.decoding import decode_framed, decode_string
from lie_rigid_body.messages.definitions import STRING
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.mcap_contents import nothing
from lie_rigid_body.simulation import Segment
from lie_rigid_body.system.bounded_input import (
    load_json,
)
from mutations import FIELDS

MIB = 2**20


@pytest.fixture(scope="module")
def honest_bag(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A bag of three samples, without checksums."""
    path = tmp_path_factory.mktemp("bags") / "bag.mcap"
    simulate(duration=0.2, motion="closed_form", rate=10.0).to_bag(path)
    return bag_of(messages_of(path), LIBRARY, compression=PLAIN, enable_crcs=False)


def length_places(opcode: int, content: bytes) -> Iterator[tuple[int, int]]:
    """Where each length stands in the content of a record, and of how many bytes it is; those in maps as well."""
    at = 0
    for kind in FIELDS[opcode]:
        if kind.isdecimal():
            at += int(kind)
            continue
        size = 8 if kind == "D" else 4
        if at + size > len(content):
            return
        length = int.from_bytes(content[at : at + size], "little")
        yield at, size
        if kind == "M" and opcode in (4, 12) and length:
            yield at + 4, 4
            yield at + 8 + int.from_bytes(content[at + 4 : at + 8], "little"), 4
        at += size + length


def refused(content: bytes, folder: Path) -> str:
    """What the reader says of a file that it refuses, in less memory than a bound allows for."""
    path = folder / "x.mcap"
    path.write_bytes(content)
    tracemalloc.start()
    try:
        with pytest.raises(BagError) as caught:
            BagFiles(path).contents(nothing)
        assert tracemalloc.get_traced_memory()[1] < 16 * MIB
    finally:
        tracemalloc.stop()
    return str(caught.value)


def forged_lengths() -> Iterator[tuple[int, list[Record]]]:
    records = honest()
    for i, (opcode, content) in enumerate(records):
        for at, size in length_places(opcode, content):
            for value in (2 ** (8 * size) - 1, 2 ** (8 * size - 1), len(content)):
                changed = content[:at] + value.to_bytes(size, "little") + content[at + size :]
                if changed != content:
                    yield opcode, [*records[:i], (opcode, changed), *records[i + 1 :]]


def test_every_length_of_a_record_at_its_largest_is_refused_or_of_no_account(tmp_path: Path) -> None:
    """Those of indexes, of the summary and of attachments tell of no message."""
    path, refusals = tmp_path / "x.mcap", 0
    path.write_bytes(file_of(honest()))
    whole = BagFiles(path).contents(nothing)
    for _, forged in forged_lengths():
        path.write_bytes(file_of(forged))
        tracemalloc.start()
        try:
            found = BagFiles(path).contents(nothing)
        except BagError:
            refusals += 1
        else:
            assert found.tracks == whole.tracks
        finally:
            assert tracemalloc.get_traced_memory()[1] < 16 * MIB
            tracemalloc.stop()
    assert refusals > 10


def test_every_length_of_a_record_head_at_its_largest_is_refused(tmp_path: Path) -> None:
    content, at = file_of(honest()), 8
    while at < len(content) - 8:
        (length,) = struct.unpack_from("<Q", content, at + 1)
        for value in (2**64 - 1, 2**63, 2**31):
            changed = content[: at + 1] + struct.pack("<Q", value) + content[at + 9 :]
            assert f"byte {at}: " in refused(changed, tmp_path)
        at += 9 + length


HEADER = b"\0\1\0\0" + bytes(8)
STRINGS: dict[str, tuple[Callable[[bytes], object], bytes]] = {
    "frame of a pose": (lambda data: decode([data], 7, stamped=True), HEADER),
    "text": (lambda data: decode_string(data), b"\0\1\0\0"),
    "frame of an odometry": (lambda data: decode_framed([data], 85, counted=False), HEADER),
    "child frame": (lambda data: decode_framed([data], 85, counted=False), HEADER + sized(b"w\0") + bytes(2)),
    "transforms": (lambda data: decode_framed([data], 7, counted=True), b"\0\1\0\0"),
    "frame of a transform": (lambda data: decode_framed([data], 7, counted=True), b"\0\1\0\0\1\0\0\0" + bytes(8)),
}


@pytest.mark.parametrize("name", STRINGS)
@pytest.mark.parametrize("length", [2**32 - 1, 2**31, 2**20 + 1])
def test_every_length_of_a_message_at_its_largest_is_refused(name: str, length: int) -> None:
    read, before = STRINGS[name]
    for behind in (b"", bytes(500)):
        with refused_as("field"):
            read(before + struct.pack("<I", length) + behind)


@pytest.mark.parametrize("content", ["[" * 100_000, '{"a":' * 100_000, "1" * 10_000, "nul", "\ud800", ""])
def test_json_is_refused_in_one_error(content: str, tmp_path: Path) -> None:
    with refused_as("no JSON"):
        load_json(content, "x")
    path = tmp_path / "rows.json"
    path.write_text(content, encoding="utf-8", errors="replace")
    with refused_as("no rows", name="rows.json"):
        rows_of(path)
    with pytest.raises(InputError):
        Segment.from_json(content)


def table() -> bytes:
    import pyarrow
    from pyarrow import parquet

    out = BytesIO()
    campaign = Campaign(runs=2, seed=1, duration=1.0)
    metadata = {OF_TABLE: json.dumps({"campaign": json.loads(campaign.to_json())})}
    parquet.write_table(pyarrow.table({"run": [0, 1]}).replace_schema_metadata(metadata), out)
    return out.getvalue()


@pytest.mark.slow
def test_every_length_of_a_table_at_its_largest_is_refused(tmp_path: Path) -> None:
    """The last 8 bytes are the length of the description and the magic; each byte of the description is set as well."""
    whole, path = table(), tmp_path / "runs.parquet"
    path.write_bytes(whole)
    assert Campaign.from_table(path).runs == 2
    (length,) = struct.unpack("<I", whole[-8:-4])
    for value in (2**32 - 1, 2**31, len(whole), 0):
        path.write_bytes(whole[:-8] + struct.pack("<I", value) + whole[-4:])
        with refused_as("no table"):
            Campaign.from_table(path)
    for at in range(len(whole) - 8 - length, len(whole) - 8):
        path.write_bytes(whole[:at] + b"\xff" + whole[at + 1 :])
        with suppress(InputError):
            assert Campaign.from_table(path).runs in range(1, 2**31)


@pytest.mark.slow
def test_thousands_of_other_topics_are_read_in_one_pass(
    honest_bag: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Which of the texts are scenarios is asked of each topic: a chunk was read again for each of them."""
    others = [Message(f"/x{i}", STRING, b"", 0, 0, encode_string("")) for i in range(3_000)]
    path = tmp_path / "x.mcap"
    path.write_bytes(bag_of([*messages_of(honest_bag), *others], LIBRARY))
    begin = time.process_time()
    assert evaluate([str(path), "--estimate", "/pose"]) == 0
    assert check([str(path)]) == 0
    assert time.process_time() - begin < 20
    assert "/x2999 " in " ".join(capsys.readouterr().out.split())
