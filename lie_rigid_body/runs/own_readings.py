"""Readings of anybody's sensors as the arrays of a run, their truth where one is given, and declared sensors."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.arguments import integer_stamps, numbers
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.recording.logs import Log, Vectors, require_overlap
from lie_rigid_body.recording.poses import stamped_poses
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather

GivenTruth: TypeAlias = "SampledTruth | tuple[ArrayLike, ArrayLike] | str | Path | None"
"""A truth, its stamps and attitudes, a file of poses, or a topic of the log."""


def log_of_arrays(t_ns: ArrayLike, gyro: ArrayLike, specific_force: ArrayLike, magnetic_field: Any) -> Log:
    """The log of arrays; see `Run.from_arrays`.

    Raises
    ------
    InputError
        If shapes or types are not those, or a reading is not finite.
    """
    own_clock = isinstance(magnetic_field, tuple) and len(magnetic_field) == 2
    field_ns, field = magnetic_field if own_clock else (t_ns, magnetic_field)
    return Log(
        "arrays",
        _vectors("gyro", t_ns, gyro),
        _vectors("specific_force", t_ns, specific_force),
        None if field is None else _vectors("magnetic_field", field_ns, field),
    )


def _vectors(name: str, t_ns: ArrayLike, values: ArrayLike) -> Vectors:
    stamps = integer_stamps(f"t_ns of {name}", t_ns)
    if stamps.ndim != 1 or not len(stamps):
        raise InputError(f"{name}: stamps of shape {stamps.shape}: give a flat list of at least one")
    return Vectors(stamps, numbers(name, values, len(stamps), 3, whole=True))


def sensors_of(log: Log) -> dict[str, SensorArrays]:
    """The arrays of a log; where the accelerometer has stamps of its own, it is linear at those of the gyro."""
    other = log.accelerometer
    force = None if other is None else other.values
    if other is not None and not np.array_equal(other.t_ns, log.gyro.t_ns):
        force = other.at(log.gyro.t_ns)
    unknown = {"gyro_bias": None, "accelerometer_bias": None, "orientation_xyzw": None}
    found = {"imu": _arrays(log.gyro, {"gyro": log.gyro.values, "specific_force": force, **unknown})}
    if log.magnetometer is not None:
        found["magnetometer"] = _arrays(log.magnetometer, {"field": log.magnetometer.values})
    return found


def _arrays(vectors: Vectors, arrays: Mapping[str, Array | None]) -> SensorArrays:
    arrival_ns = vectors.t_ns if vectors.arrival_ns is None else vectors.arrival_ns
    return SensorArrays(vectors.t_ns, arrival_ns, arrays)


def truth_of(log: Log, given: GivenTruth) -> SampledTruth | None:
    """The truth as it is given; attitudes of NaN, where cameras lost the body, are gaps of it."""
    if given is None:
        return None
    if isinstance(given, str | Path):
        is_file = Path(given).exists()
        if not is_file and log.gyro.arrival_ns is None:
            raise InputError(f"truth {given} is no file, and {log.name} no bag with topics: give its path")
        times, poses = stamped_poses(given if is_file else log.name, None if is_file else f"{given}")
        given = times, poses[:, 3:]
    known = given
    if isinstance(given, tuple) and len(given) == 2:
        stamps, attitude = map(np.asarray, given)
        if attitude.shape == (*stamps.shape, 4) and attitude.dtype.kind == "f":
            seen = ~np.isnan(attitude).all(axis=-1)
            stamps = stamps[seen]
            attitude = attitude[seen]
        known = SampledTruth(stamps, attitude)
    if not isinstance(known, SampledTruth):
        raise InputError("truth: give (t_ns, attitude_xyzw), a SampledTruth, a file, or a topic of the log")
    require_overlap(log.name, {"truth": known.stamps_ns, "log": log.gyro.t_ns}, "bring them to one clock")
    return known


def declared_sensors(file: str | Path | Mapping[str, object], sensors: Mapping[str, SensorArrays]) -> Scenario:
    """The scenario of declared sensors at the rates of their readings.

    Raises
    ------
    InputError
        If a parameter is invalid, or no stamps rise.
    """
    given = dict(file) if isinstance(file, Mapping) else gather(None, [file], [])
    for name, arrays in sensors.items():
        steps = np.diff(arrays.t_ns)
        if not (steps > 0).any():
            raise InputError(f"the stamps of the {name} do not rise, and tell no rate: correct them")
        given[f"{name}_rate"] = float(NS / np.median(steps[steps > 0]))
    return Scenario.from_parameters(given)
