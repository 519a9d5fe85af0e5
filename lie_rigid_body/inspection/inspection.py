"""Inspection of a log from its beginning to its end, and the run with its mistakes undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.inspection.comparison import SensorComparison, compare
from lie_rigid_body.inspection.findings import Estimated, Findings, LogMistake, LogNote, Undecided
from lie_rigid_body.inspection.noise import tell_noise
from lie_rigid_body.inspection.sentences import Change, Changes, tell, tell_field_unit
from lie_rigid_body.inspection.stamps import Stream, checked_stamps, fresh, tell_values
from lie_rigid_body.runs import Run, SensorArrays
from lie_rigid_body.runs.run import require_run

READINGS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Arrays of the readings of each sensor."""


@short_dataclass(eq=False)
class Inspection:
    """Inspection of the readings of a run, without its truth.

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
        for sensor, name in READINGS.items():
            key = _key(sensor)
            if key in self._stamps:
                change = self._changes[sensor]
                t_ns = self._stamps[key]
                readings = (getattr(sensors[key], name) - change.offset) @ change.matrix.T
                if key == sensor:
                    t_ns = t_ns - round(change.delay_s * 1e9)
                elif change.delay_s:  # the stamps of an IMU are common
                    since = t_ns - t_ns[0]
                    later = since + change.delay_s * 1e9
                    readings = np.stack([np.interp(later, since, axis) for axis in readings.T], axis=1)
                sensors[key] = SensorArrays(t_ns, sensors[key].arrival_ns, {**sensors[key].arrays, name: readings})
        return replace(self.run, sensors=sensors)


def _key(sensor: str) -> str:
    """Key among the sensors of a run of the one that has these readings."""
    return sensor if sensor == "magnetometer" else "imu"


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
    """Stamps of the IMU and the magnetometer that rise, of one clock; what is wrong with them is told."""
    keys = [key for key in ("imu", "magnetometer") if key in run.sensors and len(run.sensors[key].t_ns) > 1]
    spans = [(int(run.sensors[key].t_ns.min()), int(run.sensors[key].t_ns.max())) for key in keys]
    widest = max(spans, key=lambda span: span[1] - span[0], default=(0, 0))
    stamps = {key: checked_stamps(key, run.sensors[key].t_ns, widest, found) for key in keys}
    if widest[0] == widest[1]:
        return {}  # no stamps tell any time
    if len(stamps) == 2:
        imu, other = stamps.values()
        if other[0] > imu[-1] or imu[0] > other[-1]:
            ahead_s = (other[0] - imu[0]) / 1e9
            text = f"the magnetometer's stamps are of another clock, {ahead_s:.6g} s ahead"
            found.name("stamps", "magnetometer", text, f"{-ahead_s:+.6g} s")
            stamps["magnetometer"] = other - other[0] + imu[0]
    return stamps


def _field(stream: Stream, comparison: SensorComparison | None) -> float:
    """Median size of the readings of a magnetometer, less their offset where it is told."""
    told = [each for each in comparison.vectors if each.sensor == stream.sensor and each.is_told] if comparison else []
    offset = told[0].constants.offset if told else np.zeros(3)
    return float(np.median(np.linalg.norm(stream.readings - offset, axis=1)))
