"""Bodies and their initial states as arrays with one leading axis of length B, whatever the shape of the batch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.motion import batch_shape, flat_batch
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class InitialConditions:
    """B bodies, each with its state at time 0.

    Attributes
    ----------
    batch : tuple of int
        The leading axes of the batch that they were given as, of product B; () for one body alone.
    inertia, inverse_inertia : ndarray, shape (B, 3, 3)
        In the body frame, kg m² and its inverse.
    attitude_xyzw : ndarray, shape (B, 4)
        World from body.
    body_rate : ndarray, shape (B, 3)
        rad/s
    """

    batch: tuple[int, ...]
    inertia: Array
    inverse_inertia: Array
    attitude_xyzw: Array
    body_rate: Array

    __repr__ = short_repr

    @classmethod
    def of(cls, body: RigidBody, start: State) -> InitialConditions:
        """The initial conditions of a body or a batch of bodies, with the start broadcast to it.

        Raises
        ------
        InputError
            If body and start do not go together; see `batch_shape`.
        """
        batch = batch_shape(body, start)
        return cls(
            batch,
            flat_batch(body.inertia, batch, 3, 3),
            flat_batch(body.inverse_inertia, batch, 3, 3),
            flat_batch(start.attitude_xyzw, batch, 4),
            flat_batch(start.body_rate, batch, 3),
        )

    def error_prefix(self, place: int) -> str:
        """The beginning of a message about one body: its index in the batch, or nothing for a body alone."""
        index = tuple(int(i) for i in np.unravel_index(place, self.batch)) if self.batch else ()
        return f"body {index[0] if len(index) == 1 else index}: " if index else ""
