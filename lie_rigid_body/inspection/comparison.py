"""Comparison of the sensors of a log with each other: which hypothesis explains them, and its constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.inspection.constants import Constants, constants_of, refine
from lie_rigid_body.inspection.explanations import Judgement, explanations, judged
from lie_rigid_body.inspection.findings import Findings, Mark
from lie_rigid_body.inspection.minimum import Minimum
from lie_rigid_body.inspection.rule import (
    GRAVITY,
    GYRO_HZ,
    GYROS,
    MAX_CLIPPED,
    MAX_LOG_FACTOR_ERROR,
    MAX_MISFIT,
    MAX_NO_GRAVITY,
    MAX_ROTATION_DEG,
    MAX_SPAN_NS,
    MAX_SWING,
    MIN_GAIN,
    MIN_TAKEN_OFF,
    OFFSET_COSTS,
    REFINED_LOG_FACTOR,
    VECTOR_HZ,
)
from lie_rigid_body.inspection.search import Fitting, Misfits, scan, search
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.inspection.world import integrated
from lie_rigid_body.lie.vectors import norm

KEPT_WORLDS: Final = 6
"""Number of worlds that are kept: each takes 150 bytes a reading of the gyro."""


class Compared(NamedTuple):
    """One vector in a comparison.

    Attributes
    ----------
    placed : Fitting
        Its turn, the gyro with the fitted factor, and the fitted delay.
    delay : Minimum
    constants : Constants
        On the sensor's own axes, in its own unit.
    is_told : bool
        Whether the log tells its turn, and so its delay and offset.
    """

    placed: Fitting
    delay: Minimum
    constants: Constants
    is_told: bool


class SensorComparison(NamedTuple):
    """Vectors of a log under the explanation that the rule chose.

    Attributes
    ----------
    verdict : Judgement
    factor : Minimum
        Logarithm of its factor.
    vectors : mapping of str to Compared
        By their sensors.
    misfits : mapping of str to float
        Largest misfit of a vector ``before`` the repairs and ``after`` them.
    """

    verdict: Judgement
    factor: Minimum
    vectors: Mapping[str, Compared]
    misfits: Mapping[str, float]


def liveliest(gyro: Stream) -> Stream:
    """The stretch of a gyro's readings that has the most rotation about the axis of least rotation."""
    quarter_ns = MAX_SPAN_NS // 4
    begins = gyro.t_ns[0] + np.unique((gyro.t_ns - gyro.t_ns[0]) // quarter_ns) * quarter_ns  # a gap may be of years
    stretches = [gyro.between(begin, begin + MAX_SPAN_NS) for begin in begins.tolist()]
    return max(stretches, key=lambda each: np.linalg.eigvalsh(each.readings.T @ each.readings)[0])


def compare(gyro: Stream, *others: Stream, found: Findings) -> SensorComparison | None:
    """Search, choose and refine an explanation of all sensors; what cannot be compared is told.

    Parameters
    ----------
    gyro : Stream
    *others : Stream
        Accelerometer and magnetometer, as far as there are such.
    found : Findings
    """
    gyro = liveliest(gyro)
    found.marks.append(Mark("log", "compared", *gyro.t_ns[[0, -1]].tolist()))
    vectors = list(_vectors(gyro, others, found))
    if not vectors:
        return None
    turned = np.quantile(norm(gyro.readings), 0.9) * max(each.step_s for each in (gyro, *others))
    largest = np.abs(gyro.readings).max(axis=1)
    if found.has("clipped", "gyro") and np.mean(largest == largest.max()) > MAX_CLIPPED:
        verdict: Judgement | str = "the gyro reaches its range too often"
    else:
        verdict = _verdict(vectors, np.degrees(turned), found)
    if isinstance(verdict, Judgement):
        return _refined(verdict)
    found.ask_all(verdict, "gyro", *(each.sensor for each in vectors))
    return None


def _vectors(gyro: Stream, others: Sequence[Stream], found: Findings) -> Iterator[Misfits]:
    """Vectors that have enough time in common with the gyro."""
    begin_ns = int(gyro.t_ns[0])
    t_s, rate = gyro.averaged(GYRO_HZ, begin_ns)
    world = lru_cache(KEPT_WORLDS)(lambda gyro: integrated(t_s, gyro * rate))
    for stream in others:
        averaged = stream.between(begin_ns, int(gyro.t_ns[-1])).averaged(VECTOR_HZ, begin_ns)
        each = Misfits(stream.sensor, *averaged, OFFSET_COSTS[stream.sensor], world)
        if each.lengths_s:
            yield each
        else:
            found.ask_all("the log has too little of this sensor together with the gyro", stream.sensor)


def _verdict(vectors: Sequence[Misfits], turned_deg: float, found: Findings) -> Judgement | str:
    """Choice of the rule, or why there is none.

    Parameters
    ----------
    vectors : sequence of Misfits
    turned_deg : float
        Rotation from one reading to the next, nine in ten, if the gyro is right, degrees.
    found : Findings
    """
    more = _searched(vectors)
    clearest = max((each.best()[1] for each in vectors), key=lambda best: best.misfits.contrast(best.gyro))
    if turned_deg * min(abs(clearest.gyro), 1.0) > MAX_ROTATION_DEG:  # larger ones are found where nothing fits
        return "the log is too slow for its motion, and wants a higher rate or slower turns; or its gyro reads counts"
    vectors = [fit for each in vectors for fit in _explained(each, more, found)]
    every = explanations(vectors, (*GYROS, *more)) if vectors else []
    if not every:
        return "no one gyro explains all other sensors"
    verdict = judged(every)
    factor = abs(verdict.best.gyro)
    if all(len(each.turns(verdict.best.gyro)) > 1 for each in vectors):
        factor = max(factor, 1.0)  # about one axis a slow gyro fits where a fast one skips turns
    return (
        "the gyro that fits best turns too far between readings" if turned_deg * factor > MAX_ROTATION_DEG else verdict
    )


def _searched(vectors: Sequence[Misfits]) -> list[float]:
    """Search with the gyros of the grid, then with the factors that each vector by itself fits best, and tell those."""
    search(vectors)
    more = []
    for each in vectors:
        best = each.best()[1]
        factor, ((refined, _),) = refine([best])
        if abs(np.log(refined.gyro / best.gyro)) > REFINED_LOG_FACTOR and factor.sigma < MAX_LOG_FACTOR_ERROR:
            more += [refined.gyro, -refined.gyro]
    scan(vectors, more)
    return more


def _explained(each: Misfits, more: Sequence[float], found: Findings) -> Iterator[Misfits]:
    """The vector, if some hypothesis makes it constant; an accelerometer that lost a constant is searched anew."""
    sensor = each.sensor
    held = constants_of(each.best()[1])
    if sensor == "accelerometer" and not (held.is_gravity and held.offset_share < MIN_TAKEN_OFF):
        free = replace(each, offset_cost=OFFSET_COSTS["magnetometer"])
        search([free])
        scan([free], more)
        freed = constants_of(free.best()[1])
        is_taken_off = freed.is_gravity and freed.offset_share > MIN_TAKEN_OFF
        if is_taken_off and held.misfit >= freed.misfit * MIN_GAIN:
            each = free
            held = freed
        elif held.size < MAX_NO_GRAVITY * GRAVITY:
            found.name(
                "gravity_removed",
                sensor,
                f"the accelerometer reads no gravity: its mean in the world is {held.size:.2g} m/s²; a driver took it "
                "off, or the body falls freely",
                before=held.misfit,
                or_else=("accelerometer_units",) if held.swing < MAX_SWING else (),
            )
            return
        elif held.has_unit:
            found.ask("gravity_removed", f"{held.offset_share:.0%} of gravity are constant on the accelerometer's axes")
    left = held.misfit * each.size / held.size
    if left <= MAX_MISFIT:
        yield each
    else:
        found.ask_all(f"no repair makes the {sensor} constant in the world, {left:.0%} of it remain", sensor)


def _refined(verdict: Judgement) -> SensorComparison:
    """The explanation that the rule chose, with its constants fitted."""
    factor, fitted = refine(verdict.best.fittings)
    vectors = {
        placed.misfits.sensor: Compared(placed, delay, constants_of(placed), is_told)
        for (placed, delay), is_told in zip(fitted, verdict.turns_told, strict=True)
    }
    before = max(placed.misfits.plain for placed, _ in fitted)
    after = max(each.constants.misfit for each in vectors.values())
    return SensorComparison(verdict, factor, vectors, {"before": before, "after": after})
