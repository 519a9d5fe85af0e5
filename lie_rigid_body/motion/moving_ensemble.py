"""The integration of many bodies through the same times, each by steps of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.motion import batch_shape, flat_batch
from lie_rigid_body.motion.time_steps import TimeSteps, require_order
from lie_rigid_body.short_dataclass import short_dataclass


@short_dataclass(frozen=True)
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


class Integrator(Protocol):
    """The motion of one body in steps. The caller keeps its state, a list of floats that only the method can read."""

    @property
    def start(self) -> list[float]:
        """The state at time 0."""

    @property
    def largest_step(self) -> float:
        """The length that no step exceeds, s."""

    def require_short_steps(self, state: list[float], ahead_ns: int) -> None:
        """Refuse to go ahead by so many nanoseconds, if the steps from this state would be too long for the method.

        Raises
        ------
        InputError
        """

    def advance(self, state: list[float], spans: Integers, counts: Integers, work: int) -> tuple[Array, Array]:
        """Move a state, in place, through N samples.

        Parameters
        ----------
        state : list of float
        spans, counts : ndarray of int64, shape (N,)
            Time since the sample before, ns, and the number of steps that divide it.
        work : int
            The steps that this call counts as when it is judged whether compiling pays; see `compilation.Loop`.

        Returns
        -------
        attitude_xyzw : ndarray, shape (N, 4)
        body_rate : ndarray, shape (N, 3)

        Raises
        ------
        InputError
            If the steps lead to infinity.
        """


class MovingEnsemble:
    """B motions and the states that they have reached, all at the same time.

    Parameters
    ----------
    starts : InitialConditions
    integrators : sequence of Integrator
        One for each body.
    """

    def __init__(self, starts: InitialConditions, integrators: Sequence[Integrator]) -> None:
        self._starts = starts
        self._integrators = integrators
        self._steps = [TimeSteps(integrator.largest_step) for integrator in integrators]
        self._states = [integrator.start for integrator in integrators]
        self._reached_ns = 0

    @property
    def reached_ns(self) -> int:
        """The time of the states, ns since the start."""
        return self._reached_ns

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        """Write the states at N times that do not decrease.

        Parameters
        ----------
        attitude_xyzw : ndarray, shape (B, N, 4)
        body_rate : ndarray, shape (B, N, 3)
        t_ns : ndarray of int64, shape (N,)
        block : int
            The number of samples of a body to compute at once.

        Raises
        ------
        InputError
            If a time lies before one already reached, or a body cannot follow. Then no body has moved.
        """
        if len(t_ns) == 0:
            return
        require_order(t_ns, self._reached_ns)
        work = sum(self._steps_through(k, t_ns) for k in range(len(self._states)))
        moved = []
        for k, state in enumerate(self._states):
            moved.append(list(state))
            for some, attitudes, rates in self._samples(k, moved[k], t_ns, block, work):
                attitude_xyzw[k, some], body_rate[k, some] = attitudes, rates
                work = 0
        if self._reached_ns == 0:  # at the start exactly the numbers that were given
            begun = np.searchsorted(t_ns, 0, side="right")
            attitude_xyzw[:, :begun] = self._starts.attitude_xyzw[:, np.newaxis]
            body_rate[:, :begun] = self._starts.body_rate[:, np.newaxis]
        self._states, self._reached_ns = moved, int(t_ns[-1])

    def _steps_through(self, k: int, t_ns: Integers) -> int:
        """The number of steps that a body has to take, approximately; refuses what it cannot follow."""
        last_ns = int(t_ns[-1])
        try:
            self._integrators[k].require_short_steps(self._states[k], last_ns - self._reached_ns)
            return max(self._steps[k].through(last_ns, self._reached_ns), len(t_ns))
        except InputError as error:
            raise self._named(k, error) from None

    def _samples(
        self, k: int, state: list[float], t_ns: Integers, block: int, work: int
    ) -> Iterator[tuple[slice, Array, Array]]:
        """Attitudes and rates of one body, block by block; its state moves on in place."""
        reached_ns = self._reached_ns
        for begin in range(0, len(t_ns), block):
            some = slice(begin, begin + block)
            spans, counts = self._steps[k].to(t_ns[some], reached_ns)
            try:
                attitudes, rates = self._integrators[k].advance(state, spans, counts, work)
            except InputError as error:
                raise self._named(k, error) from None
            yield some, attitudes, rates
            reached_ns, work = int(t_ns[some][-1]), 0

    def _named(self, k: int, error: InputError) -> InputError:
        return InputError(f"{self._starts.error_prefix(k)}{error}")
