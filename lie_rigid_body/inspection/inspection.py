"""Inspection of a log from its beginning to its end, and the run with its mistakes undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.inspection.comparison import SensorComparison, compare
from lie_rigid_body.inspection.findings import Estimated, Findings, LogMistake, LogNote, Undecided
from lie_rigid_body.inspection.noise import tell_noise
from lie_rigid_body.inspection.sentences import Change, Changes, tell, tell_field_unit
from lie_rigid_body.inspection.stamps import Stream, checked_stamps, fresh, tell_values
from lie_rigid_body.runs import Run, SensorArrays
from lie_rigid_body.runs.run import require_run

READINGS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Arrays of the readings of each sensor."""


@dataclass(frozen=True, eq=False)
class Inspection:
    """What is wrong with the readings of a run, without its truth.

    Attributes
    ----------
    mistakes : tuple of LogMistake
    undecided : tuple of Undecided
        Codes between which and none the log does not decide.
    notes : tuple of LogNote
    sensors : mapping of str to Estimated
        Parameters of the simulator's sensors with which they are like these.
    run : Run
        The run that was inspected.
    """

    mistakes: tuple[LogMistake, ...]
    undecided: tuple[Undecided, ...]
    notes: tuple[LogNote, ...]
    sensors: Mapping[str, Estimated]
    run: Run
    _stamps: Mapping[str, Integers]
    _changes: Mapping[str, Change]

    @property
    def passed(self) -> bool:
        """Whether no mistake was found."""
        return not self.mistakes

    def to_dict(self) -> dict[str, Any]:
        """Everything that was found as numbers, text and lists."""
        return {
            "mistakes": [asdict(each) for each in self.mistakes],
            "undecided": [asdict(each) for each in self.undecided],
            "notes": [asdict(each) for each in self.notes],
            "sensors": {name: asdict(each) for name, each in self.sensors.items()},
            "passed": self.passed,
        }

    def repaired(self) -> Run:
        """Make the run with its mistakes undone, as far as a repair is told.

        Returns
        -------
        Run
        """
        sensors = dict(self.run.sensors)
        for key, t_ns in self._stamps.items():
            arrays = {**sensors[key].arrays}
            for sensor, name in READINGS.items():
                if name in arrays and key == _key(sensor):
                    arrays[name] = _changed(t_ns, arrays[name], self._changes[sensor])
            delay_ns = round(self._changes[key].delay_s * 1e9) if key == "magnetometer" else 0
            sensors[key] = SensorArrays(t_ns - delay_ns, sensors[key].arrival_ns, arrays)
        return replace(self.run, sensors=sensors)


def _key(sensor: str) -> str:
    """Key among the sensors of a run of the one that has these readings."""
    return sensor if sensor == "magnetometer" else "imu"


def _changed(t_ns: Integers, readings: Array | None, change: Change) -> Array | None:
    """Readings after a change; those of an IMU, whose stamps are common, are moved in time by interpolation."""
    if readings is None:
        return None
    changed = (readings - change.offset) @ change.matrix.T
    if not change.delay_s:
        return np.asarray(changed)
    since = (t_ns - t_ns[0]) / 1e9
    return np.stack([np.interp(since + change.delay_s, since, axis) for axis in changed.T], axis=1)


def inspect(run: Run) -> Inspection:
    """Find what is wrong with the readings of a run, by their stamps and by each other.

    Parameters
    ----------
    run : Run
        Simulated, from a bag, or of anybody's sensors. Its truth is not used.

    Returns
    -------
    Inspection

    Raises
    ------
    InputError
        If it is no run, or has no IMU.
    """
    require_run(run)
    found = Findings()
    changes: Changes = {sensor: Change.none() for sensor in READINGS}
    stamps = _stamps(run, found)
    streams = {
        sensor: Stream.of(sensor, stamps[_key(sensor)], getattr(run.sensors[_key(sensor)], name))
        for sensor, name in READINGS.items()
        if _key(sensor) in stamps
    }
    for key, t_ns in stamps.items():
        found.estimate(f"{key}_rate", float(f"{1e9 / np.median(np.diff(t_ns)):.7g}"))
    if "imu" in stamps:
        tell_noise(list(streams.values()), found)
    streams = {sensor: fresh(stream, found) for sensor, stream in streams.items() if stream.readings.any()}
    for stream in streams.values():
        tell_values(stream, found)
    streams = {sensor: stream for sensor, stream in streams.items() if not found.has("stuck", sensor)}
    comparison = None
    if "gyro" in streams and len(streams) > 1:
        gyro, *others = streams.values()
        comparison = compare(gyro, others, found)
    if comparison is not None:
        tell(comparison, found, changes)
    if "magnetometer" in streams:
        tell_field_unit(_field(streams["magnetometer"], comparison), found, changes)
    return Inspection(
        tuple(found.mistakes),
        tuple(found.undecided.values()),
        tuple(found.notes),
        found.sensors,
        run,
        stamps,
        changes,
    )


def _stamps(run: Run, found: Findings) -> dict[str, Integers]:
    """Stamps of the IMU and the magnetometer that rise; what is wrong with them is told."""
    given = {key: arrays.t_ns for key, arrays in run.sensors.items() if key in ("imu", "magnetometer")}
    given = {key: t_ns for key, t_ns in given.items() if len(t_ns) > 1}
    spans = {key: (int(t_ns.min()), int(t_ns.max())) for key, t_ns in given.items()}
    widest = max(spans.values(), key=lambda span: span[1] - span[0], default=(0, 0))
    return {key: checked_stamps(key, t_ns, widest, found) for key, t_ns in given.items()}


def _field(stream: Stream, comparison: SensorComparison | None) -> float:
    """Median size of the readings of a magnetometer, less their offset where it is told."""
    told = [each for each in comparison.vectors if each.sensor == stream.sensor and each.is_told] if comparison else []
    offset = told[0].constants.offset if told else np.zeros(3)
    return float(np.median(np.linalg.norm(stream.readings - offset, axis=1)))
