"""The mean angular velocity over the interval between two samples, which a gyro measures that integrates."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State


class IntegratedRate:
    """The constant rate that takes the attitude of one sample to the attitude of the next.

    ``log(R_(j-1)ᵀ R_j) / (t_j − t_(j-1))``, so that the product of the ``exp(ω_j (t_j − t_(j-1)))`` is the rotation of
    the truth, with no error of integration. The logarithm takes the shorter way round: between two samples the body
    has to turn by less than π.

    Parameters
    ----------
    before_ns : int
        Time of the state one interval before the first sample, ns.
    before : State
        The state at that time, of one instant.
    """

    def __init__(self, before_ns: int, before: State) -> None:
        self._times = np.array([before_ns], dtype=np.int64)
        self._attitudes = before.attitude_xyzw.reshape(1, 4)

    def over(self, stamps_ns: Integers, states: State) -> Array:
        """The rates of the next samples.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        states : State
            Of N instants.

        Returns
        -------
        ndarray, shape (N, 3)
            rad/s.

        Raises
        ------
        InputError
            If a stamp is not later than the one before.
        """
        times = np.concatenate([self._times, stamps_ns])
        attitudes = np.concatenate([self._attitudes, states.attitude_xyzw])
        intervals = np.diff(times)
        _require_rising(times, intervals)
        self._times, self._attitudes = times[-1:], attitudes[-1:]
        turns = quaternion.log(quaternion.multiply(quaternion.conjugate(attitudes[:-1]), attitudes[1:]))
        return np.asarray(turns / (intervals / 1e9)[:, np.newaxis])


def _require_rising(times: Integers, intervals: Integers) -> None:
    if len(intervals) and intervals.min() <= 0:
        worst = int(np.argmin(intervals))
        raise InputError(
            f"stamps_ns: {times[worst + 1]} follows {times[worst]}: an integrated rate needs stamps that rise, "
            "the first one above before_ns"
        )
