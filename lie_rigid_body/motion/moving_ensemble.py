"""The integration of many bodies through the same times, each by steps of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.motion.motion import InitialConditions
from lie_rigid_body.motion.time_steps import require_order, steps_through, steps_to


class Integrator(Protocol):
    """The motion of one body in steps. The caller keeps its state, a list of floats that only the method can read."""

    @property
    def start(self) -> list[float]:
        """The state at time 0."""

    @property
    def largest_step(self) -> float:
        """The length that no step exceeds, s."""

    def require_short_steps(self, state: list[float], span_ns: int) -> None:
        """Refuse to go from sample to sample, up to so many nanoseconds, in steps too long for the method and a state.

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

    Attributes
    ----------
    reached_ns : int
        The time of the states, ns since the start.
    """

    def __init__(self, starts: InitialConditions, integrators: Sequence[Integrator]) -> None:
        self._starts = starts
        self._integrators = integrators
        self._states = [integrator.start for integrator in integrators]
        self.reached_ns = 0

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
        require_order(t_ns, self.reached_ns)
        longest_ns = int((t_ns[1:] - t_ns[:-1]).max(initial=t_ns[0] - self.reached_ns))
        work = sum(self._steps_through(k, t_ns, longest_ns) for k in range(len(self._states)))
        moved = []
        for k, state in enumerate(self._states):
            moved.append(list(state))
            for some, attitudes, rates in self._samples(k, moved[k], t_ns, block, work):
                attitude_xyzw[k, some], body_rate[k, some] = attitudes, rates
                work = 0
        self._states, self.reached_ns = moved, int(t_ns[-1])

    def _steps_through(self, k: int, t_ns: Integers, longest_ns: int) -> int:
        """The number of steps that a body has to take, approximately; refuses what it cannot follow."""
        try:
            integrator = self._integrators[k]
            integrator.require_short_steps(self._states[k], longest_ns)
            return max(steps_through(int(t_ns[-1]), self.reached_ns, integrator.largest_step), len(t_ns))
        except InputError as error:
            raise self._named(k, error) from None

    def _samples(
        self, k: int, state: list[float], t_ns: Integers, block: int, work: int
    ) -> Iterator[tuple[slice, Array, Array]]:
        """Attitudes and rates of one body, block by block; its state moves on in place."""
        reached_ns = self.reached_ns
        for begin in range(0, len(t_ns), block):
            some = slice(begin, begin + block)
            spans, counts = steps_to(t_ns[some], reached_ns, self._integrators[k].largest_step)
            try:
                attitudes, rates = self._integrators[k].advance(state, spans, counts, work)
            except InputError as error:
                raise self._named(k, error) from None
            yield some, attitudes, rates
            reached_ns, work = int(t_ns[some][-1]), 0

    def _named(self, k: int, error: InputError) -> InputError:
        return InputError(f"{self._starts.error_prefix(k)}{error}")
