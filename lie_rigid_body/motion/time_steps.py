"""Number of equal steps between two sample times."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError

MAX_STEPS: Final = 1e15
"""Largest number of steps in one call: a year's work."""

_SLACK: Final = 1e-9
"""Slack, in steps: how far an interval may exceed a whole number of largest steps by round-off."""

_SHRUNK: Final = 1.0 - 1e-15
"""Relative slack of a number of steps: a factor 1e-15 below 1."""

_MAX_PER_NS: Final = 1e280
"""Cap on the number of steps in a nanosecond: larger numbers would overflow, and are refused anyway."""


def steps_between(period_s: float, max_step: float) -> int:
    """How many equal steps divide the time between two samples, none longer than allowed; at least 1.

    Parameters
    ----------
    period_s, max_step : float
        Positive, s.

    Returns
    -------
    int
    """
    return max(1, int(_whole(1e9 * period_s * _steps_per_ns(max_step))))


def _steps_per_ns(max_step: float) -> float:
    return min(1e-9 / max_step, _MAX_PER_NS)


def _whole(steps: NDArray[np.floating[Any]] | float) -> Array:
    """The least whole number of steps, but for the round-off of a time that the largest step divides."""
    return np.ceil(_SHRUNK * steps - _SLACK)


def steps_to(times_ns: Integers, reached_ns: int, max_step: float) -> tuple[Integers, Integers]:
    """The equal steps, none longer than allowed, that lead to each time from the one before.

    Parameters
    ----------
    times_ns : ndarray of int64, shape (N,)
        Nanoseconds since the start, in order.
    reached_ns : int
        The time already reached.
    max_step : float
        s

    Returns
    -------
    spans, counts : ndarray of int64, shape (N,)
        Time since the one before, ns, and how many steps divide it.

    Raises
    ------
    InputError
        If the last lies impossibly many steps ahead.
    """
    steps_through(int(times_ns.max(initial=reached_ns)), reached_ns, max_step)
    spans = np.diff(times_ns, prepend=reached_ns)
    counts = _whole(spans * _steps_per_ns(max_step))
    return spans, np.maximum(counts, spans > 0).astype(np.int64)


def steps_through(last_ns: int, reached_ns: int, max_step: float) -> int:
    """About how many steps, none longer than allowed, lead from a time already reached to a later one.

    Raises
    ------
    InputError
        If they are impossibly many.
    """
    per_ns = _steps_per_ns(max_step)
    steps = (last_ns - reached_ns) * per_ns
    if steps > MAX_STEPS:
        raise InputError(
            f"{last_ns} ns lie too many steps of {1e-9 / per_ns:.3g} s ahead: ask for an earlier time, "
            "take longer steps if it is max_step that limits them, or use ClosedForm"
        )
    return math.ceil(steps)


def require_order(times_ns: Integers, reached_ns: int) -> None:
    """Refuse times that go back.

    Parameters
    ----------
    times_ns : ndarray of int64, shape (N,)
    reached_ns : int
        The time already reached.

    Raises
    ------
    InputError
        Naming the first that lies before one already reached.
    """
    path = np.append(np.int64(reached_ns), times_ns)
    back = path[1:] < path[:-1]
    if back.any():
        i = np.argmax(back)
        raise InputError(
            f"t_ns {path[i + 1]} lies before {path[i]}, which is already reached: give times that do not decrease, or "
            "start a new motion"
        )
