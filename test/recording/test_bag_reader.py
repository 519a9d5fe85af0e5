"""Bags that others wrote, and files that are no bags or no longer whole."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from bags import COMPRESSIONS, MakeBag, rewrite
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


@pytest.mark.parametrize("with_metadata", [True, False])
def test_a_bag_in_sqlite_is_found_and_refused(tmp_path: Path, with_metadata: bool) -> None:
    bag = folder(tmp_path, "folder_0.db3")
    (bag / "folder_0.db3").write_bytes(b"SQLite format 3\x00...")
    if not with_metadata:
        (bag / "metadata.yaml").unlink()
    assert bags_in(tmp_path) == [bag]
    with pytest.raises(BagError, match=r"folder_0\.db3 "):
        read_bag(bag)


def test_names_may_be_in_capitals_and_of_packed_files(make_bag: MakeBag, tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    found, content = [tmp_path / "a" / name for name in ("ONE.MCAP", "b/1²3.Mcap", "one.mcap.zstd")], make_bag(count=4)
    for path in found:
        path.write_bytes(content.read_bytes())
    assert {*bags_in(tmp_path / "a")} == {*found}
    assert len(read_bag(tmp_path / "a" / "b").poses.stamps_ns) == 4


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


@pytest.mark.parametrize("missing", ["/pose", "/twist", "/lie_rigid_body/scenario"])
def test_a_missing_topic_is_named_with_those_that_are_there(make_bag: MakeBag, tmp_path: Path, missing: str) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", lambda topic: None if topic == missing else topic)
    with refused("topics of a type", name=missing.rpartition("/")[2]) as caught:
        read_bag(path)
    assert f"{missing}," not in str(caught.value)


@pytest.mark.parametrize("other", ["/x/scenario", "/scenario"])
def test_texts_that_another_node_calls_scenario_are_none(make_bag: MakeBag, tmp_path: Path, other: str) -> None:
    own, bag, text = make_bag(count=3), folder(tmp_path, "a.mcap", "b.mcap"), b"\0\1\0\0\x0a\0\0\0highway 7\0"
    rewrite(own, bag / "a.mcap")
    rename = {"/lie_rigid_body/scenario": other}.get
    rewrite(own, bag / "b.mcap", rename, change=lambda number, topic, data: text)
    found = read_bag(bag)
    assert len(found.scenario_texts) == 1
    assert any(f" {other} (1 " in text for text in found.others)


@pytest.mark.parametrize(("compression", "library"), [("lz4", "lz4"), ("zstd", "zstandard")])
def test_a_library_that_is_missing_is_no_damage(make_bag: MakeBag, tmp_path, monkeypatch, compression, library) -> None:
    path = rewrite(make_bag(), tmp_path / "x.mcap", compression=COMPRESSIONS[compression])
    for name in (library, f"{library}.frame"):  # the second may be loaded already
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ModuleNotFoundError) as caught:
        read_bag(path)
    assert str(caught.value.name).startswith(library)
