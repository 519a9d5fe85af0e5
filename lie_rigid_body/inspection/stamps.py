"""Stamps and readings by themselves, without a model: order, gaps, held readings, resolution, range, stuck axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from lie_rigid_body.evaluation.attitudes import period_ns
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, runs_of
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.inspection.findings import Change, Findings, Mark
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
    PAUSES,
    RATE_PARTS,
    ROUND_OFF,
    STUCK_SHARE,
)
from lie_rigid_body.lie.vectors import norm


@dataclass(frozen=True)
class Stream:
    """Readings of one sensor with their stamps.

    Attributes
    ----------
    sensor : str
    t_ns : ndarray of int64, shape (N,)
    readings : ndarray, shape (N, 3)
    """

    sensor: str
    t_ns: Integers
    readings: Array

    def changed(self, change: Change) -> Stream:
        """Readings with a change of their values."""
        return replace(self, readings=change.applied(self.readings))

    def __getitem__(self, rows: slice | Booleans) -> Stream:
        return replace(self, t_ns=self.t_ns[rows], readings=self.readings[rows])

    @property
    def step_s(self) -> float:
        """Median time between readings, s; 0 for less than two."""
        return period_ns(self.t_ns) / NS

    def between(self, begin_ns: int, end_ns: int) -> Stream:
        """Readings from one time on and up to another one, ns."""
        return self[slice(*np.searchsorted(self.t_ns, [begin_ns, end_ns + 1]))]

    def averaged(self, rate_hz: float, origin_ns: int) -> tuple[Array, Array]:
        """Means over as many readings as leave a rate, Hz: times since an origin, s, and readings."""
        size = max(int(NS / rate_hz / max(period_ns(self.t_ns), 1)), 1)
        rows = np.arange(len(self.t_ns) // size * size).reshape(-1, size)
        return (self.t_ns - origin_ns)[rows].mean(axis=1) / NS, self.readings[rows].mean(axis=1)


def checked_stamps(sensor: str, t_ns: Integers, widest_ns: Integers, found: Findings) -> Integers:
    """Stamps that rise evenly where the given ones do not rise; what is wrong with them is told.

    Parameters
    ----------
    sensor : str
    t_ns : ndarray of int64, shape (N,)
    widest_ns : ndarray of int64
        Stamps over whose span those are spread that are all the same.
    found : Findings
    """
    fault = _fault_of_stamps(t_ns)
    if not fault:
        _tell_gaps(sensor, t_ns, found)
        return t_ns
    found.name("stamps", sensor, f"the stamps of the {sensor} {fault}", "even stamps")
    rows = np.flatnonzero(t_ns)
    known = t_ns[rows]
    reach = 2 * (1 + len(rows) // RATE_PARTS)  # even, as two clocks may alternate
    step = np.median(known[reach:] - known[:-reach]) / reach if len(rows) > reach else 0.0
    if step <= 0.0:
        return np.linspace(widest_ns.min(), widest_ns.max(), len(t_ns)).astype(np.int64)
    even: Integers = known[0] + np.round((np.arange(len(t_ns)) - rows[0]) * step).astype(np.int64)
    zeros = even[np.transpose(runs_of(0, t_ns == 0))].tolist()
    found.marks += [Mark(sensor, "stamps", *ends) for ends in zeros]
    return even


def _fault_of_stamps(t_ns: Integers) -> str:
    """Say in words what is wrong with stamps; empty for nothing."""
    steps = np.diff(t_ns)
    if np.ptp(t_ns) == 0:
        return "are all the same"
    if (steps < 0).any():
        zeros = len(steps[t_ns[1:] == 0])
        back = f"go back {counted(len(steps[steps < 0]), 'time')}"
        return f"are 0 in {counted(zeros, 'reading')}" if zeros else back
    repeated = np.mean(steps == 0)
    if repeated > MAX_REPEATED_STAMPS:
        return f"are repeated in {repeated:.0%} of the readings"
    usual = steps[steps <= np.quantile(steps, 1.0 - PAUSES)].mean()
    return "come in bursts" if np.mean(steps < BURST_STEP * usual) > MAX_IN_BURSTS else ""


def _tell_gaps(sensor: str, t_ns: Integers, found: Findings) -> None:
    steps = np.diff(t_ns)
    median = np.median(steps)
    before = np.flatnonzero(steps > GAP_STEP * median)
    found.marks += [Mark(sensor, "gap", *t_ns[i : i + 2].tolist()) for i in before]
    if len(before):
        gaps = steps[before]
        found.name(
            "gaps",
            sensor,
            f"{counted(len(gaps), 'gap')} of up to {gaps.max() / NS:.3g} s in the {sensor}: "
            f"{np.sum(gaps / median - 1.0):.0f} readings are missing, or the clock was set",
        )


def fresh(stream: Stream, found: Findings) -> Stream:
    """Readings without those that are held from the one before, if a slower sensor is on these stamps; that is told."""
    readings = stream.readings
    first = np.diff(readings, axis=0, prepend=np.inf).any(axis=1)
    moved = norm(readings[HELD_REACH:] - readings[:-HELD_REACH])
    moving = np.flatnonzero(moved > (np.quantile(moved, 0.75) / 2.0 if len(moved) else 0.0))
    if first[moving + 1].sum() >= (1.0 - MIN_HELD) * len(moving):
        return stream
    hold = len(first) / first.sum()
    text = f"a reading of the {stream.sensor} is held over {hold:.3g} stamps on average"
    if hold > MIN_HOLD:
        found.name("repeated", stream.sensor, text, "the first of each")
    else:
        found.note("rates", text, hold)
    return stream[first]


def resolution(values: Array) -> float:
    """Step of which all values are multiples, apart from an offset; 0 for continuous ones, or too few."""
    steps = np.diff(np.unique(values))
    if len(steps) < 2:
        return 0.0
    multiples = steps / steps[steps > steps.sum() / MAX_GRID_STEPS].min()
    whole = np.round(multiples)
    return 0.0 if np.abs(multiples - whole).max() > GRID_TOLERANCE else steps.sum() / whole.sum()


def is_clipped(values: Array) -> bool:
    """Whether the largest value is reached and left in at least two stretches, as a range is."""
    top = values.max()
    firsts, lasts = runs_of(0, values == top)
    is_long = lasts - firsts + 1 >= CLIPPED_READINGS
    if is_long.sum() < 2:
        return False
    beside = np.append(firsts[is_long] - 1, lasts[is_long] + 1)
    drop = top - np.median(values.take(beside, mode="clip"))
    return bool(drop > max(CLIPPED_DROP * np.ptp(values), CLIPPED_READINGS * resolution(values), ROUND_OFF))


def is_noisy(readings: Array) -> bool:
    """Whether readings have noise: of it, not of a motion, two bends that follow have opposite signs."""
    bends = np.diff(readings, 2, axis=0)
    return bool(np.sum(bends[1:] * bends[:-1]) < 0.0)


def tell_broken_axes(stream: Stream, *, noisy: bool, found: Findings) -> None:
    """Name axes that do not move, if the log has noise, and those that reach a range."""
    name = stream.sensor
    span = np.ptp(stream.readings, axis=0)
    is_stuck = span <= STUCK_SHARE * span.max()
    is_reached = [is_clipped(values) or is_clipped(-values) for values in stream.readings.T]
    stuck, clipped = (", ".join(compress("xyz", which)) for which in (is_stuck, ~is_stuck & is_reached))
    if stuck and noisy:
        found.name("stuck", name, f"the {name} does not move in {stuck}")
    elif stuck:
        found.ask("stuck", f"without noise an axis may not move, as {stuck} of the {name}")
    if clipped:
        text = f"the {name} reaches its range in {clipped}, {np.abs(stream.readings).max():.4g}, and stays there"
        found.name("clipped", name, text)


def tell_range_and_resolution(stream: Stream, found: Findings) -> None:
    """Tell the resolution of a sensor, if its axes have one, and its range, if it was reached."""
    name = stream.sensor
    steps = [resolution(values) for values in stream.readings.T]
    if np.max(steps) < (1.0 + GRID_TOLERANCE) * np.min(steps):
        found.note("resolution", f"the {name} reads multiples of {steps[0]:.4g}", steps[0])
        found.estimate(f"{name}_resolution", steps[0])
    if found.has("clipped", name):
        found.estimate(f"{name}_range", np.abs(stream.readings).max())
