"""How far does the live node go in a second with real_time_factor 0? Beside a headless recording of the same scenario.

Simulated time by processor time of the process, in one run: alone, with a bag, and with one subscriber to pose, twist
and IMU, which a node that starts with the factor 0 waits for. A ratio of 1 means that the node goes as far as `record`
does for the same work, its start left out. The speed on the wall clock means something on an idle machine only. Run it
with

    python benchmarks/live_speed.py                     # less than a minute

in an environment with rclpy, on Linux.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from live_cost import Counter, cpu_seconds, running, sim

RATE = 1000.0
TOPICS = ("pose", "twist", "imu/data_raw")
EPOCH_NS = 1
FAST = ["-p", "real_time_factor:=0.0", "-p", "paused:=true", "-p", f"epoch_ns:={EPOCH_NS}"]
RECORDED_S = 30.0
DEADLINE_S = 30.0


class Remote:
    """The services of the node."""

    def __init__(self) -> None:
        import rclpy

        rclpy.init(args=[])
        self._node = rclpy.create_node("remote")

    def call(self, name: str) -> int:
        """Call a service; the stamp in its answer, ns, or 0."""
        import rclpy
        from std_srvs.srv import Trigger

        client = self._node.create_client(Trigger, f"/lie_rigid_body/{name}")
        if not client.wait_for_service(DEADLINE_S):
            sys.exit(f"no service {name}")
        answer = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self._node, answer, timeout_sec=DEADLINE_S)
        self._node.destroy_client(client)
        return int((re.findall(r"\d+", answer.result().message) or ["0"])[0])


def live(remote: Remote, command: list[str], seconds: float) -> tuple[float, float, float]:
    """Simulated time, processor time and time of the wall, s."""
    with running(command) as pid:
        first = remote.call("pause")
        time.sleep(1.0)  # for a subscriber and the node to meet
        cpu, begin = cpu_seconds(pid), time.monotonic()
        remote.call("resume")
        time.sleep(seconds)
        last = remote.call("pause")
        return (last - first) / 1e9, cpu_seconds(pid) - cpu, time.monotonic() - begin


def headless(command: list[str], duration: float) -> tuple[float, float, float]:
    """The same of a recording, without what a short one takes as well."""
    (short, cpu_of_short), (long, cpu) = (recorded(command, time_s) for time_s in (1.0, duration + 1.0))
    return duration, cpu - cpu_of_short, long - short


def recorded(command: list[str], duration: float) -> tuple[float, float]:
    """Time of the wall and processor time of a recording, s."""
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*command, "--force", "--duration", str(duration)], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - begin, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5.0, help="of each reading")
    given = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 102))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    node, remote = sim("moving_chart", RATE, TOPICS), Remote()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        bag, other = Path(folder) / "live.mcap", Path(folder) / "headless.mcap"
        results = {
            "alone": live(remote, [*node, *FAST], given.seconds),
            "with a bag": live(remote, [*node, *FAST, "-p", f"record_path:={bag}"], given.seconds),
        }
        record = [*node[:3], "record", str(other), "--quiet", *node[4:]]
        results["record"] = headless(record, RECORDED_S)
        stack.callback(Counter().close)
        results["with a subscriber"] = live(remote, [*node, *FAST], given.seconds)
    measure = results["record"][0] / results["record"][1]
    print(f"{'':<20}{'simulated s by s of work':>26}{'ratio':>8}{'times real time':>18}")
    for name, (simulated, worked, took) in results.items():
        print(f"{name:<20}{simulated / worked:>26.1f}{simulated / worked / measure:>8.2f}{simulated / took:>18.1f}")


if __name__ == "__main__":
    main()
