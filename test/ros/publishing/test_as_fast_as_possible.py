"""Without a limit of speed the node sends far faster than real time, the very bytes of a headless recording."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from mcap.reader import make_reader
from simulator_process import RawClient, SimulatorProcess, cpu_seconds

if find_spec("rclpy"):
    import rclpy
    from peer import Peer
    from std_srvs.srv import Trigger

pytestmark = pytest.mark.ros

EPOCH = 1_700_000_000_000_000_007
NS = 1_000_000_000
GIVEN = ["rate:=1000.0", "imu_rate:=1000.0", "gyro_noise_density:=0.001", f"epoch_ns:={EPOCH}"]
ARGUMENTS = [argument for text in GIVEN for argument in ("-p", text)]
TOPICS = ["pose", "twist", "imu/data_raw"]
LEAST_FACTOR = 10.0


@pytest.fixture
def peer(isolated_ros: None) -> Iterator[Peer]:
    rclpy.init(args=[])
    peer = Peer("hurry")
    yield peer
    peer.node.destroy_node()
    rclpy.shutdown()


def call(peer: Peer, name: str) -> str:
    answer = peer.answer(Trigger, f"/lie_rigid_body/{name}", Trigger.Request())
    assert answer.success, answer.message
    return str(answer.message)


def recorded(path: Path) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {topic: [] for topic in TOPICS}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            if channel.topic.removeprefix("/") in found:
                found[channel.topic.removeprefix("/")].append(message.data)
    return found


def record(path: Path, seconds: float) -> dict[str, list[bytes]]:
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(path), "--quiet", "--duration", f"{seconds:.9f}"]
    subprocess.run([*command, *ARGUMENTS], check=True, timeout=60)
    return recorded(path)


HURRY = [*ARGUMENTS, "-p", "real_time_factor:=0.0", "-p", "paused:=true"]


def hurried(peer: Peer, seconds: float) -> tuple[float, float]:
    """Let time go for a while; how far it went, and how long it took, s."""
    for name in ("resume", "pause"):
        peer.client(Trigger, f"/lie_rigid_body/{name}")
    began = time.monotonic()
    call(peer, "resume")
    time.sleep(seconds)
    [last_ns] = map(int, re.findall(r"\d+", call(peer, "pause")))
    return (last_ns + 1 - EPOCH) / NS, time.monotonic() - began


def test_the_bytes_are_those_of_a_recording(peer: Peer, tmp_path: Path) -> None:
    bag = tmp_path / "live.mcap"
    client = RawClient(tmp_path / "seen", "", *TOPICS)
    with SimulatorProcess(*HURRY, "-p", f"record_path:={bag}") as simulator, client:
        time.sleep(0.5)  # the node has met the client as well
        simulated, _ = hurried(peer, 0.5)
        seen = client.finish()
        simulator.process.terminate()
        assert simulator.wait() == 0
    headless, live = record(tmp_path / "headless.mcap", simulated), recorded(bag)
    for topic in TOPICS:
        assert len(headless[topic]) == round(simulated * 1000) > 0, topic
        assert seen[topic] == live[topic] == headless[topic], topic
    sec, nanosec = struct.unpack_from("<iI", seen["pose"][0], 4)
    assert sec * NS + nanosec == EPOCH


def test_far_faster_than_real_time_while_nobody_listens(peer: Peer, tmp_path: Path) -> None:
    bag = tmp_path / "live.mcap"
    with SimulatorProcess(*HURRY, "-p", f"record_path:={bag}") as simulator:
        before = cpu_seconds(simulator.process.pid)
        simulated, took = hurried(peer, 1.0)
        worked = cpu_seconds(simulator.process.pid) - before
        simulator.process.terminate()
        assert simulator.wait() == 0
    print(f"{simulated / took:.0f} times real time, {simulated / worked:.0f} times its work")
    # others may want the processors as well
    assert simulated > LEAST_FACTOR * worked
    assert recorded(bag) == record(tmp_path / "headless.mcap", simulated)


def test_far_faster_than_real_time_while_somebody_listens(peer: Peer, tmp_path: Path) -> None:
    client = RawClient(tmp_path / "seen", "", *TOPICS)
    with SimulatorProcess(*HURRY) as simulator, client:
        time.sleep(0.5)
        before = cpu_seconds(simulator.process.pid)
        simulated, took = hurried(peer, 1.0)
        worked = cpu_seconds(simulator.process.pid) - before
    print(f"{simulated / took:.0f} times real time, {simulated / worked:.0f} times its work")
    assert simulated > LEAST_FACTOR * worked
