"""How many states are computed at once, within the memory that a caller allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import shown

DEFAULT_MEMORY_LIMIT: Final = 4 * 1024**3
"""Memory that one call may take by default, bytes (4 GiB)."""

_LARGEST_BLOCK: Final = 8192
"""Largest number of samples computed at once: their temporaries fit into a processor's cache."""

_SMALLEST_BLOCK: Final = 256
"""Smallest number of samples computed at once: with fewer, calling an array operation takes longer than its work."""

_STATE_BYTES: Final = 7 * 8
"""Bytes of one state: 4 + 3 doubles."""

_FIXED_BYTES: Final = 1024 * 1024
"""Bytes taken whatever the number of samples, including Python's free lists of tuples."""


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
    """The number of samples to compute at once.

    At most 8192; at least 256 or all samples, whichever is fewer. Otherwise InputError.

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
    fixed = bodies * times * _STATE_BYTES + bodies * needs.body + times * needs.time + _FIXED_BYTES
    least = fixed + needs.sample * min(_SMALLEST_BLOCK, bodies * times)
    require_memory(least, memory_limit, f"{bodies} bodies at {times} times")
    return max(1, min(_LARGEST_BLOCK, (int(memory_limit) - fixed) // needs.sample))


def require_memory(least: int, memory_limit: int, what: str) -> None:
    """Refuse work that does not fit into the memory that a caller allows.

    Parameters
    ----------
    least : int
        Bytes that it takes.
    memory_limit : int
        Bytes that it may take.
    what : str
        What takes them, in the plural.

    Raises
    ------
    InputError
        Also if the limit is no integer.
    """
    if not isinstance(memory_limit, int | np.integer) or isinstance(memory_limit, bool):
        raise InputError(f"memory_limit {shown(memory_limit)} is not a number of bytes: give an integer")
    if memory_limit < least:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {what}, which take {least}: "
            "ask for fewer at once, or give a larger memory_limit"
        )
