"""A recording node killed at a random instant: all that it had flushed is recovered, and it flushes twice a second.

So a kill costs the last second at most, where the disk is as fast as that. How fast the disk and the machine are is no
verdict: it is told how long before its last sample each node had flushed last, and how much a listener lost.
"""

from __future__ import annotations

import json
import random
import signal
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
from functools import cache, partial
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from simulator_process import SimulatorProcess, assignments

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.recovery import recover
from ros_domains import own_domain

if find_spec("rclpy"):
    from geometry_msgs.msg import PoseStamped
    from peer import LATCHED, NODE, Peer
    from std_msgs.msg import String

pytestmark = [pytest.mark.ros, pytest.mark.slow]

NS = 1_000_000_000
KILLS = 100
EARLY = 10
"""Kills before anything is waited for, mostly before anything was written to the disk."""
AT_ONCE = 4
"""Nodes at a time."""
SILENCE = 0.3
"""s without a message, after which no more is on its way from a node that is dead."""


FLUSHES = (1, 10)
"""Fewest and most flushes that are written before a later kill."""
FLUSHED_EVERY_NS = NS // 2
"""What is promised of the recorder's own time: without a flush it is never longer at the end of a turn."""
NOTING = Path(__file__).with_name("noting_simulator.py")


class Loss(NamedTuple):
    """What a kill cost: the time between the last sample heard and the last one recovered; and what held."""

    lost_ns: int
    recovered: bool
    written_lost_ns: int
    """Time, ns, of what had been written before the kill and was not recovered."""
    unflushed_ns: int
    """Longest steady time, ns, from a flush to the end of a later turn without one."""


class Notes(NamedTuple):
    """What the node noted of its recorder before it was killed."""

    flushed_ns: list[int]
    """Of each flush the stamp of the last sample handed over before it; 0 of none."""
    written: int
    """The number of flushes, from the first one, that the disk's thread was done with."""
    unflushed_ns: int


def read_notes(path: Path) -> Notes:
    """Read what was noted in whole lines."""
    since_ns, longest_ns, flushed_ns, written, fresh = None, 0, list[int](), 0, True
    for line in path.read_text().splitlines(keepends=True) if path.exists() else ():
        match line.split():
            case ["flush", stamp] if line.endswith("\n"):
                flushed_ns.append(int(stamp))
                fresh = True
            case ["written"] if line.endswith("\n"):
                written += 1
            case ["tick", steady] if line.endswith("\n"):
                if fresh:
                    since_ns, fresh = int(steady), False
                assert since_ns is not None
                longest_ns = max(longest_ns, int(steady) - since_ns)
    return Notes(flushed_ns, written, longest_ns)


def stamp_ns(pose: Any) -> int:
    return int(pose.header.stamp.sec) * NS + int(pose.header.stamp.nanosec)


def passed(seconds: float) -> Callable[[], bool]:
    """Whether so much time has passed from now on."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() >= end


@cache
def witness() -> tuple[int, Peer]:
    """A domain, and a node in it that hears what is sent there, for as long as this process lives.

    It is never taken down: rclpy may crash when a node is destroyed that has heard others die.
    """
    context = own_domain()
    _open.append(context)
    domain = context.__enter__()
    return domain, Peer("witness", domain)


_open: list[AbstractContextManager[int]] = []


def killed(folder: Path, seed: int) -> Loss:
    """Kill a node, and hold what is recovered of its bag against what another node heard of it."""
    randomness, bag, early = random.Random(seed), folder / f"{seed}.mcap", seed < EARLY
    notes, flushes = folder / f"{seed}.notes", 0 if early else randomness.randint(*FLUSHES)
    (domain, peer), space = witness(), f"/run_{seed}"  # others go on to see for a while what dies without a word
    poses, scenarios = (
        peer.listen(PoseStamped, f"{space}/pose"),
        peer.listen(String, f"{space}{NODE}/scenario", LATCHED),
    )
    given = (*assignments(imu_rate=50.0, record_path=bag), "--ros-args", "-r", f"__ns:={space}")
    with SimulatorProcess(*given, domain=domain, program=[str(NOTING), str(notes)]) as simulator:
        peer.spin_until(lambda: poses and scenarios, "a running node")
        peer.spin_until(lambda: read_notes(notes).written >= flushes, "what is written first")
        peer.spin_until(passed(randomness.uniform(0.0, 0.5)), "the instant")
        simulator.process.send_signal(signal.SIGKILL)
        assert simulator.wait() == -signal.SIGKILL
    heard = 0
    while heard < len(poses):
        heard = len(poses)
        peer.spin_until(passed(SILENCE), "silence")
    begun_ns = int(json.loads(scenarios[0].data)["start_ns"])
    last_ns = recovered_until(bag, folder / f"{seed}-fixed.mcap")
    until_ns, noted = begun_ns if last_ns is None else last_ns, read_notes(notes)
    written_ns = max(noted.flushed_ns[: noted.written], default=0)
    return Loss(stamp_ns(poses[-1]) - until_ns, last_ns is not None, max(0, written_ns - until_ns), noted.unflushed_ns)


def recovered_until(bag: Path, fixed: Path) -> int | None:
    """The stamp of the last sample recovered, ns, of a bag that is certified; None if it holds no whole message."""
    try:
        recover(bag, fixed, overwrite=False)
    except BagError:
        return None
    recording = read_bag(fixed)
    certificate = certify(recording)
    assert certificate.passed, certificate.messages
    return int(recording.poses.stamps_ns[-1])


def test_what_was_flushed_is_recovered_and_flushed_is_twice_a_second(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    with ProcessPoolExecutor(AT_ONCE, get_context("spawn")) as witnesses:  # rclpy bears no threads
        losses = list(witnesses.map(partial(killed, tmp_path), range(KILLS)))
    lost = [loss.lost_ns / NS for loss in losses]
    record_property("kills", len(losses))
    record_property("recovered", sum(loss.recovered for loss in losses))
    record_property("heard and lost at most, s", round(max(lost), 3))
    record_property("median, s", round(statistics.median(lost), 3))
    assert not any(loss.written_lost_ns for loss in losses)
    assert max(loss.unflushed_ns for loss in losses) < FLUSHED_EVERY_NS
    assert all(loss.recovered for loss in losses[EARLY:])
