"""A folder of one recording is one, however its files are called, and whatever its metadata count."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bags import MakeBag
from refused_bags import refused

from foreign_bags import bag_of, messages_of
from lie_rigid_body.recording.bag_files import BagFiles, bags_in
from lie_rigid_body.recording.bag_reader import read_bag

LYRICAL = [f"{number}_run_2026_05_22-10_0{number}_59.mcap" for number in range(3)]
NAMES = {
    "of the folder": [f"run_{number}.mcap" for number in range(3)],
    "of a folder that was renamed": [f"rosbag2_2026_05_22-10_00_00_{number}.mcap" for number in range(11)],
    "as in ROS 2 Lyrical": LYRICAL,
}
OTHERS = {
    "another prefix": ["a_0.mcap", "b_1.mcap"],
    "a number is missing": ["a_0.mcap", "a_2.mcap"],
    "no number": ["a.mcap", "a_0.mcap"],
    "a Lyrical one among others": [LYRICAL[0], "run_1.mcap"],
    "runs of this package": ["spin_0.mcap", "spin_1.mcap"],
}


def recorded(source: Path, folder: Path, names: list[str], library: str = "libmcap 1.0") -> Path:
    """A recording of the messages of a bag, split into files as by a recorder that was killed."""
    folder.mkdir()
    messages = messages_of(source)
    each = -(-len(messages) // len(names))
    for number, name in enumerate(names):
        (folder / name).write_bytes(bag_of(messages[number * each : (number + 1) * each], library))
    return folder


def described(folder: Path, names: list[str], **information: object) -> None:
    said = {"version": 9, "storage_identifier": "mcap", "relative_file_paths": names, **information}
    (folder / "metadata.yaml").write_text(json.dumps({"rosbag2_bagfile_information": said}))


@pytest.mark.parametrize("case", NAMES)
def test_the_files_of_a_recording_are_one_bag(make_bag: MakeBag, tmp_path: Path, case: str) -> None:
    folder = recorded(make_bag(count=50), tmp_path / "run", NAMES[case])
    stamps = [10_000_000 * k for k in range(50)]
    for _ in range(2):
        assert bags_in(tmp_path / "run") == [folder]
        assert read_bag(folder).poses.stamps_ns.tolist() == stamps
        described(folder, NAMES[case])


@pytest.mark.parametrize("case", OTHERS)
def test_files_of_several_recordings_are_none(make_bag: MakeBag, tmp_path: Path, case: str) -> None:
    library = "lie_rigid_body 1.0.0" if "this package" in case else "libmcap 1.0"
    folder = recorded(make_bag(count=5), tmp_path / "run", OTHERS[case], library)
    with refused("several bags", count=2):
        read_bag(folder)
    assert len(bags_in(folder)) == 2


@pytest.mark.parametrize(
    "information",
    [
        {"files": [], "message_count": 101},
        {"files": [{"path": "run_0.mcap", "message_count": 7}], "message_count": 0, "topics_with_message_count": []},
        {"duration": {"nanoseconds": 0}, "starting_time": {"nanoseconds_since_epoch": 2**63}},
        {"message_count": "0311", "topics_with_message_count": 3, "storage_identifier": "sqlite3"},
        {"compression_mode": "FILE", "compression_format": "zstd"},
    ],
)
def test_what_metadata_count_is_a_hint(make_bag: MakeBag, tmp_path: Path, information: dict[str, object]) -> None:
    """`ros2 bag reindex` writes ``files: []``. Files that were compressed are named so when they are unpacked."""
    folder = recorded(make_bag(count=50), tmp_path / "run", NAMES["of the folder"])
    packed = ".zstd" if "compression_mode" in information else ""
    described(folder, [f"{name}{packed}" for name in NAMES["of the folder"]], **information)
    assert len(read_bag(folder).poses) == 50


@pytest.mark.parametrize("content", ["3", "[", "{relative_file_paths: 3}", "{relative_file_paths: [&a x.mcap, *a]}"])
def test_metadata_that_name_no_files_are_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {content}")
    with refused("metadata"):
        BagFiles(tmp_path)
