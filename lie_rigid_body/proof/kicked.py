"""Enclosures of a kicked motion: the rotations of its arcs, each enclosed by itself, multiplied one after the other.

A free motion from the attitude A is A times the one from the identity, as the world has no axis of its own. So an arc
needs the exact rate after its kick alone, and the attitude in which it begins may be a ball. That is a quaternion with
one bound of its distance from the true one. As norms of quaternions multiply, bounds add up from arc to arc; intervals
of the components would double.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from flint import arb, ctx
from numpy.typing import ArrayLike

from lie_rigid_body.proof.balls import Balls, norm, product
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
        self._ends: list[tuple[Balls, arb]] = []

    def at(self, t_ns: int) -> Enclosure:
        """The enclosure of the state at a time, ns since the start."""
        arc = max(0, bisect_right(self._begins_ns, t_ns) - 1)
        for before in range(len(self._ends), arc):
            self._ends.append(self._state(before, self._begins_ns[before + 1])[:2])
        middle, bound, own = self._state(arc, t_ns)
        with ctx.workprec(own.bits):
            return Enclosure(tuple(x + arb(0, bound) for x in middle), own.body_rate, own.bits)

    def _state(self, arc: int, t_ns: int) -> tuple[Balls, arb, Enclosure]:
        """The attitude at a time of an arc whose begin is known, a bound of its distance, and the arc alone."""
        elapsed_ns = t_ns - self._begins_ns[arc]
        own = enclose(self._inertia, _IDENTITY if arc else self._start, self._rates[arc], elapsed_ns)
        with ctx.workprec(own.bits):
            middle, bound = _parted(own.attitude_xyzw)
            if arc:
                before, bound_before = self._ends[arc - 1]
                bound = bound_before * norm(middle) + bound * (norm(before) + bound_before)
                middle, rounding = _parted(product(before, middle))
                bound += rounding
            return middle, bound.upper(), own


def _parted(balls: Balls) -> tuple[Balls, arb]:
    """The middle of a quaternion of balls, and a bound of the distance from it."""
    return tuple(x.mid() for x in balls), norm(tuple(x.rad() for x in balls)).upper()
