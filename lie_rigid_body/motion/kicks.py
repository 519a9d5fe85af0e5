"""Kicks: impulsive torques after each of which a body has a given rate, and the free motions between them.

A kick leaves the attitude as it is and sets the body rate; zero is a rest. The motion between two kicks, an *arc*, is
torque-free, so that it has an energy and a momentum of its own.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from operator import attrgetter
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.motion import Motion, states_at
from lie_rigid_body.motion.time_steps import require_order

KICK_NUMBERS: Final = 4
"""Numbers of a kick: its time, s, and the body rate right after it, rad/s."""
MAX_KICKS: Final = 1000
"""Largest number of kicks in a list."""
_KEPT_STARTS: Final = 1000
"""Arcs from one start that is kept to the next: no question costs more than so many arcs."""
_MAX_TIME: Final = 2**62
"""Largest time of a kick or a period, ns."""


def _nanoseconds(seconds: float) -> int:
    """Round a time, s, to ns: that of its shortest decimal."""
    return round(Decimal(repr(seconds)) * NS)


@dataclass(frozen=True, eq=False)
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

    t_ns: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    body_rate: Array = field(default_factory=lambda: np.empty((0, 3)))
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
            If the times do not rise from above 0, or the period is not longer than the last one.
        """
        rows = np.array(numbers, dtype=np.float64).reshape(-1, KICK_NUMBERS)
        times = [_nanoseconds(seconds) for seconds in rows[:, 0].tolist()]
        for i, (before, after) in enumerate(zip([0, *times], times, strict=False)):
            if not before < after <= _MAX_TIME:
                than = f"{before / NS:.15g} s, the time of the kick before" if i else "0, the start"
                raise ParameterError(
                    "kicks", f"kick {i + 1} is at {rows[i, 0]:.15g} s, which is not above {than}: give rising times"
                )
        period_ns = _nanoseconds(period)
        if times and period and period_ns <= times[-1]:
            raise ParameterError(
                "kick_period",
                f"{period:.15g} s is not longer than the time of the last kick, {rows[-1, 0]:.15g} s: give a longer "
                "period, or 0 for kicks that come once",
            )
        return cls(np.array(times, dtype=np.int64), rows[:, 1:].copy(), period_ns if times else 0)

    def __len__(self) -> int:
        return len(self.t_ns)

    def arcs(self, t_ns: Integers) -> Integers:
        """Numbers of the arcs at some times, ns: a kick's own time belongs to the arc after it."""
        if not self.period_ns:
            return np.asarray(np.searchsorted(self.t_ns, t_ns, side="right"))
        laps, rest = np.divmod(np.maximum(t_ns, 0), self.period_ns)
        return np.asarray(laps * len(self) + np.searchsorted(self.t_ns, rest, side="right"))

    def begin_ns(self, arc: int) -> int:
        """Time at which an arc begins, ns since the start: that of its kick, or 0."""
        if not arc:
            return 0
        lap, kick = divmod(arc - 1, len(self))
        return lap * self.period_ns + int(self.t_ns[kick])

    def begins_ns(self, arcs: Integers) -> Integers:
        """Times at which some arcs begin, ns since the start."""
        if not len(self):
            return np.zeros_like(arcs)
        laps, kicks = np.divmod(arcs - 1, len(self))
        return np.where(arcs > 0, laps * self.period_ns + self.t_ns[kicks], 0)

    def rate(self, arc: int) -> Array:
        """Body rate, rad/s, right after the kick that begins an arc from 1 on."""
        return np.asarray(self.body_rate[(arc - 1) % len(self)])

    def until(self, t_ns: int) -> tuple[Integers, Array]:
        """Times, ns, and body rates, rad/s, of all kicks up to a time, ns."""
        count = int(self.arcs(np.array([t_ns]))[0])
        numbers = np.arange(1, count + 1)
        return self.begins_ns(numbers), self.body_rate[(numbers - 1) % max(1, len(self))]

    def parts(self, t_ns: Integers) -> Iterator[tuple[int, Integers]]:
        """The arcs of some times, ns, in the order in which they come: each one's number, and the times' places."""
        arcs = self.arcs(t_ns)
        order = np.argsort(arcs, kind="stable")
        numbers, begins = np.unique(arcs[order], return_index=True)
        ends = [*begins[1:], len(order)]
        for number, begin, end in zip(numbers.tolist(), begins, ends, strict=False):
            yield number, order[begin:end]


class _Arc(NamedTuple):
    """A free motion between two kicks, from its start on."""

    number: int
    start: State
    motion: Motion


class KickedMotion(ABC):
    """A body's motion across kicks: arcs of free motion, each of which begins where the one before ended.

    Parameters
    ----------
    kicks : Kicks
    start : State
        State at time 0, of one instant.
    free : callable
        ``free(start)`` makes the free motion from a state on.

    Notes
    -----
    The last attitude of an arc is rounded to doubles before the next arc begins with it.
    """

    def __init__(self, kicks: Kicks, start: State, free: Callable[[State], Motion]) -> None:
        self._kicks = kicks
        self._start = start
        self._free = free
        self._first = _Arc(0, start, free(start))

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
    def _samples(self, t_ns: Integers) -> tuple[Array, Array]:
        """Attitudes and body rates at N times, shapes (N, 4) and (N, 3)."""

    def _samples_of(self, t_ns: Integers, arc_at: Callable[[int], _Arc]) -> tuple[Array, Array]:
        attitude = np.empty((len(t_ns), 4))
        rate = np.empty((len(t_ns), 3))
        for number, places in self._kicks.parts(t_ns):
            states = arc_at(number).motion.at(t_ns[places] - self._kicks.begin_ns(number))
            attitude[places] = states.attitude_xyzw
            rate[places] = states.body_rate
        return attitude, rate

    def _next(self, arc: _Arc) -> _Arc:
        """The arc after one, whose motion may have reached any time of it."""
        number = arc.number + 1
        end = copy.copy(arc.motion).at(self._kicks.begin_ns(number) - self._kicks.begin_ns(arc.number))
        start = State.trusted(end.attitude_xyzw, self._kicks.rate(number))
        return _Arc(number, start, self._free(start))


class KickedSteps(KickedMotion):
    """A kicked motion that goes through rising times only, as free motions that take steps do; one arc is kept."""

    def __init__(self, kicks: Kicks, start: State, free: Callable[[State], Motion]) -> None:
        super().__init__(kicks, start, free)
        # replaced as a whole, never changed: a copy of the motion goes on by itself, and a signal finds both or none
        self._reached = self._first, 0

    def _samples(self, t_ns: Integers) -> tuple[Array, Array]:
        reached, reached_ns = self._reached
        require_order(t_ns, reached_ns)

        def arc_at(number: int) -> _Arc:
            nonlocal reached
            while reached.number < number:
                reached = self._next(reached)
            reached = reached._replace(motion=copy.copy(reached.motion))
            return reached

        samples = self._samples_of(t_ns, arc_at)
        self._reached = reached, int(t_ns[-1]) if len(t_ns) else reached_ns
        return samples


class KickedClosedForm(KickedMotion):
    """A kicked motion that may be asked for any time: it keeps two arcs, and the start of every thousandth.

    So no question costs more than a thousand arcs, once they were gone through. Copies share those starts.
    """

    def __init__(self, kicks: Kicks, start: State, free: Callable[[State], Motion]) -> None:
        super().__init__(kicks, start, free)
        self._recent = (self._first, self._first)
        self._starts = {0: start}

    def _samples(self, t_ns: Integers) -> tuple[Array, Array]:
        return self._samples_of(t_ns, self._arc_at)

    def _arc_at(self, number: int) -> _Arc:
        recent = [arc for arc in self._recent if arc.number <= number]
        arc = max(recent, key=attrgetter("number"), default=None)
        kept = max(begin for begin in self._starts if begin <= number)
        if arc is None or arc.number < kept:
            arc = _Arc(kept, self._starts[kept], self._free(self._starts[kept]))
        while arc.number < number:
            arc = self._next(arc)
            if arc.number % _KEPT_STARTS == 0:
                self._starts[arc.number] = arc.start
        if all(arc.number != each.number for each in self._recent):
            self._recent = (self._recent[-1], arc)
        return arc
