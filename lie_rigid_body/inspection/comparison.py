"""Comparison of the sensors of a log with each other: which hypothesis explains them, and its constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.constants import Constants, Delay, Placed, constants_of, refine
from lie_rigid_body.inspection.explanations import Judgement, explanations, judged
from lie_rigid_body.inspection.findings import Findings, Mark
from lie_rigid_body.inspection.gravity import weight
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_OFFSET_COST,
    EXCLUDED,
    GYRO_HZ,
    GYROS,
    MAGNETOMETER_OFFSET_COST,
    MAX_CLIPPED,
    MAX_LOG_FACTOR_ERROR,
    MAX_MISFIT,
    MAX_ROTATION_DEG,
    MAX_SPAN_S,
    MAX_SWING,
    MIN_SPAN_S,
    REFINED_LOG_FACTOR,
    RIGHT,
    VECTOR_HZ,
    Gyro,
)
from lie_rigid_body.inspection.search import Misfits, Worlds, search
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.inspection.world import Vector

OFFSET_COSTS = {"accelerometer": ACCELEROMETER_OFFSET_COST, "magnetometer": MAGNETOMETER_OFFSET_COST}


@dataclass(frozen=True, eq=False)
class Compared:
    """One vector in a comparison.

    Attributes
    ----------
    sensor : str
    placed : Placed
        Its turn and its fitted delay.
    delay : Delay
    constants : Constants
    is_told : bool
        Whether the log tells its turn, and so its delay and offset.
    """

    sensor: str
    placed: Placed
    delay: Delay
    constants: Constants
    is_told: bool


@dataclass(frozen=True, eq=False)
class SensorComparison:
    """Vectors of a log under the explanation that the rule chose.

    Attributes
    ----------
    worlds : Worlds
    verdict : Judgement
    gyro : Gyro
        With the fitted factor.
    log_factor_sigma : float
        Standard error of the logarithm of the factor.
    vectors : tuple of Compared
    taken_off : bool
        Whether a constant was taken off the accelerometer's readings.
    """

    worlds: Worlds
    verdict: Judgement
    gyro: Gyro
    log_factor_sigma: float
    vectors: tuple[Compared, ...]
    taken_off: bool

    @property
    def misfits(self) -> dict[str, float]:
        """Largest misfit of a vector before the repairs and after them."""
        return {
            "before": max(plain_misfit(each.placed.misfits) for each in self.vectors),
            "after": max(each.constants.misfit for each in self.vectors),
        }


def plain_misfit(found: Misfits) -> float:
    """Misfit of a vector without a repair."""
    delays, misfits = found.by_delay(RIGHT)
    return float(misfits[np.abs(delays).argmin(), 0])


def liveliest(gyro: Stream) -> tuple[int, int]:
    """First and last stamp, ns, of the stretch that has the most rotation about the axis of least rotation."""
    t_s, rate = gyro.averaged(1.0)
    if t_s[-1] - t_s[0] <= MAX_SPAN_S:
        return int(gyro.t_ns[0]), int(gyro.t_ns[-1])
    sums = np.cumsum(rate[:, :, np.newaxis] * rate[:, np.newaxis], axis=0)
    ends = np.searchsorted(t_s, t_s + MAX_SPAN_S)
    begins = np.flatnonzero(ends < len(t_s))
    least = np.linalg.eigvalsh(sums[ends[begins]] - sums[begins])[:, 0]
    begin_ns = int(t_s[begins[least.argmax()]] * 1e9)
    return begin_ns, begin_ns + int(MAX_SPAN_S * 1e9)


def _is_too_slow(streams: Sequence[Stream], rate: Array, factor: float) -> bool:
    """Whether the body turns too far between readings, at nine in ten."""
    fast = float(np.quantile(np.linalg.norm(rate, axis=1), 0.9)) * factor
    return bool(np.degrees(fast * max(each.step_s for each in streams)) > MAX_ROTATION_DEG)


def compare(gyro: Stream, others: Sequence[Stream], found: Findings) -> SensorComparison | None:
    """Search, choose and refine an explanation of all sensors; what cannot be compared is told.

    Parameters
    ----------
    gyro : Stream
    others : sequence of Stream
        Accelerometer and magnetometer, as far as there are such.
    found : Findings
    """
    begin_ns, end_ns = liveliest(gyro)
    found.marks.append(Mark("", "compared", begin_ns, end_ns))
    streams = [each.between(begin_ns, end_ns) for each in (gyro, *others)]
    origin_s = begin_ns // 10**9
    averaged = [each.averaged(VECTOR_HZ if i else GYRO_HZ) for i, each in enumerate(streams)]
    (t_s, rate), *readings = [(t_s - origin_s, values) for t_s, values in averaged]
    worlds = Worlds(t_s, rate)
    vectors = [
        Misfits(Vector.of_readings(stream.sensor, *values, OFFSET_COSTS[stream.sensor]), worlds)
        for stream, values in zip(streams[1:], readings, strict=True)
    ]
    vectors = [each for each in vectors if _is_long(each, t_s, found)]
    if not vectors:
        return None
    top = np.abs(gyro.readings).max()
    if found.has("clipped", "gyro") and np.mean(np.abs(gyro.readings).max(axis=1) == top) > MAX_CLIPPED:
        _untold(vectors, "the gyro reaches its range too often", found)
        return None
    gyros = _search_all(vectors, worlds)
    clearest = max((each.best()[0] for each in vectors), key=lambda gyro: max(each.contrast(gyro) for each in vectors))
    if _is_too_slow(streams, rate, min(clearest.factor, 1.0)):  # larger ones are found where nothing fits
        _untold(vectors, "the log is too slow for its motion: record it at a higher rate, or", found)
        return None
    vectors, taken_off = _weighed(vectors, worlds, gyros[len(GYROS) :], found)
    vectors = [each for each in vectors if _fits(each, worlds, found)]
    every = explanations(vectors, gyros) if vectors else []
    if not every:
        _untold(vectors, "no one gyro explains all other sensors", found)
        return None
    verdict = judged(every)
    factor = verdict.best.gyro.factor
    fit = [each.by_delay(verdict.best.gyro)[1].min(axis=0) <= EXCLUDED * each.least for each in vectors]
    if all(turns.sum() > 1 for turns in fit):  # about one axis a slow gyro fits where a fast one skips turns
        factor = max(factor, 1.0)
    if _is_too_slow(streams, rate, factor):
        _untold(vectors, "the gyro that fits best turns too far between readings", found)
        return None
    return _refined(vectors, worlds, verdict, taken_off)


def _untold(vectors: Sequence[Misfits], why: str, found: Findings) -> None:
    """List all that a model would tell as undecided."""
    axes = [f"{each.vector.sensor}_axes" for each in vectors]
    for code in ("gyro_axes", "gyro_units", "time_step", "gravity_removed", *axes):
        found.ask(code, why)


def _is_long(each: Misfits, t_s: Array, found: Findings) -> bool:
    """Whether a vector and the gyro have enough time in common; that they have not is told."""
    times = [times for times in (t_s, each.vector.t_s) if len(times) > 1]
    common = min(times[-1] for times in times) - max(times[0] for times in times) if len(times) == 2 else 0.0
    if common < MIN_SPAN_S:
        found.ask(f"{each.vector.sensor}_axes", f"the log has less than {MIN_SPAN_S:g} s of this sensor and the gyro")
    return bool(common >= MIN_SPAN_S)


def _search_all(vectors: Sequence[Misfits], worlds: Worlds) -> tuple[Gyro, ...]:
    """Search with the gyros of the grid, then with the factors that each vector by itself fits best."""
    search(vectors)
    more: list[Gyro] = []
    for each in vectors:
        gyro, delay_s, turn = each.best()
        refined = refine([Placed(each, turn, delay_s)], worlds, gyro)
        moved = abs(np.log(refined.gyro.factor / gyro.factor))
        if moved > REFINED_LOG_FACTOR and refined.log_factor_sigma < MAX_LOG_FACTOR_ERROR:
            more.extend(Gyro(sign, refined.gyro.factor) for sign in (gyro.sign, -gyro.sign))
    if more:
        search(vectors, more)
    return (*GYROS, *more)


def _weighed(
    vectors: Sequence[Misfits], worlds: Worlds, more: Sequence[Gyro], found: Findings
) -> tuple[list[Misfits], bool]:
    """The vectors without an accelerometer that has no gravity; one that lost a constant is searched anew with it."""
    first = vectors[0]
    if first.vector.sensor != "accelerometer":
        return list(vectors), False
    held = weight(first, worlds)
    if held.is_healthy:
        return list(vectors), False
    free = Misfits(replace(first.vector, offset_cost=MAGNETOMETER_OFFSET_COST), worlds)
    search([free])
    if more:
        search([free], more)
    freed = weight(free, worlds)
    if freed.is_better_than(held):
        return [free, *vectors[1:]], True
    if held.is_without_gravity:
        text = (
            f"the accelerometer reads no gravity: its mean in the world is {held.size:.2g} m/s²; a driver took it off, "
            "or the body falls freely"
        )
        or_else = ("accelerometer_units",) if held.swing < MAX_SWING else ()
        found.name("gravity_removed", "accelerometer", text, before=held.misfit, or_else=or_else)
        return list(vectors[1:]), False
    if held.unit is not None:
        found.ask("gravity_removed", f"{held.offset:.0%} of gravity are constant on the accelerometer's axes")
    return list(vectors), False


def _fits(each: Misfits, worlds: Worlds, found: Findings) -> bool:
    """Whether some hypothesis makes a vector constant; that none does is told."""
    misfit = weight(each, worlds).misfit
    if misfit <= MAX_MISFIT:
        return True
    sensor = each.vector.sensor
    for code in (f"{sensor}_axes", *(["gravity_removed"] if sensor == "accelerometer" else [])):
        found.ask(code, f"no repair makes the {sensor} constant in the world, {misfit:.0%} of it remain")
    return False


def _refined(vectors: Sequence[Misfits], worlds: Worlds, verdict: Judgement, taken_off: bool) -> SensorComparison:
    best = verdict.best
    placed = [Placed(each, fit.turn, fit.delay_s) for each, fit in zip(vectors, best.fittings, strict=True)]
    refined = refine(placed, worlds, best.gyro)
    world = worlds.of(refined.gyro)
    compared = []
    for each, delay, told in zip(placed, refined.delays, verdict.turns_told, strict=True):
        moved = each._replace(delay_s=delay.delay_s)
        is_told = told and not verdict.fewer
        compared.append(Compared(each.misfits.vector.sensor, moved, delay, constants_of(moved, world), is_told))
    return SensorComparison(worlds, verdict, refined.gyro, refined.log_factor_sigma, tuple(compared), taken_off)
