"""The three array types: float64, int64, bool."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""

Integers: TypeAlias = NDArray[np.int64]
"""Whole numbers of 64 bits: times in nanoseconds, counts, indices."""

Booleans: TypeAlias = NDArray[np.bool_]
"""Truth values."""


def plain(value: object) -> object:
    """A number or an array of NumPy as those of Python."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
