"""Inspection of a log from its beginning to its end, and the run with its mistakes undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.attitudes import period_ns
from lie_rigid_body.foundation.arrays import Integers, linear
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.showing import Shown, report
from lie_rigid_body.inspection.against_truth import report_truth
from lie_rigid_body.inspection.comparison import compare
from lie_rigid_body.inspection.findings import Change, Estimated, Findings, LogMistake, LogNote, Mark, Undecided
from lie_rigid_body.inspection.noise import tell_noise
from lie_rigid_body.inspection.rule import MAX_DELAY_S
from lie_rigid_body.inspection.sentences import tell_constants, tell_mistakes, tell_unit_of_field
from lie_rigid_body.inspection.stamps import (
    Stream,
    checked_stamps,
    fresh,
    is_noisy,
    tell_broken_axes,
    tell_range_and_resolution,
)
from lie_rigid_body.runs import Run, SensorArrays
from lie_rigid_body.runs.run import require_run

READINGS: Final = {
    "gyro": ("imu", "gyro"),
    "accelerometer": ("imu", "specific_force"),
    "magnetometer": ("magnetometer", "field"),
}
"""Sensors of a run and arrays of theirs that are the readings of each sensor of a log."""


@short_dataclass(eq=False)
class Inspection(Shown):
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
    marks : tuple of Mark
        Stretches of time: the rest, the one that was compared, and what is broken.
    stamps : mapping of str to ndarray of int64
        Stamps of the IMU and the magnetometer, repaired where they were broken, ns.
    """

    mistakes: tuple[LogMistake, ...]
    undecided: tuple[Undecided, ...]
    notes: tuple[LogNote, ...]
    sensors: Mapping[str, Estimated]
    run: Run
    marks: tuple[Mark, ...]
    stamps: Mapping[str, Integers]
    _changes: Mapping[str, Change]
    _truth: SampledTruth | None = None

    def __str__(self) -> str:
        """Lines that ``inspect`` prints."""
        return str(report("inspections").as_text(self))

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
            if key in self.stamps and getattr(sensors[key], name) is not None:
                change = self._changes[sensor]
                t_ns = self.stamps[key]
                late_ns = round(change.delay_s * NS)
                readings = change.applied(getattr(sensors[key], name))
                if key == sensor:
                    t_ns = t_ns - late_ns
                elif late_ns:  # the stamps of an IMU are common
                    readings = linear(t_ns + late_ns, t_ns, readings)
                sensors[key] = SensorArrays(t_ns, sensors[key].arrival_ns, {**sensors[key].arrays, name: readings})
        run = replace(self.run, sensors=sensors)
        return run if self._truth is None else run.with_truth(self._truth)


def inspect(run: Run | str | Path) -> Inspection:
    """Find what is wrong with the readings of a run or a log, by their stamps and by each other.

    Parameters
    ----------
    run : Run, str or Path
        A run: simulated, from a bag, or of anybody's sensors. Or the file of a log, as of `Run.from_log`. A truth that
        was given beside a log is compared with the gyro.

    Returns
    -------
    Inspection
        Parameters of the sensors are those of the repaired readings.

    Raises
    ------
    InputError, BagError
        If it is neither, cannot be read, or has no IMU.
    """
    if isinstance(run, str | Path):
        run = Run.from_log(run)
    require_run(run)
    found = Findings()
    stamps = _stamps(run, found)
    every = streams_of(run, stamps)
    streams = {sensor: fresh(stream, found) for sensor, stream in every.items()}
    noisy = any(is_noisy(stream.readings) for stream in streams.values())
    for sensor, stream in reversed(streams.items()):  # an IMU has the rate of its gyro
        if stream.step_s:
            found.estimate(f"{READINGS[sensor][0]}_rate", float(f"{1.0 / stream.step_s:.7g}"))
            tell_broken_axes(stream, noisy=noisy, found=found)
    streams = {
        sensor: stream for sensor, stream in streams.items() if stream.readings.any() and not found.has("stuck", sensor)
    }
    comparison = None
    if "gyro" in streams and len(streams) > 1:
        comparison = compare(*streams.values(), found=found)
    elif run.given_truth is None:
        found.ask_all("the gyro and another sensor that moves are needed", "gyro")
    if comparison is not None:
        tell_mistakes(comparison, found)
    if "magnetometer" in streams:
        tell_unit_of_field(streams["magnetometer"].readings, comparison, found)
    truth = None
    if run.given_truth is not None and "gyro" in streams:
        truth = report_truth(found, streams["gyro"].changed(found.changes["gyro"]), run.given_truth)
    repaired = {sensor: stream.changed(found.changes[sensor]) for sensor, stream in every.items()}
    if "gyro" in repaired and "accelerometer" in repaired:
        tell_noise(repaired, run, found)
    for stream in repaired.values():
        tell_range_and_resolution(stream, found)
    if comparison is not None:
        tell_constants(comparison, found)
    return Inspection(
        tuple(found.mistakes),
        tuple(found.undecided.values()),
        tuple(found.notes),
        found.sensors,
        run,
        tuple(found.marks),
        stamps,
        found.changes,
        truth,
    )


def streams_of(run: Run, stamps: Mapping[str, Integers]) -> dict[str, Stream]:
    """Readings of the sensors of a run that have stamps, ns."""
    return {
        sensor: Stream(sensor, stamps[key], readings)[np.isfinite(readings).all(axis=1)]
        for sensor, (key, name) in READINGS.items()
        if key in stamps and (readings := getattr(run.sensors[key], name)) is not None
    }


def _stamps(run: Run, found: Findings) -> dict[str, Integers]:
    """Stamps of the IMU and the magnetometer that rise, of one clock; what is wrong with them is told."""
    keys = "imu", "magnetometer"
    given = {key: each.t_ns for key, each in run.sensors.items() if key in keys and len(each.t_ns) > 1}
    if not given:
        return {}
    widest = max(given.values(), key=np.ptp)
    if len(given) == 2 and np.array_equal(given["imu"], given["magnetometer"]):
        stamps = dict.fromkeys(given, checked_stamps("log", widest, widest, found))
    else:
        stamps = {key: checked_stamps(key, t_ns, widest, found) for key, t_ns in given.items()}
    if not np.ptp(widest):
        return {}  # no stamps tell any time
    if len(stamps) == 2:
        _tell_other_clock(stamps, found)
    return stamps


def _tell_other_clock(stamps: dict[str, Integers], found: Findings) -> None:
    """Name stamps of the magnetometer that begin and end as much later than the IMU's, and move them to its first."""
    imu = stamps["imu"]
    other = stamps["magnetometer"]
    ahead = other[[0, -1]] - imu[[0, -1]]
    ahead_s = ahead[0] / NS
    is_moved = np.ptp(ahead) <= period_ns(other) and abs(ahead_s) > MAX_DELAY_S
    if other[0] > imu[-1] or imu[0] > other[-1] or is_moved:
        found.name(
            "stamps",
            "magnetometer",
            f"the magnetometer's stamps are of another clock, {ahead_s:.6g} s ahead",
            f"{-ahead_s:+.6g} s",
        )
        stamps["magnetometer"] = other - other[0] + imu[0]
