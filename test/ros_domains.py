"""ROS domains for tests, each used by one test process of this machine at a time."""

from __future__ import annotations

import fcntl
import os
import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Above 101 the ports of a domain reach into the range that Linux hands out to clients; 0 is everybody's default.
DOMAINS = range(1, 102)


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS domain that no other test process of this machine uses while the context lasts."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        lock = Path(tempfile.gettempdir()) / f"ros-domain-{domain}.lock"
        try:
            handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        except PermissionError:
            continue
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            continue
        try:
            yield domain
        finally:
            os.close(handle)
        return
    raise RuntimeError(f"all {len(DOMAINS)} ROS domains are in use by other test runs: wait for them to end")
