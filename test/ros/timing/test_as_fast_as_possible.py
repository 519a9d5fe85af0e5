"""Without a limit of speed the node sends the very bytes of a headless recording, and loses none of them."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from mcap.reader import make_reader
from simulator_process import DEADLINE, RawClient, SimulatorProcess, assignments, eventually

if find_spec("rclpy"):
    from peer import Peer

pytestmark = pytest.mark.ros

EPOCH = 1_700_000_000_000_000_007
NS = 1_000_000_000
PERIOD_NS = 1_000_000
GIVEN = assignments(rate=1000.0, imu_rate=1000.0, gyro_noise_density=0.001, epoch_ns=EPOCH)
TOPICS = ["pose", "twist", "imu/data_raw"]


def recorded(path: Path) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {topic: [] for topic in TOPICS}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            if channel.topic.removeprefix("/") in found:
                found[channel.topic.removeprefix("/")].append(message.data)
    return found


def record(path: Path, duration_ns: int) -> dict[str, list[bytes]]:
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(path), "--quiet"]
    duration = f"{duration_ns // NS}.{duration_ns % NS:09d}"
    subprocess.run([*command, "--duration", duration, *GIVEN], check=True, timeout=DEADLINE)
    return recorded(path)


def go_on(peer: Peer, bag: Path) -> int:
    """Let time go until the bag has grown; return where it stands, ns."""
    size = bag.stat().st_size
    assert peer.call("resume").success
    eventually(lambda: bag.stat().st_size > size, "samples in the bag")
    return peer.stamp("pause")


@pytest.mark.slow
def test_the_bytes_are_those_of_a_recording(peer: Peer, tmp_path: Path) -> None:
    bag = tmp_path / "live.mcap"
    given = [*GIVEN, *assignments(real_time_factor=0.0, paused="true", record_path=bag)]
    with SimulatorProcess(*given) as simulator, RawClient(tmp_path / "seen", "", *TOPICS) as client:
        unheard_ns = go_on(peer, bag)
        client.meet(lambda: peer.stamp("step"))
        met_ns = peer.stamp("pause")
        end_ns = go_on(peer, bag)
        seen = client.finish(dict.fromkeys(TOPICS, end_ns + 1 - PERIOD_NS))
        simulator.process.terminate()
        assert simulator.wait() == 0
    assert EPOCH < unheard_ns < met_ns < end_ns
    headless, live = record(tmp_path / "headless.mcap", end_ns + 1 - EPOCH), recorded(bag)
    for topic in TOPICS:
        assert len(headless[topic]) * PERIOD_NS == end_ns + 1 - EPOCH, topic
        assert live[topic] == headless[topic], topic
        # the client hears each topic from some step on, and from then on all of it
        assert len(seen[topic]) * PERIOD_NS >= end_ns - met_ns, topic
        assert seen[topic] == headless[topic][-len(seen[topic]) :], topic
