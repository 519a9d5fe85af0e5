"""Stamps and readings by themselves, without a model: order, gaps, held readings, resolution, range, stuck axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import longest_rising
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    BURST_STEP,
    CLIPPED_DROP,
    CLIPPED_READINGS,
    GAP_STEP,
    GRID_TOLERANCE,
    HELD_REACH,
    MAX_GRID_STEPS,
    MAX_IN_BURSTS,
    MAX_REPEATED_STAMPS,
    MIN_HELD,
    MIN_HOLD,
    ROUND_OFF,
    STUCK_SHARE,
)

AXES: Final = "xyz"


@dataclass(frozen=True, eq=False)
class Stream:
    """Readings of one sensor with their stamps, as far as they are numbers.

    Attributes
    ----------
    sensor : str
    t_ns : ndarray of int64, shape (N,)
    readings : ndarray, shape (N, 3)
    """

    sensor: str
    t_ns: Integers
    readings: Array

    @classmethod
    def of(cls, sensor: str, t_ns: Integers, readings: Array) -> Stream:
        """Leave out what is not finite."""
        finite = np.isfinite(readings).all(axis=1)
        return cls(sensor, t_ns, readings) if finite.all() else cls(sensor, t_ns[finite], readings[finite])

    def __getitem__(self, rows: slice | Booleans) -> Stream:
        return replace(self, t_ns=self.t_ns[rows], readings=self.readings[rows])

    def between(self, begin_ns: int, end_ns: int) -> Stream:
        """Readings from one time on and up to another one, ns."""
        first, last = np.searchsorted(self.t_ns, [begin_ns, end_ns + 1])
        return self[slice(first, last)]

    def averaged(self, rate_hz: float) -> tuple[Array, Array]:
        """Means over as many readings as leave a rate, Hz: times, s, and readings."""
        seconds = max(float(np.ptp(self.t_ns)) / 1e9, 1e-9)
        size = max(int(len(self.t_ns) / seconds / rate_hz), 1)
        count = len(self.t_ns) // size
        used = count * size
        origin = self.t_ns[0] if len(self.t_ns) else 0
        since = (self.t_ns[:used] - origin).reshape(count, size).mean(axis=1) / 1e9
        return since + origin / 1e9, self.readings[:used].reshape(count, size, 3).mean(axis=1)


def checked_stamps(sensor: str, t_ns: Integers, span_ns: tuple[int, int], found: Findings) -> Integers:
    """Stamps that rise evenly where the given ones do not rise; what is wrong with them is told.

    Parameters
    ----------
    sensor : str
    t_ns : ndarray of int64, shape (N,)
    span_ns : tuple of int
        First and last stamp of the other sensor, over which stamps are spread that are all the same.
    found : Findings
    """
    fault, good = _fault_of_stamps(t_ns)
    if not fault:
        _tell_gaps(sensor, t_ns, found)
        return t_ns
    if good.sum() > 1:
        places = np.flatnonzero(good)
        even = _interpolated(len(t_ns), places, t_ns[places])
    else:
        even = np.linspace(*span_ns, len(t_ns)).astype(np.int64)
    found.name("stamps", sensor, f"the stamps of the {sensor} {fault}", "even stamps")
    return even


def _fault_of_stamps(t_ns: Integers) -> tuple[str, Booleans]:
    """Say in words what is wrong with stamps, empty for nothing, and which of them can be kept."""
    steps = np.diff(t_ns)
    ends = np.zeros(len(t_ns), dtype=np.bool_)
    ends[[0, -1]] = True
    zero = (t_ns == 0) & (np.arange(len(t_ns)) > 0)
    if np.ptp(t_ns) == 0:
        return "are all the same", np.zeros(len(t_ns), dtype=np.bool_)
    if zero.any() and (steps < 0).any():
        rest = np.flatnonzero(t_ns != 0)
        good = np.zeros(len(t_ns), dtype=np.bool_)
        good[rest[longest_rising(t_ns[rest])]] = True
        return f"are 0 {zero.sum()} times", good
    if (steps < 0).any():
        good = np.zeros(len(t_ns), dtype=np.bool_)
        good[longest_rising(t_ns)] = True
        return f"go back {np.sum(steps < 0)} times", good
    if np.mean(steps == 0) > MAX_REPEATED_STAMPS:
        return f"are repeated in {np.mean(steps == 0):.0%} of the readings", ends
    if np.mean(steps < BURST_STEP * steps.mean()) > MAX_IN_BURSTS:
        return "come in bursts", ends
    return "", ends


def _interpolated(count: int, places: Integers, t_ns: Integers) -> Integers:
    """Stamps at every index, ns, from those at some; beyond them at the mean step."""
    step = (t_ns[-1] - t_ns[0]) / (places[-1] - places[0])
    index = np.arange(count)
    inside = np.interp(index, places, t_ns - t_ns[0])
    beyond = (np.minimum(index - places[0], 0) + np.maximum(index - places[-1], 0)) * step
    return np.asarray(t_ns[0] + np.round(inside + beyond).astype(np.int64))


def _tell_gaps(sensor: str, t_ns: Integers, found: Findings) -> None:
    steps = np.diff(t_ns)
    median = float(np.median(steps))
    gaps = steps[steps > GAP_STEP * median]
    if len(gaps):
        lost = round(float(np.sum(gaps / median - 1.0)))
        text = (
            f"{len(gaps)} gaps of up to {gaps.max() / 1e9:.3g} s in the {sensor}, in which {lost} readings are missing"
        )
        found.name("gaps", sensor, text)


def fresh(stream: Stream, found: Findings) -> Stream:
    """Readings without those that are held from the one before, if a slower sensor is on these stamps; that is told."""
    readings = stream.readings
    held = np.all(readings[1:] == readings[:-1], axis=1)
    moved = np.linalg.norm(readings[HELD_REACH:] - readings[:-HELD_REACH], axis=1)
    moving = moved > np.quantile(moved, 0.75) / 2.0 if len(moved) else np.zeros(0, dtype=np.bool_)
    if not moving.any() or held[: len(moved)][moving].mean() <= MIN_HELD:
        return stream
    first = np.concatenate([[True], ~held])
    hold = len(first) / first.sum()
    text = f"a reading of the {stream.sensor} is held over {hold:.3g} stamps on average"
    if hold > MIN_HOLD:
        found.name("repeated", stream.sensor, text, "the first of each")
    else:
        found.note("rates", text, float(hold))
    return stream[first]


def resolution(values: Array) -> float | None:
    """Step of which all values are multiples, apart from an offset; None for continuous ones, or too few."""
    different = np.unique(values)
    if len(different) < 3:
        return None
    span = different[-1] - different[0]
    steps = np.diff(different)
    step = float(steps[steps > span / MAX_GRID_STEPS].min(initial=np.inf))
    if not np.isfinite(step):
        return None
    multiples = steps / step
    if np.abs(multiples - np.round(multiples)).max() > GRID_TOLERANCE or span / step > MAX_GRID_STEPS:
        return None
    return float(span / np.sum(np.round(multiples)))


def clipped_at(values: Array, step: float | None) -> float | None:
    """The largest value, if it is reached and left in at least two stretches as a range is; else None."""
    top = values.max()
    edges = np.diff(np.concatenate([[0], values == top, [0]]).astype(np.int64))
    begins = np.flatnonzero(edges == 1)
    ends = np.flatnonzero(edges == -1)
    is_long = ends - begins >= CLIPPED_READINGS
    if is_long.sum() < 2:
        return None
    beside = np.concatenate([np.maximum(begins[is_long] - 1, 0), np.minimum(ends[is_long], len(values) - 1)])
    drop = float(np.median(top - values[beside]))
    least = max(CLIPPED_DROP * float(np.ptp(values)), CLIPPED_READINGS * (step or 0.0), ROUND_OFF)
    return float(top) if drop > least else None


def tell_values(stream: Stream, found: Findings) -> None:
    """Tell resolution, clipping and stuck axes of a sensor."""
    name = stream.sensor
    span = np.ptp(stream.readings, axis=0)
    steps = [resolution(values) for values in stream.readings.T]
    known = [step for step in steps if step is not None]
    if len(known) == 3 and max(known) < (1.0 + GRID_TOLERANCE) * min(known):
        found.note("resolution", f"the {name} reads multiples of {known[0]:.4g}", float(known[0]))
        found.estimate(f"{name}_resolution", float(known[0]))
    ranges = []
    for axis, (values, step) in enumerate(zip(stream.readings.T, steps, strict=True)):
        if span.max() > 0.0 and span[axis] <= STUCK_SHARE * span.max():
            found.name("stuck", name, f"{AXES[axis]} of the {name} stays at {values[0]:.4g}")
            continue
        reached = [top for sign in (1.0, -1.0) if (top := clipped_at(sign * values, step)) is not None]
        if reached:
            text = f"{AXES[axis]} of the {name} reaches its range of {max(reached):.4g} and stays there"
            found.name("clipped", name, text)
            ranges.extend(reached)
    if ranges:
        found.estimate(f"{name}_range", float(max(ranges)))
