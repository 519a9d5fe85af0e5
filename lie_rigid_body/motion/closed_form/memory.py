"""How many states of the closed form are computed at once, within the memory that a caller allows."""

from __future__ import annotations

from typing import Final

from lie_rigid_body.motion.memory import Footprint, samples_within

_FOOTPRINT: Final = Footprint(body=0, time=8, sample=512)
"""Of a sample being computed 340 to 420, by measurement."""


def samples_at_once(bodies: int, times: int, memory_limit: int) -> int:
    """The number of samples to compute at once, at least 1; see `motion.memory`."""
    return samples_within(bodies, times, memory_limit, _FOOTPRINT)
