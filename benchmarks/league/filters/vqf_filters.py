"""VQF of its authors (Laidig and Seel, 2023): earth axes east, north (magnetic), up."""

from __future__ import annotations

from typing import Any

import numpy as np
import vqf
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import Readings, attitudes, magnetic_enu


def online(given: Readings, **settings: float) -> Rotation:
    """All at once, with the same result as reading by reading."""
    return _attitudes(given, vqf.VQF(given.dt, **settings).updateBatch(*_arrays(given)))


def basic(given: Readings, **settings: float) -> Rotation:
    """Without estimation of biases and rejection of disturbances."""
    return _attitudes(given, vqf.BasicVQF(given.dt, **settings).updateBatch(*_arrays(given)))


def offline(given: Readings, **settings: float) -> Rotation:
    """Forward and backward."""
    return _attitudes(given, vqf.offlineVQF(*_arrays(given), given.dt, settings))


def _arrays(given: Readings) -> list[Any]:
    return [np.ascontiguousarray(track) for track in (given.gyro, given.acc, given.mag)]


def _attitudes(given: Readings, out: Any) -> Rotation:
    return magnetic_enu(given, attitudes(out["quat9D"]))


TIMES = {"tauAcc": (1.0, 3.0, 6.0), "tauMag": (3.0, 9.0, 30.0)}
BIASES = {"restBiasEstEnabled": (False, True), "motionBiasEstEnabled": (False, True)}
FILTERS = (
    Filter("vqf", "VQF", online, TIMES | BIASES),
    Filter("vqf", "BasicVQF", basic, TIMES, advice="knows no bias of the gyro"),
    Filter("vqf", "offlineVQF", offline, TIMES, sees_future=True),
)
