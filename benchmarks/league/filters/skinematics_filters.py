"""Filters of scikit-kinematics: earth axes north (magnetic), west, up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from skinematics import imus

from league.contender import Filter
from league.readings import Readings, attitudes, magnetic_nwu


def _stepwise(kind: Callable[..., Any]) -> Callable[..., Rotation]:
    def estimate(given: Readings, **settings: float) -> Rotation:
        # its default start is a list, which += would make longer; and it adds its correction to the reading in place
        running, out = kind(rate=given.rate, Quaternion=np.array([1.0, 0.0, 0.0, 0.0]), **settings), []
        for gyro, acc, mag in zip(given.gyro.copy(), _unit(given.acc), _unit(given.mag), strict=True):
            running.Update(gyro, acc, mag)
            out.append(np.array(running.Quaternion))
        return magnetic_nwu(given, attitudes(out))

    return estimate


def kalman(given: Readings) -> Rotation:
    """After Yun and Bachman. It tells the turn from the first attitude, which is put back."""
    turn = magnetic_nwu(given, attitudes(imus.kalman(given.rate, given.acc, given.gyro.copy(), given.mag * 1e6)))
    return turn * turn[0].inv() * given.first_attitude


def _unit(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


FILTERS = (
    Filter(
        "scikit-kinematics",
        "Madgwick",
        _stepwise(imus.Madgwick),
        {"Beta": (0.03, 0.1, 0.3)},
        advice="its default `Beta` of 1 rad/s follows the accelerometer's noise: take 0.1",
    ),
    Filter(
        "scikit-kinematics",
        "Mahony",
        _stepwise(imus.Mahony),
        {"Kp": (0.1, 0.3, 1.0), "Ki": (0.0, 0.1)},
        advice="give an array for `Quaternion` (the default list grows), unit vectors, and an integral gain `Ki`",
    ),
    Filter(
        "scikit-kinematics",
        "kalman",
        kalman,
        advice="tells the turn from the first attitude only, and loses a turning body even with perfect sensors. "
        "Its transition matrix sums up over the samples, and the quaternion it measures changes sign",
    ),
)
