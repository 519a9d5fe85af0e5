"""Bags made to take memory or time: refused before they get either."""

from __future__ import annotations

import json
import os
import resource
import struct
import subprocess
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard
from bags import MakeBag
from forged import chunk, framed
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, IndexType, Writer
from refused_bags import refused
from test_bag_reader import folder, rewrite

from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING
from lie_rigid_body.recording import bag_files
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.inflation import inflated
from lie_rigid_body.recording.mcap_contents import of_types
from lie_rigid_body.recording.segments import MOST_SEGMENTS, declared_segments
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation.segment import LONGEST_SCENARIO_TEXT, Segment
from lie_rigid_body.system.bounded_input import LARGEST_CHUNK, LONGEST_NUMBER

LARGE = 2 * LARGEST_CHUNK
MEMORY = 200 * 2**20
"""Bytes that a reader may take beside the libraries: much less than a large chunk inflated."""
READ = f"""
import resource, sys
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.segments import MOST_SEGMENTS
pages = int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (pages * {resource.getpagesize()} + {MEMORY},) * 2)
for path in sys.argv[1:]:
    try:
        read_bag(path)
    except BagError as error:
        print(error)
"""


def bag(path: Path, *records: bytes) -> Path:
    path.write_bytes(framed(*records))
    return path


def zeros(compression: str) -> bytes:
    """So many bytes of zero, compressed."""
    if compression == "zstd":
        parts = zstandard.ZstdCompressor().chunker(size=LARGE)
        return b"".join(
            [*(out for _ in range(LARGE // 2**24) for out in parts.compress(bytes(2**24))), *parts.finish()]
        )
    frame = lz4.frame.LZ4FrameCompressor()
    return b"".join([frame.begin(), *(frame.compress(bytes(2**24)) for _ in range(LARGE // 2**24)), frame.flush()])


def test_what_does_not_fit_is_refused_before_it_is_there(tmp_path: Path) -> None:
    sparse = bag(tmp_path / "sparse.mcap")
    with open(sparse, "r+b") as stream:
        stream.seek(len(MAGIC))
        stream.write(struct.pack("<BQ", 5, 2**35))
        stream.truncate(2**36)
        stream.seek(0, os.SEEK_END)
        stream.write(MAGIC)
    wanted = {sparse: f"a record of {2**35} bytes, more than is read"}
    for compression in ("zstd", "lz4"):
        data = zeros(compression)
        honest = bag(tmp_path / f"honest_{compression}.mcap", chunk(compression, LARGE, data))
        lying = bag(tmp_path / f"lying_{compression}.mcap", chunk(compression, 100, data))
        wanted[honest] = f"a chunk of {LARGE} bytes, more than is read"
        wanted[lying] = "a chunk does not inflate to the 100 bytes that it declares"
    done = subprocess.run([sys.executable, "-c", READ, *wanted], capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    assert [said for line, said in zip(lines, wanted.values(), strict=True) if said not in line] == []


@pytest.mark.parametrize("size", [0, 1, 1000, 131_072, 131_073, 500_000])
def test_frames_of_every_kind_of_block_are_read(size: int) -> None:
    """Of zstd blocks are compressed, as they are, or runs of one byte; with and without the size and a checksum."""
    for data in (np.random.default_rng(1).bytes(size), bytes(size), (b"some text " * size)[:size]):
        frames = [
            zstandard.ZstdCompressor(write_content_size=known, write_checksum=summed).compress(data)
            for known in (True, False)
            for summed in (True, False)
        ]
        for compression, frame in [*(("zstd", one) for one in frames), ("lz4", lz4.frame.compress(data))]:
            assert inflated(Chunk(compression, frame, 0, 0, 0, size)) == data


def test_messages_far_larger_than_their_file_are_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", 2**16)
    with open(tmp_path / "x.mcap", "wb") as out:
        writer = Writer(out, compression=CompressionType.ZSTD)
        writer.start("ros2", "a forger")
        channel = writer.register_channel("/chatter", "cdr", writer.register_schema(STRING, "ros2msg", b""))
        for _ in range(8):
            writer.add_message(channel, 0, bytes(2**20), 0)
        writer.finish()
    with refused("too much"):
        BagFiles(tmp_path / "x.mcap").contents(of_types([STRING]))


NAMES = {
    "nul": ('["a\\0b.mcap"]', refused("null")),
    "long": (f"[{300 * 'a'}.mcap]", refused("name too long")),
    "nested": (5000 * "[", refused("metadata")),
    "alias": ("[&a x.mcap, *a]", refused("metadata")),
    "number": ("3", refused("metadata")),
    "twice": ("[x.mcap, x.mcap]", refused("named twice", name="x.mcap")),
    "twice in other words": ("[x.mcap, ./x.mcap]", refused("named twice", name="./x.mcap")),
    "two lists": ("[secret], relative_file_paths: [x.mcap]", refused("metadata")),
    "device": ("[/dev/zero]", refused("outside", name="/dev/zero")),
    "above": ("[../../secret]", refused("outside", name="../../secret")),
    "away and back": ("[../bag/x/../../secret]", refused("outside", name="../bag/x/../../secret")),
    "link": ("[link.mcap]", refused("outside", name="link.mcap")),
    "folder": ("[.]", refused("folder as file")),
}


@pytest.mark.parametrize("case", NAMES)
def test_metadata_names_files(tmp_path: Path, case: str) -> None:
    names, error = NAMES[case]
    path = folder(tmp_path)
    (tmp_path / "secret").write_text("of somebody else")
    (path / "link.mcap").symlink_to(tmp_path / "secret")
    (path / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{relative_file_paths: {names}}}")
    with error as caught:
        read_bag(path)
    assert "somebody" not in str(caught.value)


@pytest.mark.parametrize(("name", "case"), [("bag_1.mcap.zstd", "packed"), ("bag_1.mcap", "link")])
def test_a_folder_without_metadata_holds_its_own_files_as_they_are(
    make_bag: MakeBag, tmp_path: Path, name: str, case: str
) -> None:
    path, elsewhere = tmp_path / "bag", make_bag()
    path.mkdir()
    (path / "bag_0.mcap").write_bytes(elsewhere.read_bytes())
    assert len(BagFiles(path).files) == 1
    (path / name).symlink_to(elsewhere)
    with refused(case, name=name):
        BagFiles(path)


@pytest.mark.parametrize("kind", ["topics_with_message_count", "files"])
def test_what_metadata_count_twice_is_refused(make_bag: MakeBag, tmp_path: Path, kind: str) -> None:
    """Readers take different ones."""
    path = tmp_path / "bag"
    path.mkdir()
    (path / "bag_0.mcap").write_bytes(make_bag().read_bytes())
    contents = BagFiles(path).contents(of_types([]))
    said: dict[str, Any] = {
        "relative_file_paths": ["bag_0.mcap"],
        "files": [{"path": "bag_0.mcap", "message_count": contents.files[0].count}],
        "topics_with_message_count": [
            {
                "topic_metadata": {"name": t.topic, "type": t.message_type, "serialization_format": t.encoding},
                "message_count": t.count,
            }
            for t in contents.tracks.values()
        ],
    }
    for twice in (False, True):
        said[kind] = [*([{**said[kind][0], "message_count": 1}] if twice else []), *said[kind]]
        (path / "metadata.yaml").write_text(json.dumps({"rosbag2_bagfile_information": said}))
        with refused("structure") if twice else nullcontext():
            BagFiles(path).contents(of_types([]))


@pytest.mark.parametrize(
    "form", ["{0}", "0{0:o}", "0{0}", "{0}.0", "0x{0:x}", "{0:_}", "{1}:{2:02}", "!!int 0{0:o}", "!!float {0}"]
)
def test_a_count_is_of_plain_digits(make_bag: MakeBag, tmp_path: Path, form: str) -> None:
    """Readers of YAML 1.1 and 1.2 take the others for different numbers, or for texts."""
    path = tmp_path / "bag"
    path.mkdir()
    (path / "bag_0.mcap").write_bytes(make_bag(count=1200).read_bytes())
    count = BagFiles(path).contents(of_types([])).files[0].count
    said = form.format(count, *divmod(count, 60))
    (path / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information: {{relative_file_paths: [bag_0.mcap], message_count: {said}}}"
    )
    with nullcontext() if form in ("{0}", "!!float {0}") else refused("count"):
        BagFiles(path).contents(of_types([]))


def test_a_topic_that_metadata_alone_tell_of_is_among_the_others(make_bag: MakeBag, tmp_path: Path) -> None:
    """Readers list it."""
    path = tmp_path / "bag"
    path.mkdir()
    (path / "bag_0.mcap").write_bytes(make_bag().read_bytes())
    topics = [
        {
            "topic_metadata": {"name": t.topic, "type": t.message_type, "serialization_format": t.encoding},
            "message_count": t.count,
        }
        for t in BagFiles(path).contents(of_types([])).tracks.values()
    ]
    ghost = {"name": "/ghost", "type": "std_msgs/msg/String", "serialization_format": "cdr"}
    topics.append({"topic_metadata": ghost, "message_count": 0})
    said = {"relative_file_paths": ["bag_0.mcap"], "topics_with_message_count": topics}
    assert not read_bag(path).others
    (path / "metadata.yaml").write_text(json.dumps({"rosbag2_bagfile_information": said}))
    bag = read_bag(path)
    assert ["/ghost" in other for other in bag.others] == [True]
    assert not bag.undefined


@pytest.mark.parametrize("files", [[], ["../../bag_0.mcap"], ["/bag/bag_0.mcap"], ["bag_0.mcap", "bag_1.mcap"]])
def test_the_files_that_metadata_tell_of_are_those_that_they_name(
    make_bag: MakeBag, tmp_path: Path, files: list[str]
) -> None:
    path = tmp_path / "bag"
    path.mkdir()
    (path / "bag_0.mcap").write_bytes(make_bag().read_bytes())
    said: dict[str, Any] = {"relative_file_paths": ["bag_0.mcap"], "files": [{"path": "bag_0.mcap"}]}
    for given in (["bag_0.mcap"], files):
        said["files"] = [{"path": name} for name in given]
        (path / "metadata.yaml").write_text(json.dumps({"rosbag2_bagfile_information": said}))
        with refused("files") if given is files else nullcontext():
            BagFiles(path).contents(of_types([]))


def test_files_of_which_some_have_indexes_of_messages_are_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    """Readers that seek read the others only."""
    path, source = tmp_path / "bag", make_bag(count=30)
    path.mkdir()
    for second in (IndexType.ALL, IndexType.NONE):
        for number, index_types in enumerate((IndexType.ALL, second)):
            rewrite(source, path / f"bag_{number}.mcap", index_types=index_types)
        with refused("mixed indexes") if second == IndexType.NONE else nullcontext():
            BagFiles(path).contents(of_types([]))


def test_each_file_of_a_bag_allows_for_its_own_messages(
    make_bag: MakeBag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "folder"
    path.mkdir()
    for i in range(3):
        make_bag(f"folder/folder_{i}.mcap", count=200)
    contents = BagFiles(path / "folder_0.mcap").contents(of_types([POSE_STAMPED]))
    [key] = [track.key for track in contents.tracks.values() if track.message_type == POSE_STAMPED]
    first = contents.messages(key)
    one = len(first.data) + 100 * len(first)
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", one)
    monkeypatch.setattr(bag_files, "_KEPT_PER_BYTE", 0)
    whole = BagFiles(path).contents(of_types([POSE_STAMPED])).messages(key)
    assert (len(whole), len(whole.data)) == (600, 3 * len(first.data))
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", one - 1)
    with refused("too much of one file", size=one):
        BagFiles(path).contents(of_types([POSE_STAMPED]))


def test_a_pipe_is_no_bag(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.mcap")
    for given in (tmp_path / "x.mcap", tmp_path):
        with refused("pipe", name="x.mcap"):
            read_bag(given)


def test_a_name_too_long_is_refused(tmp_path: Path) -> None:
    with refused("name too long"):
        read_bag(tmp_path / (300 * "a"))


def test_files_are_sorted_by_any_name(make_bag: MakeBag, tmp_path: Path) -> None:
    whole = make_bag(count=3)
    path = tmp_path / "folder"
    path.mkdir()
    whole.rename(path / "1²3.mcap")
    assert len(read_bag(path).poses.stamps_ns) == 3


def test_a_scenario_message_is_short_and_flat() -> None:
    with refused("long scenario", length=LONGEST_SCENARIO_TEXT + 1, most=LONGEST_SCENARIO_TEXT):
        Segment.from_json("[" * (LONGEST_SCENARIO_TEXT + 1))
    for text, error in (
        ('{"rate": 1, "rate": 2}', refused("key twice", key="rate")),
        ("[]", refused("no object")),
        ('{"first_sample": 0}', refused("no key", key="start_ns")),
        ("[" * LONGEST_SCENARIO_TEXT, refused("nested")),
        (f'{{"software": -{"7" * 5000}}}', refused("long integer", length=5001, most=LONGEST_NUMBER)),
    ):
        with error:
            Segment.from_json(text)


def test_many_resets_take_little_time(make_bag: MakeBag) -> None:
    """What takes most of it, a scenario, is made once; and there is a limit."""
    start = Segment(Scenario.from_parameters(), 0, 0)
    texts = [replace(start, first_sample=i, start_ns=i * 10_000_000).to_json() for i in range(3)]
    first, second, _ = (Segment.from_json(text) for text in texts)
    assert first.scenario is second.scenario
    assert (second.first_sample, second.start_ns) == (1, 10_000_000)
    recording = replace(read_bag(make_bag()), scenario_texts=[(i, str(i)) for i in range(MOST_SEGMENTS + 1)])
    with refused("segments", count=MOST_SEGMENTS + 1, most=MOST_SEGMENTS):
        declared_segments(text for _, text in recording.scenario_texts)
