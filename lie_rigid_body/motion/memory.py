"""How many states are computed at once, within the memory that a caller allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.errors import InputError

DEFAULT_MEMORY_LIMIT: Final = 4 * 1024**3
"""Default memory limit, bytes."""

_LARGEST_BLOCK: Final = 8192
"""Largest number of samples at once: their temporaries fit into a processor's cache."""

_SMALLEST_BLOCK: Final = 256
"""Smallest number of samples at once: with fewer, starting an array operation takes longer than the operation."""

_STATE_BYTES: Final = 7 * 8
"""Size of an attitude and a body rate in doubles, bytes."""

_FIXED_BYTES: Final = 1024 * 1024
"""Fixed overhead, bytes, including Python's free lists."""


@dataclass(frozen=True)
class WorkingMemory:
    """The memory that computing states takes at its peak, beside the states themselves.

    Attributes
    ----------
    body : int
        Bytes for each body.
    time : int
        Bytes for each time.
    sample : int
        Bytes for each sample of the block that is being computed.
    """

    body: int
    time: int
    sample: int


def samples_within(bodies: int, times: int, memory_limit: int, needs: WorkingMemory) -> int:
    """The number of samples to compute at once, at least 1.

    Where the limit is narrow it is small, but never so small that the evaluation would crawl.

    Parameters
    ----------
    bodies, times : int
        The samples are their product.
    memory_limit : int
        Bytes that the states and everything made on the way may take.
    needs : WorkingMemory

    Returns
    -------
    int

    Raises
    ------
    InputError
        If the limit is no integer, or leaves no room for the states and a small block of temporaries.
    """
    if not isinstance(memory_limit, int | np.integer) or isinstance(memory_limit, bool):
        raise InputError(f"memory_limit {memory_limit!r} is not a number of bytes: give an integer")
    fixed = bodies * times * _STATE_BYTES + bodies * needs.body + times * needs.time + _FIXED_BYTES
    least = fixed + needs.sample * min(_SMALLEST_BLOCK, bodies * times)
    if memory_limit < least:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {bodies} bodies at {times} times, which take "
            f"{least}: ask for fewer at once, or give a larger memory_limit"
        )
    return max(1, min(_LARGEST_BLOCK, (int(memory_limit) - fixed) // needs.sample))


Footprint = WorkingMemory  # the name that `closed_form` knows it by
