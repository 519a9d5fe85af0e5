"""The filters of ahrs that take gyro, accelerometer and magnetometer one after the other, and its gyro integral."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ahrs
import numpy as np
from ahrs import filters as kinds
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import Readings, attitudes, magnetic_enu, magnetic_ned, magnetic_nwu

To_world = Callable[[Readings, Rotation], Rotation]
MICROTESLA = 1e6


def dip(given: Readings) -> float:
    """Angle of the field below the horizon, degrees: a map tells it."""
    return float(np.degrees(np.arctan2(-given.field[2], np.hypot(*given.field[:2]))))


def ned(vector: np.ndarray) -> np.ndarray:
    """East, north, up as north, east, down, and back."""
    return np.array([vector[1], vector[0], -vector[2]])


def true_ned(given: Readings, rotation: Rotation) -> Rotation:
    """To the world, from earth axes true north, east, down."""
    return Rotation.from_matrix([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]) * rotation


def _of(kind: Any, to_world: To_world, *, sign: float = 1.0, inverse: bool = False, **options: Any) -> Any:
    """The estimate of a class, given all arrays; an option that is a function is one of the readings."""

    def estimate(given: Readings, **settings: float) -> Rotation:
        fixed = {name: value(given) if callable(value) else value for name, value in options.items()}
        arrays = {"gyr": given.gyro, "acc": sign * given.acc, "mag": given.mag * MICROTESLA}
        found = attitudes(kind(**arrays, frequency=given.rate, **fixed, **settings).Q)
        return to_world(given, found.inv() if inverse else found)

    return estimate


def angular_rate(given: Readings, **settings: float) -> Rotation:
    """The gyro alone, begun by TRIAD."""
    return attitudes(
        kinds.AngularRate(given.gyro, np.roll(given.first_attitude.as_quat(), 1), frequency=given.rate, **settings).Q
    )


def complementary(given: Readings, **settings: float) -> Rotation:
    """Its angles are roll, pitch and yaw."""
    angles = kinds.Complementary(given.gyro, given.acc, given.mag * MICROTESLA, frequency=given.rate, **settings).W
    return magnetic_nwu(given, attitudes([ahrs.Quaternion(rpy=each) for each in angles]))


def ukf(given: Readings, **settings: float) -> Rotation:
    """Its magnetic reference is that of Munich, in north, east, down."""
    found = kinds.UKF(given.gyro, -given.acc, given.mag * MICROTESLA, frequency=given.rate, **settings).Q
    return true_ned(given, attitudes(found))


def _filter(name: str, estimate: Callable[..., Rotation], advice: str = "", **grid: tuple[float, ...]) -> Filter:
    return Filter("ahrs", name, estimate, grid, advice=advice)


NEGATED = "the accelerometer with opposite sign"
FILTERS = (
    _filter("AngularRate", angular_rate, "the gyro alone, for comparison: it drifts"),
    _filter(
        "AQUA",
        _of(kinds.AQUA, magnetic_nwu, inverse=True),
        "gives earth to body: take the inverse",
        alpha=(0.003, 0.01, 0.03),
        beta=(0.003, 0.01, 0.03),
    ),
    _filter("Complementary", complementary, "Euler angles, wrong while turning", gain=(0.5, 0.9, 0.99)),
    _filter(
        "EKF",
        _of(kinds.EKF, true_ned, sign=-1.0, magnetic_ref=lambda given: ned(given.field)),
        f"{NEGATED}, frame NED, `magnetic_ref` of a map; no state for the gyro's bias",
        var_gyr=(0.01, 0.3**2),
        var_acc=(0.5**2, 1.0, 4.0),
    ),
    _filter(
        "FKF",
        _of(kinds.FKF, magnetic_ned, sign=-1.0),
        f"{NEGATED}; quaternions are not of unit norm",
        sigma_g=(0.001, 0.01),
        sigma_a=(0.01, 0.1),
        sigma_m=(0.01, 0.1),
    ),
    _filter(
        "Fourati",
        _of(kinds.Fourati, magnetic_ned, sign=-1.0, magnetic_dip=dip),
        f"{NEGATED}, and the `magnetic_dip` of a map",
        gain=(0.01, 0.03, 0.1, 0.3),
    ),
    _filter(
        "Madgwick",
        _of(kinds.Madgwick, magnetic_nwu),
        "`q0` is not heeded with a magnetometer",
        gain=(0.01, 0.02, 0.041, 0.1),
    ),
    _filter("Mahony", _of(kinds.Mahony, magnetic_enu), k_P=(0.1, 0.3, 1.0), k_I=(0.03, 0.3)),
    _filter(
        "ROLEQ",
        _of(kinds.ROLEQ, true_ned, magnetic_ref=lambda given: ned(given.field)),
        "frame NED with the accelerometer as it reads, `magnetic_ref` of a map",
    ),
    _filter("UKF", ukf, f"{NEGATED}; the magnetic reference is that of Munich and cannot be set"),
)
