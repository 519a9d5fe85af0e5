"""Readings of anybody's sensors as the arrays of a run, their truth where one is given, and declared sensors."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.arguments import integer_stamps, numbers
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import numerals
from lie_rigid_body.recording.logs import Log, Vectors, require_overlap
from lie_rigid_body.recording.poses import stamped_poses
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather

MAX_READING: Final = 1e12
"""Largest reading, in SI units: squares of larger ones are lost in round-off, or overflow."""
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
    stamps = integer_stamps(f"t_ns of {name}", t_ns).ravel()
    return Vectors(stamps, numbers(name, values, len(stamps), 3, whole=True))


def sensors_of(log: Log) -> dict[str, SensorArrays]:
    """The arrays of a log; where the accelerometer has stamps of its own, it is linear at those of the gyro.

    Raises
    ------
    InputError
        If a reading is not finite, or too large.
    """
    for sensor, vectors in log.sensors.items():
        rows, _ = np.nonzero(~(np.abs(vectors.values) <= MAX_READING))
        if len(rows):
            told = f"{log.name}: reading {rows[0] + 1} of the {sensor} is ({numerals(vectors.values[rows[0]])})"
            raise InputError(f"{told}, and no sensor reads more than {MAX_READING:g}: remove it")
    force = None if log.accelerometer is None else log.accelerometer.at(log.gyro.t_ns)
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
        is_topic = log.gyro.arrival_ns is not None and not Path(given).exists()
        times, poses = stamped_poses(log.name, f"{given}") if is_topic else stamped_poses(given)
        given = times, poses[:, 3:]
    if isinstance(given, tuple) and len(given) == 2:
        stamps, attitude = map(np.asarray, given)
        if attitude.shape == (*stamps.shape, 4) and attitude.dtype.kind == "f":
            seen = ~np.isnan(attitude).all(axis=-1)
            stamps = stamps[seen]
            attitude = attitude[seen]
        given = SampledTruth(stamps, attitude)
    if not isinstance(given, SampledTruth):
        raise InputError("truth: give (t_ns, attitude_xyzw), a SampledTruth, a file, or a topic of the log")
    require_overlap(log.name, {"truth": given.stamps_ns, "log": log.gyro.t_ns}, "bring them to one clock")
    return given


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
        rising = steps[steps > 0]
        if not len(rising):
            raise InputError(f"the stamps of the {name} do not rise, and tell no rate: correct them")
        given[f"{name}_rate"] = float(NS / np.median(rising))
    return Scenario.from_parameters(given)
