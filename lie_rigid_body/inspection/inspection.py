"""Inspection of a log from its beginning to its end, and the run with its mistakes undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.inspection.comparison import compare
from lie_rigid_body.inspection.findings import Change, Estimated, Findings, LogMistake, LogNote, Undecided
from lie_rigid_body.inspection.noise import tell_noise
from lie_rigid_body.inspection.sentences import tell, tell_unit
from lie_rigid_body.inspection.stamps import Stream, checked_stamps, fresh, tell_values
from lie_rigid_body.runs import Run, SensorArrays
from lie_rigid_body.runs.run import require_run

READINGS: Final = {
    "gyro": ("imu", "gyro"),
    "accelerometer": ("imu", "specific_force"),
    "magnetometer": ("magnetometer", "field"),
}
"""Sensors of a run and arrays of theirs that are the readings of each sensor of a log."""


@short_dataclass(frozen=True, eq=False)
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
            **{name: [asdict(each) for each in getattr(self, name)] for name in ("mistakes", "undecided", "notes")},
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
        for sensor, (key, name) in READINGS.items():
            if key in self._stamps and getattr(sensors[key], name) is not None:
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
    stamps = _stamps(run, found)
    for key, t_ns in stamps.items():
        found.estimate(f"{key}_rate", float(f"{1e9 / np.median(np.diff(t_ns)):.7g}"))
    streams = {
        sensor: Stream.of(sensor, stamps[key], readings)
        for sensor, (key, name) in READINGS.items()
        if key in stamps and (readings := getattr(run.sensors[key], name)) is not None
    }
    if "accelerometer" in streams:
        tell_noise([*streams.values()], found)
    streams = {sensor: fresh(stream, found) for sensor, stream in streams.items() if stream.readings.any()}
    for stream in streams.values():
        tell_values(stream, found)
    streams = {sensor: stream for sensor, stream in streams.items() if not found.has("stuck", sensor)}
    if "gyro" in streams and len(streams) > 1:
        gyro, *others = streams.values()
        comparison = compare(gyro, others, found)
        if comparison is not None:
            tell(comparison, found)
    if "magnetometer" in streams:
        iron = found.sensors.get("magnetometer_hard_iron")
        field = streams["magnetometer"].readings - (iron.value if iron else 0.0)
        tell_unit("magnetometer", float(np.median(np.linalg.norm(field, axis=1))), is_sure=True, found=found)
    return Inspection(
        tuple(found.mistakes),
        tuple(found.undecided.values()),
        tuple(found.notes),
        found.sensors,
        run,
        stamps,
        found.changes,
    )


def _stamps(run: Run, found: Findings) -> dict[str, Integers]:
    """Stamps of the IMU and the magnetometer that rise, of one clock; what is wrong with them is told."""
    keys = {key for key, _ in READINGS.values()}
    given = {key: each.t_ns for key, each in run.sensors.items() if key in keys and len(each.t_ns) > 1}
    widest = max(given.values(), key=np.ptp, default=np.zeros(1, dtype=np.int64))
    stamps = {key: checked_stamps(key, t_ns, widest, found) for key, t_ns in given.items()}
    if not np.ptp(widest):
        return {}  # no stamps tell any time
    if len(stamps) == 2:
        imu = stamps["imu"]
        other = stamps["magnetometer"]
        if other[0] > imu[-1] or imu[0] > other[-1]:
            ahead_s = (other[0] - imu[0]) / 1e9
            text = f"the magnetometer's stamps are of another clock, {ahead_s:.6g} s ahead"
            found.name("stamps", "magnetometer", text, f"{-ahead_s:+.6g} s")
            stamps["magnetometer"] = other - other[0] + imu[0]
    return stamps
