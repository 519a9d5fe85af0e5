"""Bags that others wrote, and files that are no bags or no longer whole."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags import MakeBag, rewrite
from mcap.writer import CompressionType
from refused_bags import refused

from foreign_bags import bag_of, messages_of
from lie_rigid_body import Run
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_files import bags_in
from lie_rigid_body.recording.bag_reader import read_bag


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_bags_of_other_recorders_are_read(
    make_bag: MakeBag, tmp_path: Path, compression: CompressionType, chunked: bool
) -> None:
    own = read_bag(make_bag())
    path = rewrite(
        tmp_path / "bag.mcap",
        tmp_path / "other.mcap",
        lambda topic: f"/robot_3{topic}",
        compression=compression,
        use_chunking=chunked,
        enable_data_crcs=True,
    )
    other = read_bag(path)
    np.testing.assert_array_equal(other.poses.values[:, 3:], own.poses.values[:, 3:])
    np.testing.assert_array_equal(other.twists.values[:, 3:], own.twists.values[:, 3:])
    np.testing.assert_array_equal(other.poses.stamps_ns, own.poses.stamps_ns)
    np.testing.assert_array_equal(other.poses.log_times_ns, own.poses.log_times_ns + 5)
    assert other.pose_topic == "/robot_3/pose"
    assert other.library == "another recorder"
    assert other.expected_samples is None


def test_a_topic_with_two_channels_is_one(make_bag: MakeBag, tmp_path: Path) -> None:
    """As of two publishers, or of files that were joined: messages come in file order."""
    source, path = make_bag(count=60), tmp_path / "two.mcap"
    messages = [m._replace(publisher=number // 3 % 2) for number, m in enumerate(messages_of(source))]
    other = messages[1]._replace(kind="std_msgs/msg/Empty", definition=b"", data=bytes(4))
    path.write_bytes(bag_of([*messages, other], chunk_size=3000))
    own_bag, found = read_bag(source), read_bag(path)
    np.testing.assert_array_equal(found.poses.values[:, 3:], own_bag.poses.values[:, 3:])
    np.testing.assert_array_equal(found.twists.stamps_ns, own_bag.twists.stamps_ns)
    assert len({(m.topic, m.publisher) for m in messages}) > 3
    [stray] = found.others
    assert [part for part in (" /pose ", " std_msgs/msg/Empty, 1 ") if part not in stray] == []


def test_messages_stay_in_file_order(make_bag: MakeBag, tmp_path: Path) -> None:
    own = make_bag(count=4)
    payloads: list[bytes] = []

    def noted(number: int, topic: str, data: bytes) -> bytes:
        payloads.append(data)
        return data

    rewrite(own, tmp_path / "x.mcap", change=noted)
    swapped = {3: payloads[5], 5: payloads[3]}  # messages are scenario, pose, twist, pose, twist, pose …
    path = rewrite(own, tmp_path / "swapped.mcap", change=lambda number, topic, data: swapped.get(number, data))
    assert read_bag(path).poses.stamps_ns.tolist() == [0, 20_000_000, 10_000_000, 30_000_000]


def folder(tmp_path: Path, *names: str) -> Path:
    bag = tmp_path / "folder"
    bag.mkdir()
    files = "".join(f"\n  - {name}" for name in names)
    (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:{files}\n")
    return bag


@pytest.mark.parametrize("with_metadata", [True, False])
def test_a_rosbag2_folder_of_several_files_is_one_bag(make_bag: MakeBag, tmp_path: Path, with_metadata: bool) -> None:
    own = make_bag(count=30)
    names = [f"folder_{i}.mcap" for i in range(11)]
    bag = folder(tmp_path, *names)
    for i, name in enumerate(names):
        rewrite(own, bag / name, keep=lambda number, topic, i=i: i == min(number // 5, 10))  # type: ignore[misc]
    if not with_metadata:
        (bag / "metadata.yaml").unlink()
    recording = read_bag(bag)
    assert recording.poses.stamps_ns.tolist() == read_bag(own).poses.stamps_ns.tolist()


def test_a_folder_of_several_bags_is_not_one(make_bag: MakeBag, tmp_path: Path) -> None:
    """As ``check`` sees it: what two recordings tell is never merged into one run."""
    (tmp_path / "folder").mkdir()
    make_bag("folder/a.mcap", count=3)
    assert len(read_bag(tmp_path / "folder").poses.stamps_ns) == 3
    make_bag("folder/b.mcap", count=3)
    for read in (read_bag, Run.from_bag, lambda path: recorded_estimate(path, "/pose")):
        with refused("several bags", count=2):
            read(tmp_path / "folder")


def test_a_folder_that_is_no_bag_is_refused(tmp_path: Path) -> None:
    with refused("empty folder"):
        read_bag(tmp_path)
    with refused("file gone", name="none.mcap"):
        read_bag(folder(tmp_path, "none.mcap"))
    (tmp_path / "folder" / "metadata.yaml").write_text("[")
    with refused("no metadata"):
        read_bag(tmp_path / "folder")


@pytest.mark.parametrize("with_metadata", [True, False])
def test_a_bag_in_sqlite_is_found_and_refused(tmp_path: Path, with_metadata: bool) -> None:
    bag = folder(tmp_path, "folder_0.db3")
    (bag / "folder_0.db3").write_bytes(b"SQLite format 3\x00...")
    if not with_metadata:
        (bag / "metadata.yaml").unlink()
    assert bags_in(tmp_path) == [bag]
    with pytest.raises(BagError, match=r"folder_0\.db3 "):
        read_bag(bag)


def test_a_packed_file_among_bags_is_found_and_refused(tmp_path: Path) -> None:
    packed = tmp_path / "one.mcap.zstd"
    packed.write_bytes(zstandard.ZstdCompressor().compress(b"a bag"))
    (tmp_path / "two.mcap").touch()
    assert packed in bags_in(tmp_path)
    with pytest.raises(BagError, match="unzstd"):
        read_bag(packed)


def test_names_may_be_in_capitals(make_bag: MakeBag, tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    one, two = tmp_path / "a" / "ONE.MCAP", tmp_path / "a" / "b" / "two.Mcap"
    one.write_bytes(make_bag(count=4).read_bytes())
    two.write_bytes(one.read_bytes())
    assert bags_in(tmp_path / "a") == [one, two]
    assert len(read_bag(two.parent).poses.stamps_ns) == 4


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with refused("no file", name="none.mcap"):
        read_bag(tmp_path / "none.mcap")


def test_a_file_cut_anywhere_is_refused_as_cut_off(make_bag: MakeBag, tmp_path: Path) -> None:
    whole = make_bag(count=4000).read_bytes()
    cut = tmp_path / "cut.mcap"
    rng = np.random.default_rng(3)
    for size in [9, 20, len(whole) - 1, len(whole) - 8, len(whole) - 9, *rng.integers(9, len(whole), 60)]:
        cut.write_bytes(whole[:size])
        with refused("cut off") as caught:
            read_bag(cut)
        assert "\n" not in str(caught.value)
    cut.write_bytes(whole[: len(whole) // 2] + bytes(1000))
    with refused("cut off"):
        read_bag(cut)


@pytest.mark.long
def test_a_flipped_bit_is_refused_or_changes_nothing(make_bag: MakeBag, tmp_path: Path) -> None:
    """Each byte of the data section is under a checksum; what stands behind it are hints."""
    path, damaged = make_bag(count=1500), tmp_path / "damaged.mcap"
    whole, honest = path.read_bytes(), read_bag(path)
    size, data_end = len(whole), whole.rindex(b"\x0f\x04\0\0\0\0\0\0\0")
    places = {*range(0, 60, 3), *range(size - 1200, size, 7), *np.random.default_rng(5).integers(0, size, 60).tolist()}
    for at in sorted(places | {size - 1}):
        damaged.write_bytes(whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :])
        try:
            found = read_bag(damaged)
        except BagError:
            continue
        assert at >= data_end
        np.testing.assert_array_equal(found.poses.values, honest.poses.values)


def test_a_chunk_whose_checksum_differs_is_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", compression=CompressionType.NONE)
    content = path.read_bytes()
    at = content.index(b"base_link")
    path.write_bytes(content[:at] + b"base_lynk" + content[at + 9 :])
    with refused("checksum"):
        read_bag(path)


@pytest.mark.parametrize("missing", ["/pose", "/twist", "/lie_rigid_body/scenario"])
def test_a_missing_topic_is_named_with_those_that_are_there(make_bag: MakeBag, tmp_path: Path, missing: str) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", lambda topic: None if topic == missing else topic)
    with refused("topics of a type", name=missing.rpartition("/")[2]) as caught:
        read_bag(path)
    assert f"{missing}," not in str(caught.value)


def test_topics_of_several_bodies_are_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    own = make_bag(count=3)
    bag = folder(tmp_path, "a.mcap", "b.mcap")
    for name in "ab":
        rewrite(own, bag / f"{name}.mcap", lambda topic, name=name: f"/{name}{topic}")  # type: ignore[misc]
    with refused("bodies", pose="/a/pose"):
        read_bag(bag)


@pytest.mark.parametrize("other", ["/x/scenario", "/scenario"])
def test_texts_that_another_node_calls_scenario_are_none(make_bag: MakeBag, tmp_path: Path, other: str) -> None:
    own, bag, text = make_bag(count=3), folder(tmp_path, "a.mcap", "b.mcap"), b"\0\1\0\0\x0a\0\0\0highway 7\0"
    rewrite(own, bag / "a.mcap")
    rename = {"/lie_rigid_body/scenario": other}.get
    rewrite(own, bag / "b.mcap", rename, change=lambda number, topic, data: text)
    found = read_bag(bag)
    assert len(found.scenario_texts) == 1
    assert any(f" {other} (1 " in text for text in found.others)


def test_remapped_topics_are_found_by_their_types(make_bag: MakeBag, tmp_path: Path) -> None:
    own = make_bag()
    names = {"/pose": "/truth", "/twist": "/truth_rate"}
    remapped = read_bag(rewrite(own, tmp_path / "x.mcap", lambda topic: names.get(topic, topic)))
    assert (remapped.pose_topic, remapped.twist_topic) == ("/truth", "/truth_rate")
    np.testing.assert_array_equal(remapped.poses.values[:, 3:], read_bag(own).poses.values[:, 3:])


def test_a_topic_without_messages_is_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", keep=lambda number, topic: topic != "/twist")
    with refused("no message", topic="/twist"):
        read_bag(path)


def test_without_a_scenario_topic_an_inertia_is_not_enough(make_bag: MakeBag, tmp_path: Path) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", lambda topic: topic if topic in ("/pose", "/twist") else None)
    with refused("no scenario"):
        read_bag(path)


def test_messages_compressed_one_by_one_are_refused_by_the_name_of_the_option(
    make_bag: MakeBag, tmp_path: Path
) -> None:
    """As ``ros2 bag record --compression-mode message --compression-format zstd`` writes them."""
    path = rewrite(make_bag(), tmp_path / "x.mcap", change=lambda number, topic, data: zstandard.compress(data))
    with refused("compressed messages"):
        read_bag(path)
    bag = folder(tmp_path, "x.mcap")
    path.rename(bag / "x.mcap")
    with (bag / "metadata.yaml").open("a") as metadata:
        metadata.write("  compression_mode: MESSAGE\n  compression_format: zstd\n")
    with refused("compressed messages"):
        read_bag(bag)


@pytest.mark.parametrize(
    ("compression", "library"), [(CompressionType.LZ4, "lz4"), (CompressionType.ZSTD, "zstandard")]
)
def test_a_library_that_is_missing_is_no_damage(
    make_bag: MakeBag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionType, library: str
) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", compression=compression)
    for name in (library, f"{library}.frame"):  # the second may be loaded already
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ModuleNotFoundError) as caught:
        read_bag(path)
    assert str(caught.value.name).startswith(library)


def test_a_malformed_message_is_named(make_bag: MakeBag, tmp_path: Path) -> None:
    path = rewrite(
        make_bag(), tmp_path / "x.mcap", change=lambda number, topic, data: data[:-1] if number == 7 else data
    )
    with refused("size of a message", topic="/pose", number=3):
        read_bag(path)


def test_another_encoding_is_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", encoding="json")
    with refused("encoding", name="json"):
        read_bag(path)
