"""How the time between samples is divided into steps."""

from __future__ import annotations

from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError

Integers = NDArray[np.int64]

_SLACK: Final = 1e-9
_SHRUNK: Final = 1.0 - 1e-15
"""What round-off may make of an interval that the largest step divides, in steps and relative."""

_MOST_STEPS: Final = 1e15
"""In one call: a year's work."""

_FASTEST: Final = 1e280


class TimeSteps:
    """Equal steps from one time to the next, none longer than allowed.

    Parameters
    ----------
    max_step : float
        s
    """

    def __init__(self, max_step: float) -> None:
        self._steps_per_ns = min(1e-9 / max_step, _FASTEST)
        self._time_ns = 0

    @property
    def reached_ns(self) -> int:
        """The time already reached, ns."""
        return self._time_ns

    def to(self, times_ns: Integers) -> tuple[Integers, Integers]:
        """The steps that lead to each time from the one before.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Nanoseconds since the start.

        Returns
        -------
        spans, counts : ndarray of int64, shape (N,)
            Time since the one before, ns, and how many steps divide it.

        Raises
        ------
        InputError
            If a time lies before one already reached, or impossibly many steps ahead; none is reached then.
        """
        before = np.empty_like(times_ns)
        before[:1], before[1:] = self._time_ns, times_ns[:-1]
        spans = times_ns - before
        if len(spans) == 0:
            return spans, spans
        if spans.min() < 0:
            _refuse(times_ns, before)
        counts = np.ceil(_SHRUNK * (spans * self._steps_per_ns) - _SLACK)
        if counts.sum() > _MOST_STEPS:
            raise InputError(
                f"{int(times_ns[-1])} ns lie too many steps of {1e-9 / self._steps_per_ns:.3g} s ahead: ask for an "
                "earlier time, take longer steps if it is max_step that limits them, or use ClosedForm"
            )
        self._time_ns = int(times_ns[-1])
        return spans, np.maximum(counts, spans > 0).astype(np.int64)


def _refuse(times_ns: Integers, before: Integers) -> NoReturn:
    i = np.flatnonzero(times_ns < before)[0]
    raise InputError(
        f"t_ns {int(times_ns[i])} lies before {int(before[i])}, which is already reached: give times that do "
        "not decrease, or start a new motion"
    )
