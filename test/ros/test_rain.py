"""Whatever rains on the node, a reliable subscriber gets every stamp once."""

from __future__ import annotations

import random
import signal
import time
from collections.abc import Callable
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

import pytest
from simulator_process import RawClient, SimulatorProcess, assignments

if find_spec("rclpy"):
    from peer import Peer
    from raw_client import stamp_ns

pytestmark = pytest.mark.ros

EPOCH = 1_700_000_000_000_000_007
NS = 1_000_000_000
RATES = {"pose": 1000.0, "twist": 1000.0, "imu/data_raw": 700.0, "imu/bias": 700.0, "imu/mag": 130.0}
DEPTH = 100_000
"""A subscriber that the machine starves must not lose what the node has sent."""


def definition(rate: float, first_ns: int, last_ns: int) -> list[int]:
    period = NS / Fraction(repr(rate))
    first, last = ((stamp - EPOCH) / period for stamp in (first_ns, last_ns))
    stamps = (EPOCH + round(k * period) for k in range(max(0, int(first) - 1), int(last) + 2))
    return [stamp for stamp in stamps if first_ns <= stamp <= last_ns]


def rain(peer: Peer, simulator: SimulatorProcess, drops: int) -> int:
    """Let it rain, and return where time stands in the end, ns."""

    def stall() -> None:
        simulator.process.send_signal(signal.SIGSTOP)
        time.sleep(0.3)
        simulator.process.send_signal(signal.SIGCONT)

    def set_rate(y: float) -> None:
        assert peer.set_together(initial_body_rate=[0.01, y, 0.01]).successful

    def set_factor(factor: float) -> None:
        assert peer.set_together(real_time_factor=factor).successful

    actions: list[Callable[[], object]] = [
        *[lambda: peer.call("reset")] * 4,
        *[lambda: peer.call("pause"), lambda: peer.call("step"), lambda: peer.call("resume")] * 3,
        *[lambda: peer.call("resume")] * 3,
        lambda: set_rate(0.5),
        lambda: set_rate(2.0),
        lambda: set_factor(0.5),
        lambda: set_factor(1.5),
        lambda: set_factor(1.0),
        stall,
    ]
    randomness = random.Random(7)
    for _ in range(drops):
        randomness.choice(actions)()
        time.sleep(randomness.uniform(0.0, 0.1))
    return peer.stamp("pause")


@pytest.mark.slow
def test_every_stamp_arrives_once(peer: Peer, tmp_path: Path) -> None:
    topics = [*RATES, "/clock"]
    given = assignments(rate=1000.0, imu_rate=700.0, magnetometer_rate=130.0, epoch_ns=EPOCH)
    given += assignments(publish_clock="true", paused="true", gyro_noise_density=0.001)
    depths = assignments(**{f"qos_overrides.{'/' + t.lstrip('/')}.publisher.depth": DEPTH for t in topics})
    with (
        SimulatorProcess("--ros-args", *given, *depths) as simulator,
        RawClient(tmp_path / "seen", "", *topics) as client,
    ):
        client.meet(lambda: peer.stamp("step"))
        met_ns = peer.stamp("pause")
        assert peer.call("resume").success
        last_ns = rain(peer, simulator, 200)
        last = {topic: definition(rate, EPOCH, last_ns)[-1] for topic, rate in RATES.items()}
        payloads = client.finish({**last, "/clock": max(last.values())})
    seen = {topic: [stamp_ns(payload) for payload in found] for topic, found in payloads.items()}
    everything: set[int] = set()
    for topic, rate in RATES.items():
        # each topic is heard from some step on
        assert seen[topic][0] <= met_ns, topic
        assert seen[topic] == definition(rate, seen[topic][0], last_ns), topic
        everything.update(definition(rate, seen["/clock"][0], last_ns))
    assert seen["/clock"][0] <= met_ns < last_ns
    assert seen["/clock"] == sorted(everything)
    assert simulator.errors() == []
