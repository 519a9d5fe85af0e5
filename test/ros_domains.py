"""ROS domains for tests, each used by one process at a time, of tests or of those that play to a filter."""

from __future__ import annotations

import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import distributions, version

# Above 101 the ports of a domain reach into the range that Linux hands out to clients; 0 is everybody's default.
DOMAINS = range(1, 102)
RCLPY = next((version(name) for name in ("rclpy", "ros-rclpy") if [*distributions(name=name)]), "7")
PROFILES_FILE = f"{'FASTRTPS' if int(RCLPY.partition('.')[0]) < 8 else 'FASTDDS'}_DEFAULT_PROFILES_FILE"
"""Variable that names the settings of Fast DDS: since Kilted a warning tells of the older one."""
HELD = "\0lie_rigid_body/played-to/{}"
"""Name of the socket by which a domain is held."""


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS domain that no other test process of this machine uses while the context lasts."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as held:
            try:
                held.bind(HELD.format(domain))
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError(f"all {len(DOMAINS)} ROS domains are in use by other test runs: wait for them to end")
