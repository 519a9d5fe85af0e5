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

from lie_rigid_body import Run
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_files import bags_in
from lie_rigid_body.recording.bag_reader import read_bag


def folder(tmp_path: Path, *names: str) -> Path:
    bag = tmp_path / "folder"
    bag.mkdir()
    files = "".join(f"\n  - {name}" for name in names)
    (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:{files}\n")
    return bag


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
    whole = make_bag(count=1500).read_bytes()
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
    path, damaged = make_bag(count=500), tmp_path / "damaged.mcap"
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
