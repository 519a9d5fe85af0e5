"""The closed form across kicks, at any time: each arc begins with the exact attitude in which the one before ended."""

from __future__ import annotations

from decimal import Decimal
from operator import itemgetter
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.rotation import DIGITS, Rotation, rotation_of
from lie_rigid_body.motion.closed_form.solution import ClosedForm
from lie_rigid_body.motion.kicks import KickedMotion, Kicks
from lie_rigid_body.motion.motion import exact_inertia

KEPT_STARTS: Final = 1000
"""Arcs from one start that is kept to the next: no question costs more than so many arcs."""

_Arc: TypeAlias = tuple[int, Rotation, ClosedForm]
"""Number of an arc, the attitude in which it begins, in decimals, and its motion."""


class KickedClosedForm(KickedMotion):
    """A kicked motion by the exact solution, which may be asked for any time.

    Attitudes go on from arc to arc in decimals, so that round-off does not grow. Two arcs are kept, and the start of
    every thousandth. Copies share those starts.

    Parameters
    ----------
    kicks : Kicks
    body : RigidBody
    start : State
        State at time 0, of one instant.
    """

    def __init__(self, kicks: Kicks, body: RigidBody, start: State) -> None:
        super().__init__(kicks, start)
        self._body = body
        with working_precision(DIGITS):
            x, y, z, w = map(Decimal, start.attitude_xyzw.tolist())
            size = (x * x + y * y + z * z + w * w).sqrt()
            attitude = (x / size, y / size, z / size, w / size)
        first = 0, attitude, ClosedForm(body, start)
        self._starts = {0: attitude}
        self._recent: tuple[_Arc, ...] = (first, first)

    def _samples(self, t_ns: Integers) -> tuple[Array, Array]:
        return self._by_arcs(t_ns, lambda arc: self._arc(arc)[2])

    def _arc(self, wanted: int) -> _Arc:
        for recent in self._recent:
            if recent[0] == wanted:
                return recent
        begin = max(begin for begin in self._starts if begin <= wanted)
        before = [(arc, attitude) for arc, attitude, _ in self._recent if begin <= arc < wanted]
        arc, attitude = max(before, key=itemgetter(0), default=(begin, self._starts[begin]))
        while arc < wanted:
            elapsed_ns = self._kicks.begin_ns(arc + 1) - self._kicks.begin_ns(arc)
            turned = rotation_of(exact_inertia(self._body), self._rate(arc), elapsed_ns)
            with working_precision(DIGITS):
                attitude = product(attitude, turned)
            arc += 1
            if arc % KEPT_STARTS == 0:
                self._starts[arc] = attitude
        found = arc, attitude, self._free(arc, attitude)
        self._recent = (self._recent[-1], found)
        return found

    def _rate(self, arc: int) -> tuple[float, float, float]:
        x, y, z = (self._kicks.rate(arc) if arc else self._start.body_rate).tolist()
        return x, y, z

    def _free(self, arc: int, attitude: Rotation) -> ClosedForm:
        if not arc:
            return ClosedForm(self._body, self._start)
        return ClosedForm(self._body, State.trusted(np.array([float(x) for x in attitude]), self._kicks.rate(arc)))
