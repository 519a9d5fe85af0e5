"""A recording node killed at a random instant: what it had sent is recovered, but for the last second at most."""

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
from lie_rigid_body.errors import BagError
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
"""Kills before anything was written to the disk."""
AT_ONCE = 4
"""Nodes at a time."""
SILENCE = 0.3
"""s without a message, after which no more is on its way from a node that is dead."""


class Loss(NamedTuple):
    """What a kill cost: the time between the last sample heard and the last one recovered; and whether any was."""

    lost_ns: int
    recovered: bool


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
    (domain, peer), space = witness(), f"/run_{seed}"  # others go on to see for a while what dies without a word
    poses, scenarios = (
        peer.listen(PoseStamped, f"{space}/pose"),
        peer.listen(String, f"{space}{NODE}/scenario", LATCHED),
    )
    given = (*assignments(imu_rate=50.0, record_path=bag), "--ros-args", "-r", f"__ns:={space}")
    with SimulatorProcess(*given, domain=domain) as simulator:
        peer.spin_until(lambda: poses and scenarios, "a running node")
        peer.spin_until(lambda: early or bag.stat().st_size > 0, "what is written first")
        instant = randomness.uniform(0.0, 0.4) if early else randomness.uniform(1.0, 6.0)
        peer.spin_until(passed(instant), "the instant")
        simulator.process.send_signal(signal.SIGKILL)
        assert simulator.wait() == -signal.SIGKILL
    heard = 0
    while heard < len(poses):
        heard = len(poses)
        peer.spin_until(passed(SILENCE), "silence")
    begun_ns = int(json.loads(scenarios[0].data)["start_ns"])
    last_ns = recovered_until(bag, folder / f"{seed}-fixed.mcap")
    return Loss(stamp_ns(poses[-1]) - (begun_ns if last_ns is None else last_ns), last_ns is not None)


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


def test_at_most_the_last_second_is_lost(tmp_path: Path, record_property: Callable[[str, object], None]) -> None:
    with ProcessPoolExecutor(AT_ONCE, get_context("spawn")) as witnesses:  # rclpy bears no threads
        losses = list(witnesses.map(partial(killed, tmp_path), range(KILLS)))
    lost = [loss.lost_ns / NS for loss in losses]
    record_property("kills", len(losses))
    record_property("recovered", sum(loss.recovered for loss in losses))
    record_property("lost at most, s", round(max(lost), 3))
    record_property("median, s", round(statistics.median(lost), 3))
    assert max(lost) <= 1.0
    assert all(loss.recovered for loss in losses[EARLY:])
