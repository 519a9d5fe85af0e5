"""Motion of the mass centre, the other half of Chasles' theorem: at rest, thrown, or carried by a sum of harmonics.

A force through the mass centre makes no torque, so the two halves know nothing of each other (A. Lucas, arXiv
1111.1275, section 2): a translation is a function of time, as a rotation is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple, Protocol

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.array_input import ArraysOnly
from lie_rigid_body.motion.harmonics import Harmonics
from lie_rigid_body.motion.kicks import Kicks

_UP: Final = np.array([0.0, 0.0, 1.0])


class MassCentre(ArraysOnly):
    """Position, velocity and acceleration of the mass centre in the world frame, of one instant or of many.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (..., 3)
        m, m/s and m/s². Read only.
    """

    __slots__ = ("acceleration", "position", "velocity")

    position: Array
    velocity: Array
    acceleration: Array

    def __init__(self, position: Array, velocity: Array, acceleration: Array) -> None:
        self._hold(acceleration, position, velocity)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """The leading axes: () for one instant."""
        return self.position.shape[:-1]

    def body_velocity(self, states: State) -> Array:
        """Velocity along the axes of bodies in some states, m/s, shape (N, 3)."""
        return quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self.velocity)


class Translation(Protocol):
    """Motion of the mass centre."""

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""


@dataclass(frozen=True)
class Parabola:
    """A mass centre that is thrown: x₀ + v₀ t − ½ g t² ẑ. Without gravity it moves evenly, or rests.

    Attributes
    ----------
    position, velocity : tuple of float, length 3
        At the start, m and m/s.
    gravity : float
        m/s².
    """

    position: Vector
    velocity: Vector
    gravity: float

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        seconds = (t_ns / NS)[:, np.newaxis]
        fall = 0.0 - self.gravity * _UP
        position = self.position + (seconds * self.velocity + (0.5 * seconds * seconds) * fall)
        velocity = self.velocity + seconds * fall
        return MassCentre(position, velocity, np.tile(fall, (len(t_ns), 1)))


class SwayTime(NamedTuple):
    """The sway's own time: whole nanoseconds and what is beyond them, ns, and its first two derivatives."""

    whole_ns: Integers
    beyond_ns: Array
    pace: Array
    change: Array


class SwayClock:
    """The own time of a sway, which slows to a stop when a rest begins, and gathers speed when it ends.

    Its pace is 1 while the body moves and 0 while it rests. After a change it goes from one to the other within T, as
    S(x) = x³ (10 − 15 x + 6 x²) does, with x = t/T. Changes within T of each other add up.

    Parameters
    ----------
    kicks : Kicks
    starts_at_rest : bool
        Whether the body's rate is 0 before the first kick.
    ramp_s : float
        T, s.
    """

    def __init__(self, kicks: Kicks, *, starts_at_rest: bool, ramp_s: float) -> None:
        self._kicks = kicks
        self._ramp_ns = ramp_s * NS
        self._moves_first = not starts_at_rest
        self._moves = kicks.body_rate.any(axis=1)
        # time in motion, ns, from the first kick on to each later one, and of a whole period
        ends = np.append(kicks.t_ns[1:], kicks.t_ns[:1] + kicks.period_ns)
        self._moved = np.append(0, np.cumsum((ends - kicks.t_ns) * self._moves))

    def _in_motion(self, arcs: Integers) -> Integers:
        """1 for arcs in motion, 0 for arcs at rest."""
        return np.where(arcs > 0, self._moves[(arcs - 1) % len(self._kicks)], self._moves_first).astype(np.int64)

    def _moved_before(self, arcs: Integers) -> Integers:
        """Time in motion before the begin of each arc, ns."""
        laps, kicks = np.divmod(arcs - 1, len(self._kicks))
        first = self._moves_first * self._kicks.t_ns[0]
        return np.where(arcs > 0, first + laps * self._moved[-1] + self._moved[kicks], 0)

    def at(self, t_ns: Integers) -> SwayTime:
        """The sway's time at N times, ns since the start."""
        nothing = np.zeros(len(t_ns))
        if (self._moves == self._moves_first).all():
            return SwayTime(t_ns * self._moves_first, nothing, nothing + self._moves_first, nothing)
        arcs = self._kicks.arcs(t_ns)
        begins = self._kicks.begins_ns(arcs)
        moving = self._in_motion(arcs)
        whole = self._moved_before(arcs) + moving * (t_ns - begins)
        beyond = nothing.copy()
        pace = nothing.copy()
        change = nothing.copy()
        rows = np.arange(len(t_ns))
        while True:  # changes whose T is not over, the latest one first
            x = (t_ns[rows] - begins) / self._ramp_ns
            is_recent = (arcs > 0) & (x < 1.0)
            settled = rows[~is_recent]
            pace[settled] += moving[~is_recent]
            beyond[settled] -= 0.5 * self._ramp_ns * (moving[~is_recent] - self._moves_first)
            rows, arcs, x = rows[is_recent], arcs[is_recent], x[is_recent]
            if not len(rows):
                return SwayTime(whole, beyond, pace, change)
            before = self._in_motion(arcs - 1)
            sign = moving[is_recent] - before
            square = x * x
            cube = square * x
            beyond[rows] += sign * self._ramp_ns * (cube * x * (2.5 - 3.0 * x + square) - x)
            pace[rows] += sign * (cube * (10.0 - 15.0 * x + 6.0 * square))
            change[rows] += sign * (30.0 * square * (1.0 - x) ** 2) * (NS / self._ramp_ns)
            arcs = arcs - 1
            begins = self._kicks.begins_ns(arcs)
            moving = before


@dataclass(frozen=True)
class Carried:
    """A carried mass centre: x₀ + v₀ t, and a sway, which pauses while the body rests.

    Attributes
    ----------
    position, velocity : tuple of float, length 3
        At the start, m and m/s, without the sway's.
    sway : Harmonics
    clock : SwayClock
    """

    position: Vector
    velocity: Vector
    sway: Harmonics
    clock: SwayClock

    @cached_property
    def _origin(self) -> Array:
        """Position of the sway at its time 0, m, shape (1, 3)."""
        return self.sway.at(np.zeros(1, dtype=np.int64)).value

    def at(self, t_ns: Integers) -> MassCentre:
        """The mass centre at N times, ns since the start."""
        seconds = (t_ns / NS)[:, np.newaxis]
        own = self.clock.at(t_ns)
        sway = self.sway.at(own.whole_ns, own.beyond_ns)
        pace = own.pace[:, np.newaxis]
        change = own.change[:, np.newaxis]
        position = self.position + (seconds * self.velocity + (sway.value - self._origin))
        velocity = self.velocity + sway.rate * pace
        return MassCentre(position, velocity, sway.acceleration * (pace * pace) + sway.rate * change)


def ramp_s(band: Vector) -> float:
    """Time, s, within which a sway of some frequencies, Hz, slows to a stop: 1/(π √(low high))."""
    low, high = band
    return 1.0 / (math.pi * math.sqrt(low * high))
