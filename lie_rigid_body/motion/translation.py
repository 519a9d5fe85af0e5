"""Motion of the mass centre, the other half of Chasles' theorem: at rest, thrown, or carried by a sum of harmonics.

A force through the mass centre makes no torque, so the two halves know nothing of each other (A. Lucas, arXiv
1111.1275, section 2): a translation is a function of time, as a rotation is.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Final, Protocol

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.motion.harmonics import Harmonics
from lie_rigid_body.motion.kicks import Kicks
from lie_rigid_body.motion.mass_centre import MassCentre

_UP: Final = np.array([0.0, 0.0, 1.0])


class Translation(Protocol):
    """Motion of the mass centre."""

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""


@short_dataclass
class UniformAndMore:
    """A mass centre that moves evenly, and beside that in another way: x₀ + v₀ t + x(t).

    Attributes
    ----------
    position, velocity : tuple of float, length 3
        x₀ and v₀, m and m/s.
    more : Translation
        x(t), a fall or a sway.
    """

    position: Vector
    velocity: Vector
    more: Translation

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        seconds = (t_ns / NS)[:, np.newaxis]
        more = self.more.at(t_ns)
        position = self.position + (seconds * self.velocity + more.position)
        return MassCentre(position, self.velocity + more.velocity, more.acceleration)


@short_dataclass
class Fall:
    """A fall from rest, −½ g t² ẑ, by the gravity g, m/s². Without gravity it is a rest."""

    gravity: float

    def at(self, t_ns: Integers) -> MassCentre:
        """The fall at N times, ns since the start."""
        seconds = (t_ns / NS)[:, np.newaxis]
        fall = 0.0 - self.gravity * _UP
        return MassCentre((0.5 * seconds * seconds) * fall, seconds * fall, np.tile(fall, (len(t_ns), 1)))


@short_dataclass
class Sway:
    """A sum of harmonics, which slows to a stop when a rest begins, and gathers speed when it ends.

    The pace of its own time is 1 while the body moves and 0 while it rests. After a change it goes from one to the
    other within T, as S(x) = x³ (10 − 15 x + 6 x²) does, with x = t/T. Changes within T of each other add up.

    Attributes
    ----------
    harmonics : Harmonics
    kicks : Kicks
    moves_first : bool
        Whether the body moves before the first kick.
    ramp_s : float
        T, s.
    """

    harmonics: Harmonics
    kicks: Kicks
    moves_first: bool
    ramp_s: float

    def at(self, t_ns: Integers) -> MassCentre:
        """The way from the start at N times, ns since the start."""
        whole_ns, beyond_ns, *paces = self.own_time(t_ns)
        pace, change = (each[:, np.newaxis] for each in paces)
        sway = self.harmonics.at(whole_ns, beyond_ns)
        acceleration = sway.acceleration * (pace * pace) + sway.velocity * change
        return MassCentre(sway.position - self._origin, sway.velocity * pace, acceleration)

    @cached_property
    def _origin(self) -> Array:
        """Position of the harmonics at their time 0, m, shape (1, 3)."""
        return self.harmonics.at(np.zeros(1, dtype=np.int64)).position

    @cached_property
    def _moves(self) -> Integers:
        """1 for each arc of a period in motion, 0 for one at rest; the first one comes once."""
        return np.append(int(self.moves_first), self.kicks.body_rate.any(axis=1))

    @cached_property
    def _moved_ns(self) -> Integers:
        """Time in motion before the begin of each arc of a period, ns, and of the one after it."""
        kicks_ns = self.kicks.t_ns
        ends = np.append(kicks_ns, kicks_ns[:1] + self.kicks.period_ns)
        return np.append(0, np.cumsum(np.diff(ends, prepend=0) * self._moves))

    def own_time(self, t_ns: Integers) -> tuple[Integers, Array, Array, Array]:
        """Own time at N times: whole ns, what is beyond them, ns, and its first two derivatives, 1 and 1/s."""
        beyond, pace, change = np.zeros((3, len(t_ns)))
        if (self._moves == self.moves_first).all():
            return t_ns * self.moves_first, beyond, pace + self.moves_first, change
        arcs = self.kicks.arcs(t_ns)
        ramp_ns = self.ramp_s * NS
        laps, places = self.kicks.places(arcs)
        moved = self._moved_ns
        moving = self._moves[places]
        whole = laps * (moved[-1] - moved[1]) + moved[places] + moving * (t_ns - self.kicks.begins_ns(arcs))
        while True:  # changes whose T is not over, the latest one first
            x = (t_ns - self.kicks.begins_ns(arcs)) / ramp_ns
            is_recent = (arcs > 0) & (x < 1.0)
            if not is_recent.any():
                return whole, beyond - 0.5 * ramp_ns * (moving - self.moves_first), pace + moving, change
            x = np.where(is_recent, x, 0.0)
            arcs = arcs - is_recent
            sign = moving - self._moves[self.kicks.places(arcs)[1]]
            moving = moving - sign
            square = x * x
            cube = square * x
            beyond += sign * ramp_ns * (cube * x * (2.5 - 3.0 * x + square) - x)
            pace += sign * (cube * (10.0 - 15.0 * x + 6.0 * square))
            change += sign * (30.0 * square * (1.0 - x) ** 2) * (NS / ramp_ns)


def ramp_s(band: Vector) -> float:
    """Time, s, within which a sway of some frequencies, Hz, slows to a stop: 1/(π √(low high))."""
    low, high = band
    return 1.0 / (math.pi * math.sqrt(low * high))
