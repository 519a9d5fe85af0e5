"""``check`` with several bags, folders of bags, and bags of several bodies."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from test_check import refused, write_bag

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.cli import checking
from lie_rigid_body.cli.check import main
from lie_rigid_body.cli.checking import judge_all
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.report.overview import Verdict


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    """A folder with two good bags, one that breaks laws in a folder below, one cut off, and what is no bag."""
    folder = tmp_path / "runs"
    (folder / "poor").mkdir(parents=True)
    (folder / ".hidden").mkdir()
    good = write_bag(folder / "10.mcap", 40)
    os.link(good, folder / "9.mcap")
    os.link(good, folder / ".hidden" / "x.mcap")
    write_bag(folder / "poor" / "run.mcap", method="rkmk1")
    (folder / "cut.mcap").write_bytes(good.read_bytes()[:-100])
    (folder / "runs.parquet").write_bytes(b"PAR1")
    return folder


def merged(target: Path, *, renamed: tuple[str, str] = ("", ""), late_ns: int = 0, **sources: Path) -> Path:
    """One bag with the topics of each source in the namespace of its name, perhaps one renamed and all logged late."""
    with target.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "a recorder")
        for namespace, source in sources.items():
            channels: dict[str, int] = {}
            with source.open("rb") as content:
                for schema, channel, message in make_reader(content).iter_messages(log_time_order=False):
                    assert schema is not None
                    if channel.topic not in channels:
                        own = writer.register_schema(schema.name, schema.encoding, schema.data)
                        name = f"/{namespace}{channel.topic}".replace(*renamed)
                        channels[channel.topic] = writer.register_channel(name, channel.message_encoding, own)
                    late = message.log_time + late_ns, message.publish_time + late_ns
                    writer.add_message(channels[channel.topic], late[0], message.data, late[1])
        writer.finish()
    return target


@pytest.fixture
def two_bodies(tmp_path: Path) -> Path:
    good, poor = write_bag(tmp_path / "good.mcap", 40), write_bag(tmp_path / "poor.mcap", 50, method="rkmk1")
    return merged(tmp_path / "two.mcap", a=good, b=poor)


def answer(capsys, *arguments: str | Path) -> tuple[int, list[str], list[str]]:
    """Exit status, and the lines of stdout and stderr."""
    status = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return status, out.splitlines(), err.splitlines()


def test_each_bag_of_a_folder_has_a_row(runs, capsys):
    status, out, err = answer(capsys, runs)
    rows = [line.split() for line in out[1:5]]
    assert [(row[0], Path(row[-1]).relative_to(runs).as_posix()) for row in rows] == [
        ("certified", "9.mcap"),
        ("certified", "10.mcap"),
        ("unusable", "cut.mcap"),
        ("BROKEN", "poor/run.mcap"),
    ]
    assert rows[0][1] == "40"
    assert float(rows[0][2]) < 1e-14
    assert len(err) == 1
    assert "cut.mcap" in err[0]
    assert status == 2  # not every bag could be judged


@pytest.mark.usefixtures("asked_here")
def test_the_status_is_the_worst_of_all(runs, capsys):
    good, poor = runs / "9.mcap", runs / "poor" / "run.mcap"
    status, _, err = answer(capsys, good, runs / "10.mcap")
    assert (status, err) == (0, [])
    assert answer(capsys, good, poor)[0] == 1
    assert answer(capsys, runs / "poor", poor)[0] == 1
    assert answer(capsys, poor, good, runs / "absent.mcap")[0] == 2


def test_a_link_to_itself_stops_no_other_bag(runs, capsys):
    circle = runs / "circle.mcap"
    circle.symlink_to(circle.name)
    status, out, [line] = answer(capsys, circle, runs / "9.mcap")
    assert [row.split()[0] for row in out[1:3]] == ["unusable", "certified"]
    assert (status, os.strerror(errno.ELOOP) in line, "circle.mcap" in line) == (2, True, True)


@pytest.mark.usefixtures("asked_here")
def test_a_bag_that_is_named_twice_is_judged_once(runs, capsys):
    _, out, _ = answer(capsys, runs / "9.mcap", runs / ".." / "runs" / "9.mcap", runs)
    assert sum(line.endswith("9.mcap") for line in out) == 1


@pytest.mark.usefixtures("asked_here")
def test_json_of_several_has_what_each_has_alone(runs, capsys):
    status, out, _ = answer(capsys, "--json", runs)
    content = json.loads("\n".join(out))
    assert status == 2
    assert [content[key] for key in ("passed", "certified", "broken", "unusable")] == [False, 2, 1, 1]
    good, _, cut, poor = content["bags"]
    assert cut == {"bag": str(runs / "cut.mcap"), "body": None, "passed": None, "error": cut["error"]}
    assert poor["passed"] is False
    _, alone, _ = answer(capsys, "--json", runs / "9.mcap")
    assert json.loads("\n".join(alone)) | {"body": None} == good


@pytest.mark.usefixtures("asked_here")
def test_a_folder_without_bags_is_unusable(tmp_path, capsys):
    status, _, err = answer(capsys, tmp_path)
    assert (status, len(err)) == (2, 1)


@pytest.mark.usefixtures("asked_here")
def test_a_recording_without_metadata_is_one_bag(tmp_path, capsys):
    folder = tmp_path / "walk"
    folder.mkdir()
    bag = write_bag(folder / "walk_0.mcap", 40)
    status, out, _ = answer(capsys, folder)
    assert (status, out[0]) == (0, str(folder))
    bag.rename(folder / "other_0.mcap")
    status, out, _ = answer(capsys, folder)
    assert (status, out[1].split()[-1]) == (0, str(folder / "other_0.mcap"))


@pytest.mark.usefixtures("asked_here")
def test_a_lone_file_of_a_split_bag_says_which_is_missing(tmp_path, capsys):
    folder = tmp_path / "walk"
    folder.mkdir()
    write_bag(folder / "walk_0.mcap", 40)
    merged(folder / "walk_2.mcap")  # without the scenario, which the first file has
    status, out, err = answer(capsys, folder)
    assert (status, len(err)) == (2, 1)
    assert "walk_1.mcap" in err[0]
    assert [line.split()[0] for line in out[1:3]] == ["certified", "unusable"]
    (folder / "walk_2.mcap").rename(folder / "other.mcap")
    assert "walk_1.mcap" not in answer(capsys, folder)[2][0]


@pytest.mark.usefixtures("asked_here")
def test_one_bag_is_counted_as_one(tmp_path, capsys):
    write_bag(tmp_path / "gaps.mcap", 40)
    assert answer(capsys, tmp_path)[0] == 0
    merged(tmp_path / "gaps.mcap", a=write_bag(tmp_path / "imu.mcap", 40, imu_rate=10.0))  # without a reading
    (tmp_path / "imu.mcap").unlink()
    status, out, _ = answer(capsys, tmp_path)
    assert status == 1
    assert re.fullmatch(r"BROKEN +40 +IMU stamps +\d+ of 0 .*gaps.mcap", out[1])


@pytest.mark.usefixtures("asked_here")
def test_each_body_of_a_bag_has_its_certificate(two_bodies, capsys):
    status, out, err = answer(capsys, two_bodies)
    assert (status, err) == (1, [])
    assert [line.split()[:: len(line.split()) - 1] for line in out[1:3]] == [["certified", "/a"], ["BROKEN", "/b"]]
    content = json.loads("\n".join(answer(capsys, two_bodies, "--json")[1]))
    assert [(bag["body"], bag["passed"]) for bag in content["bags"]] == [("/a", True), ("/b", False)]
    assert not any("/b/" in text for text in content["bags"][0]["not_certified"])
    status, out, _ = answer(capsys, two_bodies, "--topic", "pose:=/a/pose")
    assert (status, out[0]) == (0, str(two_bodies))
    assert " ".join(out).count("/b/pose") == 1  # as of another body, and not as a stray topic too


@pytest.mark.usefixtures("asked_here")
def test_a_table_tells_what_of_its_bags_is_not_certified(tmp_path, capsys):
    """Topics beside the bodies' own, and those that a recorder did not get: each once, with where that is."""
    pytest.importorskip("plotly")
    good, with_imu = write_bag(tmp_path / "good.mcap", 40), tmp_path / "imu.mcap"
    assert record([str(with_imu), "--duration", "0.2", "-p", "imu_rate:=50.0", "--quiet"]) == 0
    two = tmp_path / "two.mcap"
    merged(two, renamed=("/b/imu/data_raw", "/b/imu/raw"), late_ns=1000, a=good, b=with_imu)
    other, page = Path(shutil.copy(two, tmp_path / "other.mcap")), tmp_path / "page.html"
    status, out, _ = answer(capsys, two, "--report", page)
    said = " ".join(" ".join(out).split())
    assert (status, said.count("/imu/raw"), said.count("imu/data_raw")) == (0, 1, 1)
    assert re.search(rf"/b/imu/raw .*\({two}\).* imu/data_raw.*\({two} /b\)", said)
    assert re.search(rf"<li>.*/b/imu/raw .*\({two}\)</li><li>imu/data_raw", page.read_text(encoding="utf-8"))
    said = " ".join(" ".join(answer(capsys, two, other, good)[1]).split())
    assert re.search(r"/b/imu/raw [^)]+\)[^)]+\(2 of 3 ", said)
    assert (said.count("/imu/raw"), said.count("imu/data_raw")) == (1, 1)
    assert "imu" not in " ".join(answer(capsys, good, with_imu)[1]).replace(str(with_imu), "")


def deadly(inertia, topics, bag):
    if bag == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    return [Verdict(bag, None, Certificate(()))]


def test_a_process_that_dies_costs_its_bag_only(monkeypatch):
    monkeypatch.setattr(checking, "judge", deadly)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1})
    found = judge_all(["a", "deadly", "b", "c"])
    assert [(each.bag, each.status) for each in found] == [("a", 0), ("deadly", 2), ("b", 0), ("c", 0)]
    assert found[1].reason.startswith("deadly: ")


def with_messages(target: Path, source: Path, topic: str, message: bytes | None) -> None:
    """A bag with another message, or none, in place of each on the topics that end so."""
    with target.open("wb") as stream, source.open("rb") as content:
        writer = Writer(stream)
        writer.start("ros2", "a recorder")
        for schema, channel, each in make_reader(content).iter_messages(log_time_order=False):
            assert schema is not None
            data = message if channel.topic.endswith(topic) else each.data
            if data is None:
                continue
            own = writer.register_schema(schema.name, schema.encoding, schema.data)
            number = writer.register_channel(channel.topic, channel.message_encoding, own)
            writer.add_message(number, each.log_time, data, each.publish_time)
        writer.finish()


@pytest.mark.usefixtures("asked_here")
def test_each_line_about_one_of_several_begins_with_its_bag(tmp_path, monkeypatch, capsys):
    good, late = write_bag(tmp_path / "good", 3), write_bag(tmp_path / "late", 3, epoch_ns=10**18)
    with late.open("rb") as content:
        ((_, _, scenario),) = make_reader(content).iter_messages(topics=["/lie_rigid_body/scenario"])
    with_messages(tmp_path / "a.mcap", good, "/scenario", scenario.data)
    with_messages(tmp_path / "b.mcap", good, "/scenario", b"\0\1\0\0\3\0\0\0{}\0")
    (tmp_path / "c.mcap").write_bytes(good.read_bytes()[:-9])
    monkeypatch.chdir(tmp_path)
    *_, err = answer(capsys, ".")
    said = [line.partition(": error: ")[2] for line in err]
    assert [line.split(" ")[0] for line in said] == ["a.mcap:", "b.mcap", "c.mcap"]
    assert all(line.count(".mcap") == 1 for line in said)


@pytest.mark.usefixtures("asked_here")
@pytest.mark.parametrize(
    ("topic", "message", "named"),
    [
        ("/b/twist", None, "/b/twist"),
        ("/b/lie_rigid_body/scenario", b"\0\1\0\0\3\0\0\0{}\0", "x.mcap /b "),
        ("/b/lie_rigid_body/scenario", b"\0\1", "/b/lie_rigid_body/scenario: message 0"),
        ("/b/pose", b"\0\1\0\0\0\0\0\0", "/b/pose: message 0"),
    ],
)
def test_a_body_that_cannot_be_judged_stops_no_other(tmp_path, monkeypatch, capsys, topic, message, named):
    good = write_bag(tmp_path / "good", 40)
    with_messages(tmp_path / "x.mcap", merged(tmp_path / "two", a=good, b=good), topic, message)
    monkeypatch.chdir(tmp_path)
    for bags in (["x.mcap"], ["x.mcap", "good"]):
        status, out, err = answer(capsys, *bags)
        assert (status, len(err)) == (2, 1)
        assert named in err[0]
        verdicts = [line.split()[0] for line in out[1 : len(bags) + 2]]
        assert verdicts == ["certified", "unusable", "certified"][: len(bags) + 1]
        assert out[1].endswith("x.mcap /a")
        assert out[2].endswith("x.mcap /b")
        assert "/b/" not in " ".join(out)  # nor are its topics called others'
    content = json.loads("\n".join(answer(capsys, "x.mcap", "--json")[1]))
    assert (content["passed"], content["certified"], content["unusable"]) == (False, 1, 1)
    whole, faulty = content["bags"]
    assert (whole["body"], whole["passed"]) == ("/a", True)
    assert faulty == {"bag": "x.mcap", "body": "/b", "passed": None, "error": faulty["error"]}
    assert named in faulty["error"]
    assert answer(capsys, "x.mcap", "--topic", "pose:=/a/pose")[0] == 0
    status, out, err = answer(capsys, "x.mcap", "--topic", "pose:=/b/pose")
    assert (status, out, len(err)) == (2, [], 1)


def test_the_topic_that_is_proposed_is_one_that_can_be_given(tmp_path, monkeypatch, capsys):
    good = write_bag(tmp_path / "good", 3)
    with_messages(tmp_path / "half", merged(tmp_path / "two", a=good, b=good), "/a/pose", None)
    with_messages(tmp_path / "abtb.mcap", tmp_path / "half", "/b/twist", None)
    monkeypatch.chdir(tmp_path)
    proposed = refused(capsys, ["abtb.mcap"]).rpartition("--topic ")[2].strip()
    assert proposed == "scenario:=/a/lie_rigid_body/scenario"
    assert answer(capsys, "abtb.mcap", "--topic", proposed)[0] == 0


def children_of(process: int) -> list[int]:
    """Processes that any thread of a process has begun."""
    found = list[int]()
    for children in Path(f"/proc/{process}/task").glob("*/children"):
        with suppress(OSError):  # the thread has ended
            found += map(int, children.read_text().split())
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_its_processes_end_with_it(tmp_path, number):
    bag = write_bag(tmp_path / "0.mcap", 50_000, motion="closed_form")
    for i in range(1, 9):
        os.link(bag, tmp_path / f"{i}.mcap")
    command = [sys.executable, "-m", "lie_rigid_body", "check", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while not (children := children_of(process.pid)):
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    while any(Path(f"/proc/{child}/exe").exists() for child in children):
        time.sleep(0.01)
    assert out == ""
    if number == signal.SIGINT:
        assert (process.returncode, err.count("\n")) == (130, 1)
