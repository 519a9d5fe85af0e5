"""Kicks: impulsive torques after each of which a body has a given rate, and the free motions between them.

A kick leaves the attitude as it is and sets the body rate; zero is a rest. The motion between two kicks, an *arc*, is
torque-free, so that it has an energy and a momentum of its own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import NS, decimal_ns
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.motion import Motion, Samples, states_at

KICK_NUMBERS: Final = 4
"""Numbers of a kick: its time, s, and the body rate right after it, rad/s."""
MAX_KICKS: Final = 1000
"""Largest number of kicks in a list."""
_MAX_TIME: Final = 2**62
"""Largest time of a kick or a period, ns."""
_FOREVER: Final = 2**63 - 1
"""Period of kicks that come once, ns."""


@short_dataclass(eq=False)
class Kicks:
    """The times of kicks, and the body rates right after them. Arc 0 comes before the first kick, arc k after the kth.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (K,)
        Times since the start, ns, rising.
    body_rate : ndarray, shape (K, 3)
        rad/s.
    period_ns : int
        Time after which the kicks come again, ns; 0: they come once.
    """

    t_ns: Integers
    body_rate: Array
    period_ns: int = 0

    @classmethod
    def of(cls, numbers: Sequence[float], period: float = 0.0) -> Kicks:
        """The kicks that parameters give.

        Parameters
        ----------
        numbers : sequence of float
            Four for each kick: its time, s, and the body rate right after it, rad/s.
        period : float, optional
            Time after which they come again, s; 0: they come once.

        Raises
        ------
        ParameterError
            If the times do not rise from above 0 to at most 4.6e9 s, or the period is not longer than the last one.
        """
        rows = np.array(numbers, dtype=np.float64).reshape(-1, KICK_NUMBERS)
        times = [decimal_ns(seconds) for seconds in rows[:, 0].tolist()]
        for i, (before, after) in enumerate(pairwise([0, *times])):
            if not before < after <= _MAX_TIME:
                raise ParameterError(
                    "kicks",
                    f"kick {i + 1} is at {rows[i, 0]:.15g} s: give a time above {before / NS:.15g} s, and at most "
                    f"{_MAX_TIME / NS:g} s",
                )
        period_ns = decimal_ns(period)
        if times and period and period_ns <= times[-1]:
            raise ParameterError(
                "kick_period",
                f"{period:.15g} s is not longer than the time of the last kick, {rows[-1, 0]:.15g} s: give a longer "
                "period, or 0 for kicks that come once",
            )
        return cls(np.array(times, dtype=np.int64), rows[:, 1:], period_ns if times else 0)

    def __len__(self) -> int:
        return len(self.t_ns)

    @property
    def per_second(self) -> float:
        """Mean number of kicks in a second, for ever; 0 of those that come once."""
        return len(self) * NS / (self.period_ns or np.inf)

    @property
    def rests(self) -> int:
        """Number of kicks after which the body rests."""
        return int((~self.body_rate.any(axis=1)).sum())

    def arcs(self, t_ns: Integers | int) -> Integers:
        """Numbers of the arcs at some times, ns: a kick's own time belongs to the arc after it."""
        laps, rest = np.divmod(np.maximum(t_ns, 0), self.period_ns or _FOREVER)
        return laps * len(self) + np.searchsorted(self.t_ns, rest, side="right")

    def arc(self, t_ns: int) -> int:
        """Number of the arc at one time, ns."""
        return int(self.arcs(t_ns))

    def begin_ns(self, arc: int) -> int:
        """Time at which an arc begins, ns since the start: that of its kick, or 0."""
        return int(self.begins_ns(arc))

    def begins_ns(self, arcs: Integers | int) -> Integers:
        """Times at which some arcs begin, ns since the start."""
        laps, places = self.places(arcs)
        return np.asarray(laps * self.period_ns + np.append(0, self.t_ns)[places])

    def places(self, arcs: Integers | int) -> tuple[Integers, Integers]:
        """Periods before some arcs, and their places among the start, which comes once, and the kicks of a period."""
        laps, kicks = np.divmod(np.asarray(arcs) - 1, max(1, len(self)))
        return np.maximum(laps, 0), np.where(laps < 0, 0, kicks + 1)

    def rate(self, arc: int | Integers) -> Array:
        """Body rate, rad/s, right after the kick that begins an arc from 1 on; of N arcs shape (N, 3)."""
        return self.body_rate[(arc - 1) % len(self)]

    def until(self, t_ns: int) -> tuple[Integers, Array]:
        """Times, ns, and body rates, rad/s, of all kicks up to a time, ns."""
        count = self.arc(t_ns)
        numbers = np.arange(1, count + 1)
        return self.begins_ns(numbers), self.rate(numbers)

    def parts(self, t_ns: Integers) -> Iterable[tuple[int, Integers]]:
        """The arcs of some times, ns, in the order in which they come: each one's number, and the times' places."""
        arcs = self.arcs(t_ns)
        order = np.argsort(arcs, kind="stable")
        numbers, begins = np.unique(arcs[order], return_index=True)
        return zip(numbers.tolist(), np.split(order, begins[1:]), strict=False)


class KickedMotion(ABC):
    """A body's motion across kicks: arcs of free motion, each of which begins where the one before ended.

    Parameters
    ----------
    kicks : Kicks
    start : State
        State at time 0, of one instant.
    """

    def __init__(self, kicks: Kicks, start: State) -> None:
        self._kicks = kicks
        self._start = start

    def __repr__(self) -> str:
        return call_repr(self, {"kicks": len(self._kicks), "start": self._start})

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times; see `Motion.at`.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start. Before it the body is on the free motion that begins there.

        Returns
        -------
        State

        Raises
        ------
        InputError
            If the times are no integers, or the free motions refuse them.
        """
        return states_at(self._start, t_ns, self._samples)

    @abstractmethod
    def _samples(self, t_ns: Integers) -> Samples:
        """Attitudes and body rates at N times, shapes (N, 4) and (N, 3)."""

    def _by_arcs(self, t_ns: Integers, motion_of: Callable[[int], Motion]) -> Samples:
        """Attitudes and body rates at N times, from the free motions of the arcs, which are asked for in order."""
        attitude = np.empty((len(t_ns), 4))
        rate = np.empty((len(t_ns), 3))
        for arc, places in self._kicks.parts(t_ns):
            states = motion_of(arc).at(t_ns[places] - self._kicks.begin_ns(arc))
            attitude[places] = states.attitude_xyzw
            rate[places] = states.body_rate
        return attitude, rate
