"""The thread that writes, and a disk that stands still for as long as the test wants."""

from __future__ import annotations

import errno
import math
from collections.abc import Iterator
from pathlib import Path
from threading import Event

import pytest
from bags import write_samples
from refused_bags import refused

from lie_rigid_body.recording import bag_writer
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system import output_file
from lie_rigid_body.system.output_file import MAX_BACKLOG, DiskQueue


@pytest.fixture
def disk() -> Iterator[Event]:
    """It stands still until it is set: at the end of the test at the latest, else the interpreter would wait for it."""
    event = Event()
    yield event
    event.set()


def test_jobs_are_done_in_order() -> None:
    queue, done = DiskQueue(waits=True), list[int]()
    for k in range(100):
        queue.put(lambda k=k: done.append(k), MAX_BACKLOG // 3)  # type: ignore[misc]
    queue.finish()
    assert done == list(range(100))


def test_a_live_run_does_not_wait_and_says_when_too_much_is_waiting(disk: Event) -> None:
    queue, done = DiskQueue(waits=False), list[str]()
    queue.put(disk.wait)
    queue.put(lambda: done.append("written"), MAX_BACKLOG)
    with pytest.raises(TimeoutError):
        queue.put(lambda: done.append("too much"), 1)
    assert done == []
    disk.set()
    queue.finish()
    assert done == ["written"]


def test_after_an_error_nothing_is_written_and_it_is_told_once(disk: Event) -> None:
    queue, done = DiskQueue(waits=True), list[str]()

    def full() -> None:
        disk.wait()
        raise OSError(errno.ENOSPC, "No space left on device")

    queue.put(full)
    queue.put(lambda: done.append("after the error"))
    disk.set()
    with pytest.raises(OSError) as caught:
        queue.wait()
    assert caught.value.errno == errno.ENOSPC
    queue.end(lambda: done.append("closed"))
    assert done == ["closed"]


def test_a_bag_whose_disk_stands_still_is_given_up_and_what_is_written_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, disk: Event
) -> None:
    monkeypatch.setattr(output_file, "MAX_BACKLOG", 100_000)
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    simulation = Simulation(scenario)
    bag = BagWriter(tmp_path / "a.mcap", stamped_twist=True, chunk_size=10_000, wait_for_disk=False)
    bag.begin_segment(simulation.segment)
    write_samples(bag, scenario, simulation.take(300))
    bag.wait()
    written = bag.path.stat().st_size
    monkeypatch.setattr(bag._file, "sync", disk.wait)
    bag.flush()
    with refused("slow disk", name="a.mcap"):
        write_samples(bag, scenario, simulation.take(1000))
    assert bag.path.stat().st_size >= written
    with refused("finished"):
        bag.flush()
    disk.set()


@pytest.mark.parametrize(("at_least", "syncs"), [(math.inf, 2), (0.0, 5)])
def test_flushes_that_wait_for_a_slow_sync_share_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, disk: Event, at_least: float, syncs: int
) -> None:
    """Otherwise a disk that takes longer to sync than the time between flushes falls behind for ever."""
    monkeypatch.setattr(bag_writer, "_SYNC_AT_LEAST", at_least)
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    simulation, begun, synced = Simulation(scenario), Event(), list[int]()
    bag = BagWriter(tmp_path / "a.mcap", stamped_twist=True, wait_for_disk=False)
    sync = bag._file.sync

    def slow() -> None:
        begun.set()
        disk.wait()
        sync()
        synced.append(bag.path.stat().st_size)

    monkeypatch.setattr(bag._file, "sync", slow)
    bag.begin_segment(simulation.segment)
    for _ in range(5):
        write_samples(bag, scenario, simulation.take(10))
        bag.flush()
        begun.wait()
    disk.set()
    bag.wait()
    assert len(synced) == syncs
    assert synced[-1] == bag.path.stat().st_size
    bag.finish()
