"""The call of an estimator in a process that goes on with other runs, as it was before."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final

from lie_rigid_body.errors import InputError

try:
    import resource
except ImportError:
    resource = None  # type: ignore[assignment]

_LIMITED: Final = [name for name in dir(resource) if name.startswith("RLIMIT_")]
"""Names of the limits that the system has, none without such limits."""
Limits = dict[str, tuple[int, int]]
"""Soft and hard limits of a process, by their names."""


class _Forks:
    """Copies that this process has made of itself; programs that it started are none."""

    count = 0

    @classmethod
    def add(cls) -> None:
        cls.count += 1


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_parent=_Forks.add)


@contextmanager
def leaving_the_process_alone() -> Iterator[None]:
    """A context for the call of an estimator, which may neither leave copies of the process nor lower its limits.

    A copy has all connections of the process, and would answer on them or hold them open. It ends where it comes back
    from the call, and is killed where it still runs when the process itself is back. A worker whose limit of open files
    is too low waits for ever: limits are set back, and where the system refuses that, the process ends.

    Raises
    ------
    InputError
        If there were such copies or limits, and the estimator raised nothing else.
    """
    own, forks, limits = os.getpid(), _Forks.count, _limits()
    try:
        yield
    finally:
        if os.getpid() != own:
            os._exit(1)
        lowered = _set_back(limits)
        left = _end_copies() if _Forks.count > forks else 0
    if lowered:
        raise InputError(f"it lowers {' and '.join(lowered)} of the process it is called in: leave limits as they are")
    if left:
        remedy = "wait for them, or start programs instead"
        raise InputError(f"it forks, and leaves copies of its process running ({left}): {remedy}")


def _limits() -> Limits:
    return {name: resource.getrlimit(getattr(resource, name)) for name in _LIMITED}


def _set_back(before: Limits) -> list[str]:
    """Set limits back that are lower than before, and return their names; end the process if that is refused."""
    now = _limits()
    lowered = [name for name, limits in before.items() if any(map(_is_lower, now[name], limits))]
    for name in lowered:
        try:
            resource.setrlimit(getattr(resource, name), before[name])
        except (OSError, ValueError):
            os._exit(1)
    return lowered


def _is_lower(limit: int, other: int) -> bool:
    """Whether a limit is lower than another; a negative one is none at all."""
    return 0 <= limit < other or limit >= 0 > other


def _end_copies() -> int:
    """Kill the children that are copies of this process, and return how many there were."""
    try:
        import psutil  # with Dask
    except ImportError:
        return 0
    this, count = psutil.Process(), 0
    for child in this.children():
        with suppress(psutil.Error):
            if child.status() != psutil.STATUS_ZOMBIE and child.cmdline() == this.cmdline():
                child.kill()
                count += 1
    return count
