"""What does a published sample cost? The live node beside a bare rclpy timer that publishes as many prebuilt bytes.

Processor time of the whole process for each sample that a subscriber received, in a steady stretch between two
readings. The contestants take turns, in one run, with the same quality of service and one subscriber. A ratio of 1
means that the truth is computed, encoded and timed for what the timer of a bare node costs. Run it with

    python benchmarks/live_cost.py                          # some four minutes
    python benchmarks/live_cost.py --rates 1000 --seconds 3

in an environment with rclpy, on Linux.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

TRUTH = ("pose", "twist")
EVERYTHING = (*TRUTH, "imu/data_raw", "imu/bias", "clock")
WARM_UP_S = 1.0
TURNS = 2
DEADLINE_S = 30.0


def message_types() -> dict[str, type]:
    """The types of the topics."""
    from geometry_msgs.msg import PoseStamped, TwistStamped
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import Imu

    return {"pose": PoseStamped, "twist": TwistStamped, "imu/data_raw": Imu, "imu/bias": Imu, "clock": Clock}


def bare(rate: str, *topics: str) -> None:
    """A node with nothing but a timer, which publishes the same bytes again and again."""
    import rclpy
    from rclpy.serialization import serialize_message

    from lie_rigid_body.ros.publishing.publisher import DEPTH

    rclpy.init(args=[])
    node = rclpy.create_node("bare")
    types = message_types()
    pairs = [(node.create_publisher(types[t], t, DEPTH).publish, serialize_message(types[t]())) for t in topics]

    def publish() -> None:
        for send, payload in pairs:
            send(payload)

    node.create_timer(1.0 / float(rate), publish)
    with suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


def subscriber() -> None:
    """Take what comes, and tell the number of poses for each line of the input."""
    import threading

    import rclpy

    from lie_rigid_body.ros.publishing.publisher import DEPTH

    rclpy.init(args=[])
    node = rclpy.create_node("subscriber")
    poses = [0]

    def count(_: bytes) -> None:
        poses[0] += 1

    for topic, kind in message_types().items():
        node.create_subscription(kind, topic, count if topic == "pose" else lambda _: None, DEPTH, raw=True)
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    for _ in sys.stdin:
        print(poses[0], flush=True)
    os._exit(0)


def sim(motion: str, rate: float, topics: tuple[str, ...]) -> list[str]:
    """The command of the live node."""
    values = {"rate": rate, "motion": motion}
    if "imu/data_raw" in topics:
        values |= {"imu_rate": rate, "gyro_noise_density": 1e-3, "accelerometer_noise_density": 1e-2}
    if "clock" in topics:
        values["publish_clock"] = "true"
    assignments = [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]
    return [sys.executable, "-m", "lie_rigid_body", "sim", *assignments]


def contestants(rate: float, topics: tuple[str, ...]) -> dict[str, list[str]]:
    """Names and commands; the bare timer first, as the measure."""
    return {
        "bare timer": [sys.executable, __file__, "bare", str(rate), *topics],
        "moving_chart": sim("moving_chart", rate, topics),
        "closed_form": sim("closed_form", rate, topics),
    }


def cpu_seconds(pid: int) -> float:
    """Processor time of a process so far, of all its threads."""
    # to the nanosecond, unlike /proc/PID/stat
    threads = Path(f"/proc/{pid}/task").glob("*/schedstat")
    return sum(int(thread.read_text().split()[0]) for thread in threads) / 1e9


class Counter:
    """The subscriber's process."""

    def __init__(self) -> None:
        command = [sys.executable, __file__, "subscriber"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def poses(self) -> int:
        """How many came so far."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(file=self._process.stdin, flush=True)
        return int(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@contextmanager
def running(command: list[str]) -> Iterator[int]:
    """A process, as long as it is wanted."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        try:
            yield process.pid
        finally:
            process.send_signal(signal.SIGINT)


def measure(command: list[str], counter: Counter, seconds: float) -> tuple[float, float]:
    """Processor time for each sample, s, and samples per second."""
    before = counter.poses()
    with running(command) as pid:
        end = time.monotonic() + DEADLINE_S
        while counter.poses() < before + 10:
            if time.monotonic() > end:
                sys.exit(f"nothing came from: {' '.join(command)}")
            time.sleep(0.05)
        time.sleep(WARM_UP_S)
        cpu, poses, start = cpu_seconds(pid), counter.poses(), time.monotonic()
        time.sleep(seconds)
        cpu, poses, took = cpu_seconds(pid) - cpu, counter.poses() - poses, time.monotonic() - start
    return cpu / poses, poses / took


def compare(rate: float, topics: tuple[str, ...], counter: Counter, seconds: float) -> None:
    """Print the table of one rate."""
    print(f"\n{rate:g} Hz of {', '.join(topics)}\n{'':<14}{'µs a sample':>20}{'samples/s':>12}{'ratio':>8}", flush=True)
    commands = contestants(rate, topics)
    turns = [{name: measure(command, counter, seconds) for name, command in commands.items()} for _ in range(TURNS)]
    means = {name: sum(turn[name][0] for turn in turns) / TURNS for name in commands}
    for name, mean in means.items():
        costs = ", ".join(f"{turn[name][0] * 1e6:.0f}" for turn in turns)
        rates = min(turn[name][1] for turn in turns)
        print(f"{name:<14}{costs:>20}{rates:>12.1f}{mean / means['bare timer']:>8.2f}", flush=True)


def main() -> None:
    """Print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rates", type=float, nargs="+", default=[1000.0, 200.0], metavar="HZ")
    parser.add_argument("--seconds", type=float, default=6.0, help="of each reading")
    given = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 102))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    counter = Counter()
    try:
        for topics in (TRUTH, EVERYTHING):
            for rate in given.rates:
                compare(rate, topics, counter, given.seconds)
    finally:
        counter.close()


if __name__ == "__main__":
    if sys.argv[1:2] == ["bare"]:
        bare(*sys.argv[2:])
    elif sys.argv[1:2] == ["subscriber"]:
        subscriber()
    else:
        main()
