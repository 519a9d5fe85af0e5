"""What of a live recording is safe on the disk, at every moment of a run whose clock the test holds."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from broken_bag import stamps_in_whole_chunks
from fake_time import NS, ScriptedRun

from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.ros.publishing.recorder import FLUSH_INTERVAL_NS, Recorder
from lie_rigid_body.ros.timing.sink import FOREVER, Punctuality, Sink
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep

LOST_BY_A_CRASH_NS = NS


class PromptBag(BagWriter):
    """A bag whose disk takes no time."""

    def flush(self) -> None:
        super().flush()
        self.wait()


@pytest.fixture
def synced(monkeypatch: pytest.MonkeyPatch) -> dict[int, int]:
    """The length at which each file or folder, by its inode, was last put on the disk."""
    lengths, fsync = dict[int, int](), os.fsync

    def noted(descriptor: int) -> None:
        fsync(descriptor)
        status = os.fstat(descriptor)
        lengths[status.st_ino] = status.st_size

    monkeypatch.setattr(os, "fsync", noted)
    return lengths


class Crash(Sink):
    """Reads the file that a crash would leave after each turn of the loop; to come after the recorder."""

    def __init__(self, writer: BagWriter, synced: dict[int, int]) -> None:
        self.writer = writer
        self.synced = synced
        self.lost_ns: list[int] = []
        self._read: tuple[int, int] = (0, 0)
        self._sent_ns = 0

    def begin_segment(self, segment: object) -> None: ...

    def write(self, batch: Batch) -> None:
        self._sent_ns = int(batch.samples.stamps_ns[-1]) - NS

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        self.writer.wait()  # the disk takes no time here
        file, folder = self.writer.path.stat(), self.writer.path.parent.stat()
        if (size := file.st_size) != self._read[0]:
            assert self.synced[file.st_ino] == size  # so that a loss of power leaves as much as the end of the process
            assert folder.st_ino in self.synced
            stamps = stamps_in_whole_chunks(self.writer.path)
            self._read = size, stamps[-1] - NS if stamps else 0
        self.lost_ns.append(self._sent_ns - self._read[1])
        return FOREVER


@pytest.mark.parametrize(("rate", "stall_ns"), [(200.0, 0), (30.0, 300_000_000)])
def test_a_crash_at_any_moment_loses_less_than_a_second(
    tmp_path: Path, synced: dict[int, int], rate: float, stall_ns: int
) -> None:
    with BagWriter(tmp_path / "a.mcap", stamped_twist=True) as writer:
        crash = Crash(writer, synced)
        run = ScriptedRun(rate=rate, sinks=[Recorder(writer, pytest.fail), crash])
        stall = run.stall(stall_ns)
        run.play((NS, stall), (NS + NS // 2, stall), (2 * NS, stall), (3 * NS, lambda: None))
    assert len(crash.lost_ns) > 2 * rate
    assert max(crash.lost_ns) < LOST_BY_A_CRASH_NS


@pytest.mark.parametrize(("max_step", "wait_ns"), [(1e-3, FLUSH_INTERVAL_NS), (2e-6, 0)])
def test_what_is_recorded_is_safe_before_long_work(tmp_path: Path, max_step: float, wait_ns: int) -> None:
    scenario = Scenario.from_parameters({"rate": 1.0, "max_step": max_step})
    simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
    with BagWriter(tmp_path / "a.mcap", stamped_twist=True) as bag:
        recorder = Recorder(bag, pytest.fail)
        recorder.begin_segment(simulation.segment)
        samples = simulation.take(1)
        before = bag.path.stat().st_size
        recorder.write(encoder.encode(SimulationStep(samples)))
        recorder.tick(5 * NS, Punctuality())
        bag.wait()
        assert (bag.path.stat().st_size > before) == (wait_ns == 0)
        recorder.tick(5 * NS + wait_ns, Punctuality())
        bag.wait()
        assert bag.path.stat().st_size > before
