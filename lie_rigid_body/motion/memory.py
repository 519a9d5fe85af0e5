"""How many states are computed at once, within the memory that a caller allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.errors import InputError

DEFAULT_MEMORY_LIMIT: Final = 4 * 1024**3
"""Bytes."""

_MOST: Final = 8192
"""Samples taken at once: their temporaries then stay in a processor's cache."""

_FEWEST: Final = 256
"""With fewer at once, most of the time goes into starting each operation."""

_STATE: Final = 7 * 8
"""Bytes of an attitude and a rate."""

_REST: Final = 1024 * 1024
"""Bytes of what does not grow with the samples, tuples that Python keeps for later among it."""


@dataclass(frozen=True)
class Footprint:
    """Bytes that a motion takes beside the states that it gives, at the worst moment.

    Attributes
    ----------
    body : int
        Of each body.
    time : int
        Of each time.
    sample : int
        Of each sample that is being computed.
    """

    body: int
    time: int
    sample: int


def samples_within(bodies: int, times: int, memory_limit: int, footprint: Footprint) -> int:
    """The number of samples to compute at once, at least 1.

    Where the limit is narrow it is small, but never so small that the evaluation would crawl.

    Parameters
    ----------
    bodies, times : int
        The samples are their product.
    memory_limit : int
        Bytes that the states and everything made on the way may take.
    footprint : Footprint

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
    fixed = bodies * times * _STATE + bodies * footprint.body + times * footprint.time + _REST
    least = fixed + footprint.sample * min(_FEWEST, bodies * times)
    if memory_limit < least:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {bodies} bodies at {times} times, which take "
            f"{least}: ask for fewer at once, or give a larger memory_limit"
        )
    return max(1, min(_MOST, (int(memory_limit) - fixed) // footprint.sample))
