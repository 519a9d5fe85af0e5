"""``recover`` as its users meet it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from mcap.opcode import Opcode

from foreign_bags import bag_of, messages_of
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.cli.recover import main as recover
from lie_rigid_body.recording.records import MAGIC
from said import numbers


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """A bag that lacks its end."""
    path = tmp_path / "broken.mcap"
    assert record([str(path), "--duration", "20", "-p", "motion:=closed_form", "--chunk-size", "20000", "--quiet"]) == 0
    os.truncate(path, path.stat().st_size // 2)
    return path


def test_it_says_how_much_and_up_to_which_stamp(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before, fixed = broken.read_bytes(), broken.with_name("my fixed.mcap")
    assert recover([str(broken), "-o", str(fixed)]) == 0
    much, wrong, remedy = capsys.readouterr().out.splitlines()
    count = int(much.partition(" ")[0])
    assert 1000 < count < 3000
    # messages are the scenario, then a pose and a twist every 10 ms
    last = (count - 2) // 2 * 0.01
    assert numbers(much)[:4] == [count, 3, 0, round(last, 2)]
    assert f" {fixed} (" in much
    assert wrong.startswith(f"{broken} ")
    assert remedy.endswith(f": lie-rigid-body check '{fixed}'")
    assert check([str(fixed)]) == 0
    assert broken.read_bytes() == before


def test_a_bag_that_ends_between_records_breaks_off_in_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As one whose recorder was killed between two chunks; of one whose only chunk is unfinished none is counted."""
    bag, fixed = tmp_path / "bag.mcap", tmp_path / "fixed.mcap"
    assert record([str(bag), "--duration", "1", "--compression", "none", "--quiet"]) == 0
    data = bag.read_bytes()
    first = len(MAGIC)
    while data[first] != Opcode.CHUNK:
        first += 9 + int.from_bytes(data[first + 1 : first + 9], "little")
    end = first + 9 + int.from_bytes(data[first + 1 : first + 9], "little")
    for cut, place, counted in ((end, [], "201"), (end - 200, [first], "")):
        bag.write_bytes(data[:cut])
        assert recover([str(bag), "-o", str(fixed), "--force"]) == 0
        broken = next(line for line in capsys.readouterr().out.splitlines() if line.startswith(f"{bag} "))
        assert numbers(broken.removeprefix(f"{bag} "))[:1] == place
        assert check([str(bag)]) == 2
        assert ("201" in capsys.readouterr().err) == bool(counted)


@pytest.fixture
def split(broken: Path) -> Path:
    """A rosbag2 folder whose recorder was killed: no metadata, the second file lacks its end, the third is empty."""
    whole, folder = broken.with_name("whole.mcap"), broken.with_name("my run")
    assert record([str(whole), "--duration", "2", "-p", "motion:=closed_form", "--quiet"]) == 0
    folder.mkdir()
    messages = messages_of(whole)
    topics = {message.topic: message.kind for message in messages}.items()
    for i, some in enumerate((messages[:201], messages[201:])):
        (folder / f"my run_{i}.mcap").write_bytes(bag_of(some, "rosbag2", topics=topics, chunk_size=4000))
    os.truncate(folder / "my run_1.mcap", (folder / "my run_1.mcap").stat().st_size // 2)
    (folder / "my run_2.mcap").touch()
    return folder


def test_a_folder_of_a_split_bag_makes_a_folder_that_is_certified(
    split: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before, fixed = {path: path.read_bytes() for path in split.iterdir()}, split.with_name("my fixed")
    assert recover([str(split), "-o", str(fixed)]) == 0
    much, cut, empty, remedy, metadata = capsys.readouterr().out.splitlines()
    count = int(much.partition(" ")[0])
    assert 201 < count < 401
    assert round((count - 2) // 2 * 0.01, 2) in numbers(much)
    assert cut.startswith(f"{split / 'my run_1.mcap'} ")
    assert empty.startswith(f"{split / 'my run_2.mcap'} ")
    assert remedy.endswith(f": lie-rigid-body check '{fixed}'")
    assert metadata.endswith(f"ros2 bag reindex '{fixed}'")
    assert sorted(path.name for path in fixed.iterdir()) == ["my fixed_0.mcap", "my fixed_1.mcap"]
    assert check([str(fixed)]) == 0
    assert {path: path.read_bytes() for path in split.iterdir()} == before


def named(folder: Path, *names: str) -> None:
    """Write the metadata of a bag of some files."""
    quoted = ", ".join(f"'{name}'" for name in names)
    text = f"rosbag2_bagfile_information: {{relative_file_paths: [{quoted}]}}"
    (folder / "metadata.yaml").write_text(text)


@pytest.mark.parametrize("instead", ["nothing", "folder", "pipe", "link to itself"])
def test_the_files_of_a_folder_are_those_that_its_metadata_name(
    split: Path, capsys: pytest.CaptureFixture[str], instead: str
) -> None:
    """One that is gone, or is none, is told and costs no other one; what stands there besides is none of them."""
    part, gone, more = (split / f"my run_{i}.mcap" for i in range(3))
    gone.unlink()
    {
        "nothing": lambda path: None,
        "folder": os.mkdir,
        "pipe": os.mkfifo,
        "link to itself": lambda path: path.symlink_to(path.name),
    }[instead](gone)
    more.write_bytes(part.read_bytes())
    named(split, part.name, gone.name)
    fixed = split.with_name("fixed")
    assert recover([str(split), "-o", str(fixed)]) == 0
    much, *told, _, _ = capsys.readouterr().out.splitlines()
    assert numbers(much)[0] == 201
    assert [line.partition(".mcap ")[0] + ".mcap" for line in told] == [str(gone)]
    assert [path.name for path in fixed.iterdir()] == ["fixed_0.mcap"]
    assert check([str(fixed)]) == 0


def test_a_folder_without_any_whole_message_makes_none(split: Path) -> None:
    for path in split.iterdir():
        os.truncate(path, 0)
    assert recover([str(split), "-o", str(split.with_name("fixed"))]) == 2
    assert not split.with_name("fixed").exists()


def test_who_gives_one_file_of_a_split_bag_is_told_to_give_the_folder(
    split: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part, fixed = split / "my run_1.mcap", split.with_name("part.mcap")
    assert recover([str(part), "-o", str(fixed)]) == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith(f": recover '{split}' -o FIXED")
    fixed.replace(part)
    assert check([str(part)]) == 2
    assert capsys.readouterr().err.endswith("/my run\n")
