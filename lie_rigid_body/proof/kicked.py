"""Enclosures of a kicked motion: the rotations of its arcs, each enclosed by itself, multiplied one after the other.

A free motion from the attitude A is A times the one from the identity, as the world has no axis of its own. So an arc
needs the exact rate after its kick alone, and the attitude in which it begins may be a ball.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from flint import ctx
from numpy.typing import ArrayLike

from lie_rigid_body.proof.balls import product
from lie_rigid_body.proof.enclosure import Enclosure, enclose

_IDENTITY = (0.0, 0.0, 0.0, 1.0)


class EnclosedMotion:
    """True states of a body across kicks.

    Parameters
    ----------
    inertia : array_like, shape (3,) or (6,)
        kg m², taken as exact.
    attitude_xyzw : array_like, shape (4,)
        At the start, taken as exact, and normalised exactly.
    begins_ns : sequence of int
        Times at which its arcs begin, ns since the start, rising from 0.
    body_rates : sequence of array_like, shape (3,)
        Body rates with which they begin, rad/s, taken as exact.
    """

    def __init__(
        self,
        inertia: ArrayLike,
        attitude_xyzw: ArrayLike,
        begins_ns: Sequence[int],
        body_rates: Sequence[ArrayLike],
    ) -> None:
        self._inertia = inertia
        self._start = attitude_xyzw
        self._begins_ns = begins_ns
        self._rates = body_rates
        self._ends: list[Enclosure] = []

    def at(self, t_ns: int) -> Enclosure:
        """The enclosure of the state at a time, ns since the start."""
        arc = max(0, bisect_right(self._begins_ns, t_ns) - 1)
        while len(self._ends) < arc:
            before = len(self._ends)
            self._ends.append(self._state(before, self._begins_ns[before + 1]))
        return self._state(arc, t_ns)

    def _state(self, arc: int, t_ns: int) -> Enclosure:
        """The state at a time, on an arc whose own begin is known."""
        elapsed_ns = t_ns - self._begins_ns[arc]
        if not arc:
            return enclose(self._inertia, self._start, self._rates[0], elapsed_ns)
        own = enclose(self._inertia, _IDENTITY, self._rates[arc], elapsed_ns)
        before = self._ends[arc - 1]
        bits = max(own.bits, before.bits)
        with ctx.workprec(bits):
            return Enclosure(product(before.attitude_xyzw, own.attitude_xyzw), own.body_rate, bits)
