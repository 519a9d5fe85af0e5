"""The closed form across kicks, at any time: each arc begins with the exact attitude in which the one before ended."""

from __future__ import annotations

from decimal import Decimal
from operator import itemgetter
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.decimals import dot, working_precision
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.closed_form.rotation import DIGITS, Rotation, rotation_of
from lie_rigid_body.motion.closed_form.solution import ClosedForm
from lie_rigid_body.motion.kicks import KickedMotion, Kicks
from lie_rigid_body.motion.motion import Samples, exact_inertia

KEPT_STARTS: Final = 1000
"""Arcs from one start that is kept to the next: no question costs more than so many arcs."""
_KEPT_MOTIONS: Final = 1000
"""Number of motions that are kept, beside that of the start: those of as many kicks as there may be in a period."""


class KickedClosedForm(KickedMotion):
    """A kicked motion by the exact solution, which may be asked for any time.

    Attitudes go on from arc to arc in decimals, so that round-off does not grow. The motions of the latest arcs are
    kept, the latest begin, and that of every thousandth arc. Copies share the last.

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
        given = [Decimal(component) for component in start.attitude_xyzw.tolist()]
        with working_precision(DIGITS):
            size = dot(given, given).sqrt()
            self._latest: tuple[int, Rotation] = 0, tuple(component / size for component in given)
        self._starts = dict([self._latest])
        self._motions = {0: ClosedForm(body, start)}

    def _samples(self, t_ns: Integers) -> Samples:
        return self._by_arcs(t_ns, self._motion_of)

    def _motion_of(self, arc: int) -> ClosedForm:
        """The free motion of an arc."""
        motion = self._motions.get(arc)
        if motion is None:
            motion = self._free(arc)
            first, *others = self._motions.items()
            self._motions = dict([first, *others[-_KEPT_MOTIONS:], (arc, motion)])
        return motion

    def _free(self, arc: int) -> ClosedForm:
        attitude = np.array(self._attitude(arc), np.float64)
        return ClosedForm(self._body, State.trusted(attitude, self._kicks.rate(arc)))

    def _attitude(self, wanted: int) -> Rotation:
        """The attitude in which an arc begins."""
        known = [begin for begin in (*self._starts.items(), self._latest) if begin[0] <= wanted]
        arc, attitude = max(known, key=itemgetter(0))
        while arc < wanted:
            rate = self._kicks.rate(arc) if arc else self._start.body_rate
            elapsed_ns = self._kicks.begin_ns(arc + 1) - self._kicks.begin_ns(arc)
            turned = rotation_of(exact_inertia(self._body), tuple(rate.tolist()), elapsed_ns)
            with working_precision(DIGITS):
                attitude = product(attitude, turned)
            arc += 1
            if arc % KEPT_STARTS == 0:
                self._starts[arc] = attitude
        self._latest = arc, attitude
        return attitude
