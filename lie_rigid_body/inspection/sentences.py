"""What is said of a comparison: mistakes, what is undecided, notes, and the changes that undo the mistakes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import components, numerals
from lie_rigid_body.inspection.comparison import Comparison
from lie_rigid_body.inspection.constants import Constants, Delay, other_delays
from lie_rigid_body.inspection.explanations import Repair, axes_text
from lie_rigid_body.inspection.findings import Findings, Mistake
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_UNITS,
    DEGREE,
    DIM_DELAY_S,
    EXCLUDED,
    FIELD_MARGIN,
    FIELDS_T,
    GRAVITY,
    MAGNETOMETER_UNITS,
    MAX_UNIT_LOG_ERROR,
    MAX_UNIT_MISFIT,
    MIN_DELAY_S,
    MIN_GAIN,
    MIN_HARD_IRON,
    MIN_LOG_FACTOR,
    MIN_UNSEEN_S,
    OTHER_UNIT,
    SAME_UNIT,
    SIGMAS,
    TURNS,
    Gyro,
)
from lie_rigid_body.inspection.world import fit_turns

_MEANINGS = {
    "gyro_axes": "the gyro's axes are not those of the other sensors",
    "accelerometer_axes": "the accelerometer's axes are not those of the other sensors, but for the sign of the whole",
    "magnetometer_axes": "the magnetometer's axes are not those of the other sensors, but for the sign of the whole",
    "gyro_units": "the gyro reads degrees",
    "time_step": "the gyro counts by another factor than the other sensors show",
}
_LEFT_HANDED = "the gyro has the opposite sign, or all sensors have a left-handed frame"
_OVER_DEGREES = "the gyro reads rates that were taken for degrees, and were none"


@dataclass
class Change:
    """Change of the readings of a sensor that undoes its mistakes.

    Attributes
    ----------
    matrix : ndarray, shape (3, 3)
        From the readings less the offset.
    offset : ndarray, shape (3,)
    delay_s : float
        Time from when they were true to their stamps, s.
    """

    matrix: Array
    offset: Array
    delay_s: float = 0.0

    @classmethod
    def none(cls) -> Change:
        """A change of nothing."""
        return cls(np.eye(3), np.zeros(3))


Changes = dict[str, Change]
"""Changes by their sensors."""


def tell(comparison: Comparison, found: Findings, changes: Changes) -> None:
    """Tell all that a comparison shows."""
    _tell_axes(comparison, found, changes)
    _tell_other_turns(comparison, found)
    _tell_factor(comparison, found, changes)
    _tell_delays(comparison, found, changes)
    for i in range(len(comparison.placed)):
        _tell_offset(comparison, i, found, changes)
    _tell_rate_bias(comparison, found)
    _tell_accelerometer_unit(comparison, found, changes)


def _tell_axes(comparison: Comparison, found: Findings, changes: Changes) -> None:
    verdict = comparison.verdict
    for repair in verdict.named:
        if repair.code == "time_step":
            continue
        others = () if all(repair in each for each in verdict.or_else) else verdict.or_else
        also = [each for repairs in others for each in repairs if each not in verdict.named]
        same = [each.text for each in also if each.code == repair.code]
        meaning = _meaning(repair) + "".join(f"; or as well {text}" for text in same)
        codes = tuple(dict.fromkeys(each.code for each in also if each.code != repair.code))
        found.mistakes.append(
            Mistake(repair.code, repair.sensor, meaning, repair.text, comparison.before, comparison.after, codes)
        )
        _change_axes(comparison, repair, changes)
    for repair in verdict.undecided:
        why = "fewer repairs nearly do" if verdict.fewer else "too many explanations do as well"
        found.ask(repair.code, f"{_meaning(repair)}, perhaps: {why}")


def _meaning(repair: Repair) -> str:
    if repair.text == "-x -y -z":
        return _LEFT_HANDED
    if repair.text == "× 180/π":
        return _OVER_DEGREES
    return _MEANINGS[repair.code]


def _change_axes(comparison: Comparison, repair: Repair, changes: Changes) -> None:
    best = comparison.verdict.best
    change = changes[repair.sensor]
    back = TURNS[best.frame].T
    turns = {each.misfits.vector.sensor: TURNS[each.turn] for each in comparison.placed}
    if repair.code == "gyro_units":
        change.matrix = change.matrix * _base(comparison)
    elif repair.sensor == "gyro":
        change.matrix = best.gyro.sign * back @ change.matrix
    else:
        change.matrix = back @ turns[repair.sensor] @ change.matrix


def _base(comparison: Comparison) -> float:
    """Factor of the gyro that is a unit, and named."""
    units = [repair for repair in comparison.verdict.named if repair.code == "gyro_units"]
    if not units:
        return 1.0
    return DEGREE if comparison.refined.gyro.factor < 1.0 else 1.0 / DEGREE


def _tell_other_turns(comparison: Comparison, found: Findings) -> None:
    """List the turns that fit as well under the same gyro, of vectors of which no axes are named."""
    for each, fitting in zip(comparison.placed, comparison.verdict.best.fittings, strict=True):
        sensor = each.misfits.vector.sensor
        _, misfits = each.misfits.by_delay(comparison.verdict.best.gyro)
        fit = np.flatnonzero(misfits.min(axis=0) <= EXCLUDED * each.misfits.least)
        others = [axes_text(TURNS[turn]) for turn in fit if turn != fitting.turn]
        if others and not found.has(f"{sensor}_axes", sensor):
            found.ask(f"{sensor}_axes", f"the {sensor}'s axes may as well be {', '.join(others)}")


def _tell_factor(comparison: Comparison, found: Findings, changes: Changes) -> None:
    refined = comparison.refined
    base = _base(comparison)
    size = float(np.log(refined.gyro.factor / base))
    sigma = refined.log_factor_sigma
    verdict = comparison.verdict
    repairs = [repair for each in (verdict.named, *verdict.or_else) for repair in each]
    is_unit = base == 1.0 and any(repair.code == "gyro_units" for repair in repairs)
    told = abs(size) > max(MIN_LOG_FACTOR, SIGMAS * sigma) and not verdict.fewer and not is_unit
    if told and _factor_gain(comparison, base) > MIN_GAIN:
        text = f"{_MEANINGS['time_step']}: multiply it by {np.exp(size):.4g} ± {np.exp(size) * sigma:.1g}"
        found.mistakes.append(
            Mistake("time_step", "gyro", text, f"× {np.exp(size):.4g}", comparison.before, comparison.after)
        )
        changes["gyro"].matrix = changes["gyro"].matrix * np.exp(size)
    elif SIGMAS * sigma > MAX_UNIT_LOG_ERROR:
        found.ask("time_step", f"the gyro's factor is only known to {sigma:.0%}")


def _factor_gain(comparison: Comparison, base: float) -> float:
    """Ratio of the misfit without another factor than that of a unit to that with it."""
    world = comparison.worlds.of(Gyro(comparison.refined.gyro.sign, base))
    gains = []
    for each, constants in zip(comparison.placed, comparison.constants, strict=True):
        gram = each.blocks(world).windows(each.misfits.length_s).gram()[0]
        fit = fit_turns(gram, each.misfits.vector.offset_cost)
        gains.append(float(fit.told[each.turn]) / constants.misfit)
    return max(gains)


def _tell_delays(comparison: Comparison, found: Findings, changes: Changes) -> None:
    delays = {
        each.misfits.vector.sensor: delay
        for each, delay in zip(comparison.placed, comparison.refined.delays, strict=True)
    }
    recurring = _recurring(comparison, found)
    told = dict(zip(delays, comparison.verdict.turns_told, strict=True))
    late = [
        sensor
        for sensor, delay in delays.items()
        if delay.is_late and told[sensor] and sensor not in recurring and not comparison.verdict.fewer
    ]
    if len(late) == 2 and _are_alike([delays[sensor] for sensor in late]):
        _name_late(
            "gyro", -float(np.mean([delay.delay_s for delay in delays.values()])), (), comparison, found, changes
        )
        return
    for sensor in late:
        others = [delay for name, delay in delays.items() if name != sensor]
        own = delays[sensor]
        as_well = len(late) == 1 and (not others or abs(others[0].delay_s - own.delay_s) < others[0].unseen_s)
        _name_late(sensor, own.delay_s, ("gyro_late",) if as_well else (), comparison, found, changes)
    for sensor, delay in delays.items():
        if sensor in late:
            continue
        if abs(delay.delay_s) > MIN_DELAY_S or delay.unseen_s > DIM_DELAY_S:
            found.ask(f"{sensor}_late", f"a delay of the {sensor} of {delay.unseen_s:.2g} s is not seen")
        else:
            found.note(
                f"{sensor}_late", f"the {sensor} is {delay.delay_s * 1e3:.3g} ms late against the gyro", delay.delay_s
            )


def _are_alike(delays: Sequence[Delay]) -> bool:
    """Whether two delays are one of the gyro, as far as the log sees."""
    apart = abs(delays[0].delay_s - delays[1].delay_s)
    return apart < max(MIN_UNSEEN_S, *(delay.unseen_s for delay in delays))


def _recurring(comparison: Comparison, found: Findings) -> set[str]:
    """Sensors whose delay has another value that does as well."""
    recurring = set()
    for each, delay in zip(comparison.placed, comparison.refined.delays, strict=True):
        if abs(delay.delay_s) <= MIN_DELAY_S:
            continue
        gyro = comparison.verdict.best.gyro
        others = other_delays(each, gyro, comparison.worlds.of(comparison.refined.gyro), delay)
        if others:
            sensor = each.misfits.vector.sensor
            text = ", ".join(f"{other:.3f} s" for other in others)
            found.ask(f"{sensor}_late", f"the motion recurs, so that {delay.delay_s:.3f} s, {text} do as well")
            recurring.add(sensor)
    return recurring


def _name_late(
    sensor: str, delay_s: float, or_else: tuple[str, ...], comparison: Comparison, found: Findings, changes: Changes
) -> None:
    text = f"the {sensor} is {delay_s * 1e3:.0f} ms late against the others"
    found.mistakes.append(
        Mistake(f"{sensor}_late", sensor, text, f"{-delay_s:+.4f} s", comparison.before, comparison.after, or_else)
    )
    changes[sensor].delay_s = delay_s


def _tell_offset(comparison: Comparison, i: int, found: Findings, changes: Changes) -> None:
    placed = comparison.placed[i]
    constants = comparison.constants[i]
    sensor = placed.misfits.vector.sensor
    if sensor == "accelerometer":
        if comparison.taken_off:
            _tell_taken_off(comparison, constants, found, changes)
        return
    share = constants.offset_share
    told = comparison.verdict.turns_told[i] and not comparison.verdict.fewer
    found.note("field", f"the field has a size of {constants.size:.4g} in the readings' unit", constants.size)
    if told:
        found.estimate(
            "magnetometer_hard_iron",
            tuple(map(float, constants.offset)),
            tuple(map(float, constants.offset_sigma)),
        )
    if share > max(MIN_HARD_IRON, SIGMAS * constants.offset_share_sigma) and constants.offset_gain > MIN_GAIN:
        if told and constants.shape.offset > MIN_HARD_IRON * constants.size / placed.misfits.vector.size:
            text = f"hard iron of ({numerals(constants.offset)}), {share:.2f} of the field"
            found.note("hard_iron", text, tuple(map(float, constants.offset)))
        else:
            found.ask("hard_iron", f"an offset of {share:.2f} of the field, or soft iron, or other axes, are as good")
    if constants.seen < MIN_GAIN:
        found.ask("hard_iron", f"hard iron along ({components(constants.blind, 2)}) of the sensor is not seen")


def _tell_taken_off(comparison: Comparison, constants: Constants, found: Findings, changes: Changes) -> None:
    text = (
        f"a constant of ({components(-constants.offset, 3)}) in the sensor's axes was taken off the accelerometer: "
        "its mean, or its reading at rest"
    )
    given = ", ".join(f"{-number:+.4g}" for number in constants.offset)
    found.mistakes.append(
        Mistake("gravity_removed", "accelerometer", text, f"+ ({given})", comparison.before, comparison.after)
    )
    changes["accelerometer"].offset = constants.offset


def _tell_rate_bias(comparison: Comparison, found: Findings) -> None:
    """Tell the bias of the gyro's readings that the vector with the least misfit shows, unless rest has told it."""
    best = min(comparison.constants, key=lambda constants: constants.misfit)
    bias = tuple(map(float, -best.rate_bias / comparison.refined.gyro.multiplier))
    errors = tuple(map(float, best.rate_bias_sigma / comparison.refined.gyro.factor))
    found.note("gyro_bias", f"the gyro has a bias of ({numerals(np.degrees(bias))}) °/s", bias)
    if "gyro_bias" not in found.sensors:
        found.estimate("gyro_bias", bias, errors)


def _tell_accelerometer_unit(comparison: Comparison, found: Findings, changes: Changes) -> None:
    constants = comparison.constants[0]
    if comparison.placed[0].misfits.vector.sensor != "accelerometer":
        return
    size = constants.size
    unit, gravity = min(ACCELEROMETER_UNITS.items(), key=lambda item: abs(np.log(size / item[1])))
    away = abs(np.log(size / gravity))
    sure = constants.misfit <= MAX_UNIT_MISFIT and SIGMAS * comparison.refined.log_factor_sigma <= MAX_UNIT_LOG_ERROR
    if away < SAME_UNIT and unit == "m/s²":
        return
    if away >= SAME_UNIT and (away < OTHER_UNIT or not sure):
        found.ask("accelerometer_units", f"gravity is {size:.4g} in the accelerometer's unit")
        return
    factor = GRAVITY / (gravity if away < SAME_UNIT else size)
    text = f"the accelerometer reads {unit if away < SAME_UNIT else 'an unknown unit'}: gravity is {size:.4g}"
    found.mistakes.append(Mistake("accelerometer_units", "accelerometer", text, f"× {factor:.6g}"))
    changes["accelerometer"].matrix = changes["accelerometer"].matrix * factor


def tell_field_unit(size: float, found: Findings, changes: Changes) -> None:
    """Tell the unit of the magnetometer by the size of its readings.

    Parameters
    ----------
    size : float
        Median size of the readings, less their offset where that is told, in their unit.
    found : Findings
    changes : Changes
    """
    inside = {name: unit for name, unit in MAGNETOMETER_UNITS.items() if FIELDS_T[0] < size * unit < FIELDS_T[1]}
    near = [
        name
        for name, unit in MAGNETOMETER_UNITS.items()
        if FIELDS_T[0] / FIELD_MARGIN < size * unit < FIELDS_T[1] * FIELD_MARGIN
    ]
    if "T" in inside:
        return
    if not inside and near:
        found.ask("magnetometer_units", f"the field is {size:.3g} in its unit, which may be {' or '.join(near)}")
        return
    name, unit = next(iter(inside.items()), ("counts", None))
    text = f"the magnetometer reads {name}: the field is {size:.4g}"
    found.mistakes.append(Mistake("magnetometer_units", "magnetometer", text, f"× {unit:g}" if unit else ""))
    if unit:
        changes["magnetometer"].matrix = changes["magnetometer"].matrix * unit
