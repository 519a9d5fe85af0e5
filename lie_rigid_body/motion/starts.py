"""Bodies and their starts, one after the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.motion import batch_shape

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Starts:
    """B bodies, each with its start.

    Attributes
    ----------
    batch : tuple of int
        The leading axes that they had, of product B.
    inertia, inverse_inertia : ndarray, shape (B, 3, 3)
    attitude_xyzw : ndarray, shape (B, 4)
    body_rate : ndarray, shape (B, 3)
    """

    batch: tuple[int, ...]
    inertia: Array
    inverse_inertia: Array
    attitude_xyzw: Array
    body_rate: Array

    @classmethod
    def of(cls, body: RigidBody, start: State) -> Starts:
        """Those of a body or a batch, broadcast.

        Raises
        ------
        InputError
            See `batch_shape`.
        """
        batch = batch_shape(body, start)

        def line(values: Array, *own: int) -> Array:
            shape = (*batch, *own)
            return (values if values.shape == shape else np.broadcast_to(values, shape)).reshape(-1, *own)

        tensors = line(body.inertia, 3, 3), line(body.inverse_inertia, 3, 3)
        return cls(batch, *tensors, line(start.attitude_xyzw, 4), line(start.body_rate, 3))

    def name(self, place: int) -> str:
        """Which body this is, as a batch has it at an index; nothing for one alone."""
        index = tuple(int(i) for i in np.unravel_index(place, self.batch)) if self.batch else ()
        return f"body {index[0] if len(index) == 1 else index}: " if index else ""
