"""How many states are computed at once, within the memory that a caller allows."""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.errors import InputError

_MOST: Final = 8192
"""Samples taken at once: their temporaries then stay in a processor's cache."""

_STATE: Final = 7 * 8
"""Bytes of an attitude and a rate."""

_TIME: Final = 8

_TEMPORARIES: Final = 768
"""Bytes of everything between a sample's time and its state, at the worst moment."""

_REST: Final = 64 * 1024
"""Bytes of what does not grow with the samples."""


def samples_at_once(bodies: int, times: int, memory_limit: int) -> int:
    """The number of samples to compute at once, at least 1.

    Parameters
    ----------
    bodies, times : int
        The samples are their product.
    memory_limit : int
        Bytes that the states and everything made on the way may take.

    Returns
    -------
    int

    Raises
    ------
    InputError
        If the limit is no integer, or there is no room for the states and one sample at once.
    """
    if not isinstance(memory_limit, int | np.integer) or isinstance(memory_limit, bool):
        raise InputError(f"memory_limit {memory_limit!r} is not a number of bytes: give an integer")
    fixed = bodies * times * _STATE + times * _TIME + _REST
    if memory_limit < fixed + _TEMPORARIES:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {bodies} bodies at {times} times, which take "
            f"{fixed + _TEMPORARIES}: ask for fewer at once, or give a larger memory_limit"
        )
    return min(_MOST, (int(memory_limit) - fixed) // _TEMPORARIES)
