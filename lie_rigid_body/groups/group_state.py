"""The state of a motion on a matrix Lie group: where it is, and how fast it moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class GroupState:
    """A group element and the rate in its own frame, of one instant or of many.

    Parameters
    ----------
    element : ndarray, shape (..., n, n)
        A, real or complex.
    rate : ndarray, shape (..., d)
        Coordinates ω of A⁻¹Ȧ = ωᵃTᵃ, 1/s.
    """

    element: NDArray[Any]
    rate: NDArray[np.float64]
