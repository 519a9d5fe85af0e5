"""``recover`` as its users meet it."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import Writer

from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.cli.recover import main as recover
from lie_rigid_body.recording.records import MAGIC


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
    assert f"{count} messages on 3 topics, stamps 0.000000000 to {last:.2f}0000000 s, in {fixed} (" in much
    assert wrong.startswith(f"{broken} breaks off in the record at byte ")
    assert remedy == f"certify them with: lie-rigid-body check '{fixed}'"
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
    for cut, said, refused in (
        (end, "behind a whole record", "it holds at least 201 whole messages: "),
        (end - 200, f"in the record at byte {first}, which gave ", "it may hold whole messages: "),
    ):
        bag.write_bytes(data[:cut])
        assert recover([str(bag), "-o", str(fixed), "--force"]) == 0
        assert f"{bag} breaks off {said}" in capsys.readouterr().out
        assert check([str(bag)]) == 2
        assert f" was cut off, or is still being written: {refused}rescue them with " in capsys.readouterr().err


def test_an_existing_file_is_kept_without_force(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fixed = broken.with_name("fixed.mcap")
    fixed.write_text("precious")
    assert recover([str(broken), "-o", str(fixed)]) == 2
    assert fixed.read_text() == "precious"
    assert recover([str(broken), "-o", str(fixed), "--force"]) == 0
    assert check([str(fixed)]) == 0


def test_an_output_without_room_is_blamed_itself(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fixed, before = broken.with_name("fixed.mcap"), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        assert recover([str(broken), "-o", str(fixed)]) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "fixed.mcap" in capsys.readouterr().err
    assert not fixed.exists()


@pytest.fixture
def split(broken: Path) -> Path:
    """A rosbag2 folder whose recorder was killed: no metadata, the second file lacks its end, the third is empty."""
    whole, folder = broken.with_name("whole.mcap"), broken.with_name("my run")
    assert record([str(whole), "--duration", "2", "-p", "motion:=closed_form", "--quiet"]) == 0
    folder.mkdir()
    with whole.open("rb") as stream:
        messages = list(make_reader(stream).iter_messages(log_time_order=False))
    for i, some in enumerate((messages[:201], messages[201:])):
        with (folder / f"my run_{i}.mcap").open("wb") as stream:
            writer = Writer(stream, chunk_size=4000)
            writer.start("ros2", "rosbag2")
            channels = {}
            for schema, channel in {c.id: (s, c) for s, c, _ in messages}.values():
                assert schema is not None
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, number)
            for _, channel, m in some:
                writer.add_message(channels[channel.id], m.log_time, m.data, m.publish_time, m.sequence)
            writer.finish()
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
    assert f"{(count - 2) // 2 * 0.01:.2f}0000000" in much
    assert cut.startswith(f"{split / 'my run_1.mcap'} breaks off in the record at byte ")
    assert empty.startswith(f"{split / 'my run_2.mcap'} does not begin as an MCAP file")
    assert remedy == f"certify them with: lie-rigid-body check '{fixed}'"
    assert metadata.endswith(f"ros2 bag reindex '{fixed}'")
    assert sorted(path.name for path in fixed.iterdir()) == ["my fixed_0.mcap", "my fixed_1.mcap"]
    assert check([str(fixed)]) == 0
    assert {path: path.read_bytes() for path in split.iterdir()} == before


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("there", "exists and is kept: give the name of a new folder"),
        ("fixed.mcap", "is to be one: give a name that does not end in .mcap"),
        ("my run/fixed", "is in the broken folder itself"),
        ("none/fixed", "cannot be created: No such file or directory"),
    ],
)
def test_a_folder_is_made_only_where_none_is(
    split: Path, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    split.with_name("there").mkdir()
    before = sorted(split.parent.rglob("*"))
    assert recover([str(split), "-o", str(split.parent / name), "--force"]) == 2
    assert said in capsys.readouterr().err
    assert sorted(split.parent.rglob("*")) == before


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
    assert capsys.readouterr().out.splitlines()[-1].endswith(f"recover all with: recover '{split}' -o FIXED")
    fixed.replace(part)
    assert check([str(part)]) == 2
    assert capsys.readouterr().err.endswith("/my run\n")


def test_a_killed_recording_is_recovered_and_certified(tmp_path: Path) -> None:
    broken, fixed = tmp_path / "killed.mcap", tmp_path / "fixed.mcap"
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(broken), "-p", "motion:=closed_form"]
    with subprocess.Popen([*command, "--duration", "100000", "--quiet"]) as process:
        while not broken.exists() or broken.stat().st_size < 300_000:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    assert recover([str(broken), "-o", str(fixed)]) == 0
    assert check([str(fixed)]) == 0
