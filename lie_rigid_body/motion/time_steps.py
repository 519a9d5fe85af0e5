"""How the time between samples is divided into steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError

Integers = NDArray[np.int64]

_SLACK = 1e-9
"""Of a step: what round-off may make of an interval that the largest step divides."""


class TimeSteps:
    """Equal steps from one time to the next, none longer than allowed.

    Parameters
    ----------
    max_step : float
        s
    """

    def __init__(self, max_step: float) -> None:
        self._max_step = float(max_step)
        self._time_ns = 0

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
            If a time lies before one already reached, or cannot be reached by as many steps as there are integers; the
            times are then not reached.
        """
        before = np.concatenate([[self._time_ns], times_ns[:-1]])
        self._require_forward(times_ns, before)
        spans = times_ns - before
        with np.errstate(over="ignore"):
            counts = np.ceil(1e-9 * spans / self._max_step - _SLACK)
        if counts.sum() > np.iinfo(np.int64).max / 2:
            raise InputError(
                f"steps of {self._max_step:g} s never lead to {int(times_ns[-1])} ns: raise max_step if it is what "
                "limits them, or use ClosedForm"
            )
        if len(times_ns):
            self._time_ns = int(times_ns[-1])
        return spans, np.maximum(counts, spans > 0).astype(np.int64)

    def _require_forward(self, times_ns: Integers, before: Integers) -> None:
        backward = np.flatnonzero(times_ns < before)
        if len(backward):
            i = backward[0]
            raise InputError(
                f"t_ns {int(times_ns[i])} lies before {int(before[i])}, which is already reached: give times that do "
                "not decrease, or start a new motion"
            )
