"""Lock-step between real processes: simulator, filter, evaluator."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from random import Random
from threading import Event, Thread
from typing import Any

import pytest
from evaluator_process import evaluator
from simulator_process import Process, SimulatorProcess, assignments, eventually

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag
from said import numbers

if find_spec("rclpy"):
    from geometry_msgs.msg import PoseStamped, TwistStamped
    from peer import Peer
    from sensor_msgs.msg import Imu

pytestmark = [pytest.mark.ros, pytest.mark.long]

FILTER = Path(__file__).parents[2] / "examples" / "complementary_filter" / "complementary_filter_node.py"
BENCH = {
    "epoch_ns": 1_000_000_000,
    "imu_rate": 100.0,
    "magnetometer_rate": 100.0,
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
    "sensor_grade": "mems",
    "lockstep_topic": "imu/data",
    "real_time_factor": 0.0,
}
"""A bench in lock-step: as fast as the filter."""


@contextmanager
def halted_now_and_then(*processes: subprocess.Popen[str]) -> Iterator[list[int]]:
    """Processes of which one after the other stands still for up to 50 ms, as on a machine that others use."""
    random, ended, halts = Random(1), Event(), list[int]()

    def halt() -> None:
        while not ended.wait(random.uniform(0.0, 0.01)):
            process = random.choice(processes)
            process.send_signal(signal.SIGSTOP)
            ended.wait(random.uniform(0.0, 0.05))
            process.send_signal(signal.SIGCONT)
            halts.append(process.pid)

    thread = Thread(target=halt)
    thread.start()
    try:
        yield halts
    finally:
        ended.set()
        thread.join()


def simulator(domain: int, **given: object) -> SimulatorProcess:
    return SimulatorProcess("--scenario", "tumbling_cubesat", *assignments(**{**BENCH, **given}), domain=domain)


def example(domain: int, executor: str = "SingleThreadedExecutor") -> Process:
    return Process(str(FILTER), "--executor", executor, domain=domain)


def score(
    domain: int, executor: str, duration: str = "2", *, disturbed: bool = False, **given: object
) -> dict[str, Any]:
    """The score of the filter of the examples, less what is not of the estimate."""
    with (
        simulator(domain, lockstep_nodes="[/judge]", **given) as sim,
        example(domain, executor) as filtering,
        evaluator(domain, "judge", "--json", "--series", "--duration", duration, estimate="/imu/data") as judge,
    ):
        if disturbed:
            eventually(lambda: any("/judge" in line for line in sim.complained), "all three")
            with halted_now_and_then(sim.process, filtering.process, judge.process) as halts:
                assert judge.wait() == 0, judge.complained
            assert len(halts) > 10
        assert judge.wait() == 0, judge.complained
        assert sim.end(signal.SIGINT) == 0
    found: dict[str, Any] = json.loads("\n".join(judge.said))
    return found


@pytest.mark.slow
def test_the_score_is_the_same_whenever_the_machine_gives_time(domain: int) -> None:
    even = score(domain, "SingleThreadedExecutor")
    assert even["samples"] == 201
    assert even["total_deg"]["rms"] > 1.0  # of mems sensors: something that could differ
    assert score(domain, "MultiThreadedExecutor", disturbed=True) == even


class Timed:
    """A node that publishes on a timer, at the stamp that it likes."""

    def __init__(self, peer: Peer) -> None:
        publisher = peer.node.create_publisher(Imu, "/imu/data", 10)
        self.readings = peer.listen(Imu, "/imu/data_raw")
        peer.node.create_timer(0.02, lambda: publisher.publish(Imu()))


@pytest.mark.slow
def test_a_filter_on_a_timer_ends_it_with_status_2_the_stamp_and_what_came(domain: int, tmp_path: Path) -> None:
    bag = tmp_path / "run.mcap"
    with simulator(domain, lockstep_timeout=1.0, record_path=bag) as sim, Peer("timed", domain) as peer:
        timed = Timed(peer)
        peer.spin_until(lambda: sim.process.poll() is not None, "its end")
        assert sim.wait() == 2
        assert len(timed.readings) == 1
    [line] = [line for line in sim.complained if "error" in line]
    missed_ns, _, others, last_ns, *_ = numbers(line.partition(" /imu/data: ")[2] or line.partition("/imu/data: ")[2])
    assert (missed_ns, others > 0, last_ns) == (1e9, True, 0)
    assert certify(Bag(bag)).passed  # it was finished


@pytest.mark.slow
def test_a_topic_of_another_type_is_told_in_one_line(domain: int) -> None:
    with simulator(domain) as sim, Peer("other", domain) as peer:
        peer.node.create_publisher(TwistStamped, "/imu/data", 10)
        peer.spin_until(lambda: sim.process.poll() is not None, "its end")
        assert sim.wait() == 2
    assert "/imu/data" in sim.complained[-1]


@pytest.mark.slow
def test_who_only_listens_is_no_filter_and_who_is_awaited_is_named(domain: int) -> None:
    """An evaluator, a recorder, RViz: they have no publisher, or hear no sensor."""
    with simulator(domain, lockstep_nodes="[/judge]") as sim, Peer("recorder", domain) as peer:
        heard = [peer.listen(kind, topic) for kind, topic in ((Imu, "/imu/data_raw"), (PoseStamped, "/pose"))]
        peer.listen(Imu, "/imu/data")

        def said(*words: str) -> bool:
            return any(all(word in line for word in words) for line in sim.complained)

        filters = "/imu/data and hears /imu/data_raw, of which there are "
        peer.spin_until(lambda: said(f"{filters}0", "/judge"), "a word")
        with example(domain):
            peer.spin_until(lambda: said("waits for subscriptions of /judge"), "a word about the judge")
            with example(domain):
                peer.spin_until(lambda: said(f"{filters}2"), "a word about both")
            assert not any(heard)
            with evaluator(domain, "judge", estimate="/imu/data"):
                peer.spin_until(lambda: all(len(messages) > 100 for messages in heard), "readings")
        assert said("/complementary_filter", " imu, magnetometer ", " /imu/data")
        assert sim.end(signal.SIGINT) == 0
