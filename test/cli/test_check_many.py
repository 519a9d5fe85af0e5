"""``check`` with several bags: its JSON, its page and its processes; `words_of_checks` has what it says."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from test_check import write_bag

from foreign_bags import bag_of, messages_of
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
    messages = [
        each._replace(
            topic=f"/{namespace}{each.topic}".replace(*renamed),
            log_time=each.log_time + late_ns,
            publish_time=each.publish_time + late_ns,
        )
        for namespace, source in sources.items()
        for each in messages_of(source)
    ]
    target.write_bytes(bag_of(messages, "a recorder"))
    return target


def answer(capsys, *arguments: str | Path) -> tuple[int, list[str], list[str]]:
    """Exit status, and the lines of stdout and stderr."""
    status = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return status, out.splitlines(), err.splitlines()


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
def test_a_page_tells_what_of_its_bags_is_not_certified(tmp_path, capsys):
    """Topics beside the bodies' own, and those that a recorder did not get, with where that is."""
    pytest.importorskip("plotly")
    good, with_imu = write_bag(tmp_path / "good.mcap", 40), tmp_path / "imu.mcap"
    assert record([str(with_imu), "--duration", "0.2", "-p", "imu_rate:=50.0", "--quiet"]) == 0
    two, page = tmp_path / "two.mcap", tmp_path / "page.html"
    merged(two, renamed=("/b/imu/data_raw", "/b/imu/raw"), late_ns=1000, a=good, b=with_imu)
    assert answer(capsys, two, "--report", page)[0] == 0
    assert re.search(rf"<li>.*/b/imu/raw, .*\({two}\)</li><li>imu/data_raw", page.read_text(encoding="utf-8"))


def deadly(inertia, topics, bag):
    if bag == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    return [Verdict(bag, None, Certificate(()))]


@pytest.mark.slow
def test_a_process_that_dies_costs_its_bag_only(monkeypatch):
    monkeypatch.setattr(checking, "judge", deadly)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1})
    found = judge_all(["a", "deadly", "b", "c"])
    assert [(each.bag, each.status) for each in found] == [("a", 0), ("deadly", 2), ("b", 0), ("c", 0)]
    assert found[1].reason.startswith("deadly: ")


def with_messages(target: Path, source: Path, topic: str, message: bytes | None) -> None:
    """A bag with another message, or none, in place of each on the topics that end so."""
    others = [each for each in messages_of(source) if message is not None or not each.topic.endswith(topic)]
    changed = [each._replace(data=message) if each.topic.endswith(topic) else each for each in others]  # type: ignore[arg-type]
    target.write_bytes(bag_of(changed, "a recorder"))


@pytest.mark.usefixtures("asked_here")
def test_json_tells_a_body_that_cannot_be_judged(tmp_path, monkeypatch, capsys):
    good = write_bag(tmp_path / "good", 40)
    with_messages(tmp_path / "x.mcap", merged(tmp_path / "two", a=good, b=good), "/b/twist", None)
    monkeypatch.chdir(tmp_path)
    content = json.loads("\n".join(answer(capsys, "x.mcap", "--json")[1]))
    assert (content["passed"], content["certified"], content["unusable"]) == (False, 1, 1)
    whole, faulty = content["bags"]
    assert (whole["body"], whole["passed"]) == ("/a", True)
    assert not any("/b/" in text for text in whole["not_certified"])
    assert faulty == {"bag": "x.mcap", "body": "/b", "passed": None, "error": faulty["error"]}


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
        assert (process.returncode, err.count("\n")) == (130, 1), err
