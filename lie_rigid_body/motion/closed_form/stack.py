"""Motions of one kind side by side, evaluated as one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.closed_form.columns import filled
from lie_rigid_body.motion.closed_form.double_double import Array, DoubleDouble


class BodyMotion(Protocol):
    """A nest of dataclasses and tuples of numbers, which its formulas take element by element."""

    def states(self, time: DoubleDouble) -> State:
        """The states at these nanoseconds, shape (N,): (B, N, 4) and (B, N, 3), where the numbers are columns."""
        ...


@dataclass(frozen=True)
class Stack:
    """Motions of one kind.

    Attributes
    ----------
    members : ndarray of int, shape (B,)
        Which motions of the ensemble these are.
    form : BodyMotion
        One of their kind; its own numbers do not matter.
    constants : ndarray, shape (numbers, B)
        Their numbers in the order of `columns.numbers`.
    """

    members: NDArray[np.intp]
    form: BodyMotion
    constants: Array

    @cached_property
    def whole(self) -> BodyMotion:
        """All of the motions, as one."""
        return filled(self.form, iter(self.constants[:, :, np.newaxis]))

    def part(self, some: slice) -> BodyMotion:
        """Some of the motions, as one."""
        if some == slice(0, len(self.members)):
            return self.whole
        return filled(self.form, iter(self.constants[:, some, np.newaxis]))
