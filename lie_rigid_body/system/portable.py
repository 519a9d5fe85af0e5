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


def user() -> int:
    """Number of the user whose rights this process has; 0, that of every file, where users have none."""
    return os.geteuid() if hasattr(os, "geteuid") else 0


def is_private(folder: Path) -> bool:
    """Whether only this user, and the system itself, may write to a folder or put another in its place.

    Where users have no numbers, the folders of a user are their own.
    """
    may_write = os.access(folder, os.W_OK, effective_ids=os.access in os.supports_effective_ids)
    if not hasattr(os, "geteuid"):
        return may_write
    above = [parent.stat() for parent in folder.resolve().parents]
    own = folder.stat()
    return (
        own.st_uid == user()
        and not _others_write(own)
        and may_write
        and not any(_others_write(state) and not state.st_mode & stat.S_ISVTX for state in above)
        and all(state.st_uid in (0, user()) for state in above)
    )


def _others_write(state: os.stat_result) -> bool:
    """Whether others may write to a folder: all, or a group that is not that of this user alone."""
    by_group = state.st_mode & stat.S_IWGRP and state.st_gid != 0 and not _is_of_one(state.st_gid)
    return bool(state.st_mode & stat.S_IWOTH or by_group)


def _is_of_one(group: int) -> bool:
    """Whether a group is of this user alone, as its name says: who has it as primary group is not among its members."""
    import grp  # where users have numbers, groups have members
    import pwd

    try:
        name = pwd.getpwuid(user()).pw_name
        found = grp.getgrgid(group)
    except (KeyError, OSError):  # a group or a user without a name
        return False
    return found.gr_name == name and not {*found.gr_mem} - {name}
