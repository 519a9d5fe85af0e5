"""Filters of qmt (SensorStim Neurotechnology): earth axes east, north (magnetic), up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import qmt
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import Readings, attitudes, magnetic_enu


def _of(name: str) -> Callable[..., Rotation]:
    def estimate(given: Readings, **settings: float) -> Rotation:
        arrays = (np.ascontiguousarray(track) for track in (given.gyro, given.acc, given.mag * 1e6))
        return magnetic_enu(given, attitudes(getattr(qmt, name)(*arrays, params={"Ts": given.dt, **settings})))

    return estimate


FILTERS = (
    Filter("qmt", "oriEstMadgwick", _of("oriEstMadgwick"), {"beta": (0.01, 0.03, 0.1, 0.3)}),
    Filter("qmt", "oriEstMahony", _of("oriEstMahony"), {"Kp": (0.1, 0.3, 0.74, 2.0), "Ki": (0.0, 0.0012, 0.05, 0.3)}),
    Filter("qmt", "oriEstIMU", _of("oriEstIMU"), {"tauAcc": (1.0, 3.0, 6.0), "tauMag": (3.0, 10.0, 30.0)}),
)
