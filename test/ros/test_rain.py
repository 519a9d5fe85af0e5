"""Whatever rains on the node, a reliable subscriber gets every stamp once."""

from __future__ import annotations

import random
import signal
import struct
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

import pytest
from simulator_process import RawClient, SimulatorProcess, cpu_seconds

if find_spec("rclpy"):
    import rclpy
    from peer import Peer
    from std_srvs.srv import Trigger

pytestmark = pytest.mark.ros

EPOCH = 1_700_000_000_000_000_007
NS = 1_000_000_000
RATES = {"pose": 1000.0, "twist": 1000.0, "imu/data_raw": 700.0, "imu/bias": 700.0, "imu/mag": 30.0}


@pytest.fixture
def peer(isolated_ros: None) -> Iterator[Peer]:
    rclpy.init(args=[])
    peer = Peer("rain")
    yield peer
    peer.node.destroy_node()
    rclpy.shutdown()


def stamp_ns(payload: bytes) -> int:
    """Stamps come first in all of these messages, after four bytes of encapsulation."""
    sec, nanosec = struct.unpack_from("<iI", payload, 4)
    return int(sec) * NS + int(nanosec)


def definition(rate: float, first_ns: int, last_ns: int) -> list[int]:
    period = NS / Fraction(repr(rate))
    first, last = ((stamp - EPOCH) / period for stamp in (first_ns, last_ns))
    stamps = (EPOCH + round(k * period) for k in range(max(0, int(first) - 1), int(last) + 2))
    return [stamp for stamp in stamps if first_ns <= stamp <= last_ns]


def rain(peer: Peer, simulator: SimulatorProcess, seconds: float) -> int:
    """Let it rain, and return where time stands in the end, ns."""

    def call(name: str) -> Trigger.Response:
        return peer.answer(Trigger, f"/lie_rigid_body/{name}", Trigger.Request())

    def stall() -> None:
        simulator.process.send_signal(signal.SIGSTOP)
        time.sleep(0.3)
        simulator.process.send_signal(signal.SIGCONT)

    def set_rate(y: float) -> None:
        assert peer.set_together(initial_body_rate=[0.01, y, 0.01]).successful

    def set_factor(factor: float) -> None:
        assert peer.set_together(real_time_factor=factor).successful

    actions: list[Callable[[], object]] = [
        *[lambda: call("reset")] * 4,
        *[lambda: call("pause"), lambda: call("step"), lambda: call("resume"), lambda: call("resume")] * 3,
        lambda: set_rate(0.5),
        lambda: set_rate(2.0),
        lambda: set_factor(0.5),
        lambda: set_factor(1.5),
        lambda: set_factor(1.0),
        stall,
    ]
    randomness, end = random.Random(7), time.monotonic() + seconds
    while time.monotonic() < end:
        randomness.choice(actions)()
        time.sleep(randomness.uniform(0.0, 0.15))
    stood = call("pause")
    assert stood.success
    return int(stood.message.removeprefix("time stands still at ").removesuffix(" ns"))


@pytest.mark.parametrize("seconds", [3.0, pytest.param(60.0, marks=pytest.mark.slow)])
def test_every_stamp_arrives_once(peer: Peer, tmp_path: Path, seconds: float) -> None:
    arguments = ["rate:=1000.0", "imu_rate:=700.0", "magnetometer_rate:=30.0", f"epoch_ns:={EPOCH}"]
    arguments += ["publish_clock:=true", "paused:=true", "gyro_noise_density:=0.001"]
    client = RawClient(tmp_path / "seen", "", *RATES, "/clock")
    with SimulatorProcess(*(a for text in arguments for a in ("-p", text))) as simulator, client:
        time.sleep(0.5)  # the node has met the client as well
        began, cpu = time.monotonic(), cpu_seconds(simulator.process.pid)
        assert peer.answer(Trigger, "/lie_rigid_body/resume", Trigger.Request()).success
        last_ns = rain(peer, simulator, seconds)
        print(f"CPU: {(cpu_seconds(simulator.process.pid) - cpu) / (time.monotonic() - began):.2f} of a core")
        seen = {topic: [stamp_ns(payload) for payload in payloads] for topic, payloads in client.finish().items()}
    everything: set[int] = set()
    for topic, rate in RATES.items():
        assert seen[topic] == definition(rate, EPOCH, last_ns), topic
        everything.update(seen[topic])
    assert seen["/clock"] == sorted(everything)
    assert last_ns > EPOCH + NS // 10 * int(seconds)
    assert [line for line in simulator.complained if "catching up" not in line] == []
