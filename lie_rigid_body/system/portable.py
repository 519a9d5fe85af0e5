"""Parts of an operating system that not all have: cores of a process, locks, links, owners and modes of folders.

Each part is asked for by its name, not by that of the system.
"""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

_OTHERS_WRITE: Final = stat.S_IWGRP | stat.S_IWOTH
MAX_PROCESSES: Final = 9999
"""Largest number of processes that a caller may ask for."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def limit(name: str) -> float:
    """A limit of this process by its name in `resource`, such as RLIMIT_NOFILE; infinite where there is none."""
    try:
        import resource
    except ImportError:
        return math.inf
    found, _ = resource.getrlimit(getattr(resource, name))
    return math.inf if found == resource.RLIM_INFINITY else found


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """A context in which no other process locks a folder; systems without `flock` do not keep it from others.

    Raises
    ------
    BlockingIOError
        If another process has locked it.
    OSError
        If it cannot be opened, or its file system has no locks.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def real_path(path: Path) -> Path:
    """A path whose links are followed; links in a circle, which lead to no file, stay in it."""
    return Path(os.path.realpath(path))


def is_private(folder: Path) -> bool:
    """Whether a folder belongs to this user, and nobody else may write to it; where users have no numbers it does."""
    state = folder.stat()
    return not hasattr(os, "geteuid") or (state.st_uid == os.geteuid() and not state.st_mode & _OTHERS_WRITE)
