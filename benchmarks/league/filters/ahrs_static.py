"""What ahrs makes of one accelerometer and one magnetometer reading at a time, without a gyro."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ahrs import filters as kinds
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.filters.ahrs_filters import MICROTESLA, NEGATED, dip, ned, true_ned
from league.readings import UP, Readings, attitudes, magnetic_ned, magnetic_nwu


def _of(
    kind: Any,
    to_world: Callable[[Readings, Rotation], Rotation] = magnetic_ned,
    *,
    sign: float = -1.0,
    inverse: bool = False,
    **options: Any,
) -> Callable[..., Rotation]:
    """The estimate of a class, given all arrays; an option that is a function is one of the readings."""

    def estimate(given: Readings) -> Rotation:
        fixed = {name: value(given) if callable(value) else value for name, value in options.items()}
        made = kind(sign * given.acc, given.mag * MICROTESLA, **fixed)
        q = attitudes(np.real(made.A if kind is kinds.TRIAD else made.Q))
        return to_world(given, q.inv() if inverse else q)

    return estimate


def _world(given: Readings, rotation: Rotation) -> Rotation:
    return rotation


def _field(given: Readings) -> np.ndarray:
    return given.field * MICROTESLA


def _ned_field(given: Readings) -> np.ndarray:
    return ned(given.field)


def _filter(name: str, estimate: Callable[..., Rotation], advice: str = "") -> Filter:
    return Filter("ahrs", name, estimate, advice=advice)


COMPLEX = f"{NEGATED}; the quaternions come as complex numbers"
FILTERS = (
    _filter("Davenport", _of(kinds.Davenport, magnetic_dip=dip), f"{COMPLEX}; `magnetic_dip` of a map"),
    _filter("FAMC", _of(kinds.FAMC), NEGATED),
    _filter(
        "FLAE",
        _of(kinds.FLAE, magnetic_nwu, sign=1.0, method="eig", magnetic_dip=dip),
        '`method="eig"`: the symbolic default is off by degrees; `magnetic_dip` of a map',
    ),
    _filter(
        "FQA",
        _of(kinds.FQA, true_ned, sign=1.0, mag_ref=_ned_field),
        "frame NED, `mag_ref` of a map",
    ),
    _filter(
        "OLEQ",
        _of(kinds.OLEQ, true_ned, sign=1.0, magnetic_ref=_ned_field),
        "starts from a quaternion by chance and ends after 20 steps, before it has converged",
    ),
    _filter("QUEST", _of(kinds.QUEST, magnetic_dip=dip), f"{NEGATED}; `magnetic_dip` of a map"),
    _filter("SAAM", _of(kinds.SAAM, magnetic_nwu, sign=1.0, inverse=True), "gives earth to body: take the inverse"),
    _filter("Tilt", _of(kinds.Tilt, magnetic_nwu, sign=1.0)),
    _filter(
        "TRIAD",
        _of(
            kinds.TRIAD,
            _world,
            sign=1.0,
            inverse=True,
            v1=UP,
            v2=_field,
            representation="quaternion",
        ),
        "gives earth to body: take the inverse; `v2` is the field of a map",
    ),
)
