"""Sentences about a comparison: mistakes, what is undecided, notes, and the changes that undo the mistakes."""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import SI, components, numerals
from lie_rigid_body.inspection.comparison import Compared, SensorComparison
from lie_rigid_body.inspection.constants import constants_of, other_delays
from lie_rigid_body.inspection.explanations import UNDONE, SensorRepair, axes_text
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_UNITS,
    DIM_DELAY_S,
    MAGNETOMETER_UNITS,
    MAX_DELAY_S,
    MAX_SHAPE_ERROR,
    MAX_UNIT_LOG_ERROR,
    MAX_UNIT_MISFIT,
    MIN_DELAY_S,
    MIN_GAIN,
    MIN_HARD_IRON,
    MIN_LOG_FACTOR,
    MOUNTING_ERROR,
    OFFSET_COSTS,
    OTHER_FIELD,
    OTHER_UNIT,
    SAME_FIELD,
    SAME_UNIT,
    SIGMAS,
    TURNS,
    nearest_unit,
)
from lie_rigid_body.lie.vectors import norm

_MEANINGS = {
    "gyro_units": "the gyro reads degrees",
    "time_step": "the gyro counts by another factor than the other sensors show",
    "-x -y -z": "the gyro has the opposite sign, or all sensors have a left-handed frame",
    "× 180/π": "the gyro reads rates that were taken for degrees, and were none",
}
"""Meanings of repairs by their codes, and of two by their texts."""
_UNITS: Final = {
    "accelerometer": (
        "gravity",
        ACCELEROMETER_UNITS,
        SAME_UNIT,
        OTHER_UNIT,
        "",
        ("accelerometer_units", "gravity_removed"),
    ),
    "magnetometer": (
        "the field",
        MAGNETOMETER_UNITS,
        SAME_FIELD,
        OTHER_FIELD,
        ", or counts of this size",
        ("magnetometer_units",),
    ),
}
"""Vectors of a known size, these sizes by their units, limits of the logarithm of their ratio, what else it may be, and
codes."""


def tell_mistakes(comparison: SensorComparison, found: Findings) -> None:
    """Tell the mistakes that a comparison shows, and what it does not decide."""
    _tell_axes(comparison, found)
    _tell_factor(comparison, found)
    _tell_delays(comparison, found)
    if "accelerometer" in comparison.vectors:
        _tell_constant_and_unit(comparison, found)


def tell_constants(comparison: SensorComparison, found: Findings) -> None:
    """Tell the constants that a comparison shows, of the repaired readings."""
    if "magnetometer" in comparison.vectors:
        _tell_iron(comparison.vectors["magnetometer"], found)
    _tell_rate_bias(comparison, found)
    if len(comparison.vectors) == 2 and all(each.is_told for each in comparison.vectors.values()):
        _tell_dip(comparison, found)


def _tell_axes(comparison: SensorComparison, found: Findings) -> None:
    """Tell the repairs of axes and of the gyro's unit that the rule names, and those that it leaves undecided.

    Turns that fit as well under the same gyro are listed, of vectors of which no axes are named.
    """
    verdict = comparison.verdict
    for repair in verdict.named:
        if repair.code == "time_step":  # its size is fitted
            continue
        also = () if all(repair in each for each in verdict.others) else verdict.alternatives
        text = "".join(f"; or as well {each.text}" for each in also if each.code == repair.code)
        codes = tuple(dict.fromkeys(each.code for each in also if each.code != repair.code))
        meaning = _meaning(repair) + text
        undone = UNDONE[repair.text]
        found.name(repair.code, repair.sensor, meaning, repair.text, undone, or_else=codes, **comparison.misfits)
    for repair in verdict.alternatives if verdict.is_open else ():
        found.ask(repair.code, f"{_meaning(repair)}, perhaps: other explanations do as well, or fewer repairs nearly")
    for sensor, vector in comparison.vectors.items():
        fit = vector.placed.misfits.turns(verdict.best.gyro)
        others = [axes_text(TURNS[turn]) for turn in fit if turn != vector.placed.turn]
        code = f"{sensor}_axes"
        if others and not found.has(code, sensor):
            found.ask(code, f"the {sensor}'s axes may as well be {', '.join(others)}")


def _meaning(repair: SensorRepair) -> str:
    """Meaning of a repair, in words: by its text where there is a sentence of its own."""
    sign = "" if repair.sensor == "gyro" else ", but for the sign of all three"
    axes = f"the {repair.sensor}'s axes are not those of the other sensors{sign}"
    return _MEANINGS.get(repair.text, _MEANINGS.get(repair.code, axes))


def _tell_factor(comparison: SensorComparison, found: Findings) -> None:
    """Tell a factor of the gyro beside that of its unit."""
    verdict = comparison.verdict
    sigma = comparison.factor.sigma
    unit = norm(found.changes["gyro"].matrix[0])
    factor = np.exp(comparison.factor.place) / unit
    codes = {repair.code for repair in (*verdict.named, *verdict.alternatives)}
    told = not verdict.fewer and (unit != 1.0 or "gyro_units" not in codes)
    if told and abs(np.log(factor)) > comparison.factor.unseen(MIN_LOG_FACTOR):
        found.name(
            "time_step",
            "gyro",
            f"{_MEANINGS['time_step']}: multiply it by {factor:.4g} ± {factor * sigma:.1g}",
            f"× {factor:.4g}",
            factor,
            **comparison.misfits,
        )
    elif SIGMAS * sigma > MAX_UNIT_LOG_ERROR or "time_step" in codes:
        found.ask("time_step", f"the gyro's factor of {factor:.4g} ± {sigma:.1g} is not told apart from 1")


def _tell_delays(comparison: SensorComparison, found: Findings) -> None:
    """Tell sensors that are late; two that are as late as each other are a gyro that is early."""
    late: dict[str, tuple[float, float]] = {}
    for sensor, each in comparison.vectors.items():
        delay = each.delay
        unseen_s = delay.unseen(MIN_DELAY_S)
        code = f"{sensor}_late"
        others = other_delays(each.placed, comparison.verdict.best.gyro, delay)
        if others:
            text = ", ".join(f"{other:.3f} s" for other in (delay.place, *others))
            found.ask(code, f"the motion recurs, so that {text} do as well")
        elif abs(delay.place) > unseen_s and each.is_told:
            late[sensor] = delay.place, delay.error
        elif abs(delay.place) > MIN_DELAY_S or unseen_s > DIM_DELAY_S:
            found.ask(code, f"a delay of the {sensor} of {min(unseen_s, MAX_DELAY_S):.2g} s is not seen")
        else:
            found.note(code, f"the {sensor} is {delay.place * 1e3:.3g} ms late against the gyro", delay.place)
    delays = [each.delay for each in comparison.vectors.values()]
    is_alike = delays[0].is_like(delays[-1])
    or_else = ("gyro_late",) if is_alike and len(late) == 1 else ()
    if is_alike and len(late) == 2:
        delay_s, error_s = np.mean([*late.values()], axis=0)
        late = {"gyro": (-delay_s, error_s)}
    for sensor, (delay_s, error_s) in late.items():
        found.name(
            f"{sensor}_late",
            sensor,
            f"the {sensor} is {delay_s:.3f} s ± {error_s:.1g} s late against the others",
            f"{-delay_s:+.4f} s",
            or_else=or_else,
            **comparison.misfits,
        )
        found.changes[sensor].delay_s = delay_s
    if "magnetometer" in late:
        found.estimate("magnetometer_clock_offset", *late["magnetometer"])


def _tell_iron(each: Compared, found: Findings) -> None:
    """Tell the size of the field, and hard and soft iron."""
    constants = constants_of(each.placed, found.changes["magnetometer"].matrix)
    unit = found.unit("magnetometer")
    field = constants.size
    found.note("field", f"the field has a size of {field:.4g} {unit}: does this fit the place?", field)
    iron = constants.shape_offset
    error = constants.shape_offset_sigma
    if each.is_told:
        found.estimate("magnetometer_hard_iron", iron, error)
        if constants.misfit > MIN_GAIN * constants.shape_misfit and np.all(constants.shape_sigma < MAX_SHAPE_ERROR):
            soft_iron = np.linalg.inv(constants.shape)
            soft_iron *= 3.0 / np.trace(soft_iron)  # its size is that of the field
            sigma = np.hypot(constants.shape_sigma, MOUNTING_ERROR * (1.0 - np.eye(3)))
            found.note("soft_iron", f"soft iron, or unequal axes, of ({numerals(soft_iron.ravel())})", soft_iron)
            found.estimate("magnetometer_soft_iron", soft_iron, sigma)
    share = constants.offset_share
    least = max(MIN_HARD_IRON, SIGMAS * rms(constants.offset_sigma) / field)
    if share > least and constants.sees(constants.offset / field):
        if each.is_told and norm(iron) > MIN_HARD_IRON * field:
            text = f"hard iron of ({numerals(iron, 3)}) ± ({numerals(error, 1)}) {unit}, {share:.2f} of the field"
            found.note("hard_iron", text, iron)
        else:
            found.ask("hard_iron", f"an offset of {share:.2f} of the field, or soft iron, or other axes, are as good")
    if not constants.sees(MIN_HARD_IRON * constants.blind):
        found.ask("hard_iron", f"hard iron along ({components(constants.blind, 2)}) of the sensor is not seen")


def _tell_constant_and_unit(comparison: SensorComparison, found: Findings) -> None:
    """Tell a constant that was taken off the accelerometer, and the unit in which its size is that of gravity."""
    placed, _, constants, _ = comparison.vectors["accelerometer"]
    if placed.misfits.offset_cost != OFFSET_COSTS["accelerometer"]:  # free, as a constant was taken off
        given = numerals(-constants.offset)
        found.name(
            "gravity_removed",
            "accelerometer",
            f"a constant of ({given}) in the sensor's axes was taken off: its mean, or its reading at rest",
            f"+ ({given})",
            **comparison.misfits,
        )
        found.changes["accelerometer"].offset = constants.offset
    is_sure = (
        constants.misfit <= MAX_UNIT_MISFIT
        and SIGMAS * comparison.factor.sigma <= MAX_UNIT_LOG_ERROR
        and constants.sees(MIN_HARD_IRON * constants.blind)
    )
    _tell_unit("accelerometer", constants.size, is_sure=is_sure, found=found)


def _tell_rate_bias(comparison: SensorComparison, found: Findings) -> None:
    """Tell the bias of the gyro's readings that the vector with the least misfit shows, unless rest has told it."""
    best = min(comparison.vectors.values(), key=lambda each: each.constants.misfit)
    repair = found.changes["gyro"].matrix / best.placed.gyro
    if "gyro_bias" not in found.sensors:
        bias = -repair @ best.constants.rate_bias
        found.estimate("gyro_bias", bias, np.abs(repair) @ best.constants.rate_bias_sigma)
    shown = found.sensors["gyro_bias"].value
    found.note("gyro_bias", f"the gyro has a bias of ({numerals(np.degrees(shown))}) °/s", shown)


def _tell_dip(comparison: SensorComparison, found: Findings) -> None:
    """Tell the angle between the field and the horizontal, positive if it points down."""
    up, north = (each.constants.means / each.constants.size for each in comparison.vectors.values())
    rise = np.mean([one @ other for one, other in zip(up, north, strict=False)])
    dip = -np.degrees(np.arcsin(rise))
    side, half = ("below", "northern") if dip > 0.0 else ("above", "southern")
    found.note(
        "dip",
        f"the field points {abs(dip):.1f}° {side} the horizontal, as in the {half} hemisphere: does this fit the "
        "place? In the other one, one of the two vectors has the opposite sign",
        dip,
    )
    (size,) = (note.value for note in found.notes if note.code == "field")
    found.estimate("magnetic_field", size * np.array([0.0, np.sqrt(1.0 - rise**2), rise]))


def tell_unit_of_field(readings: Array, comparison: SensorComparison | None, found: Findings) -> None:
    """Tell the unit of a magnetometer, by the size of its readings less the hard iron that is told."""
    compared = comparison and comparison.vectors.get("magnetometer")
    iron = compared.constants.shape_offset if compared and compared.is_told else 0.0
    size = np.median(norm(readings - iron))
    _tell_unit("magnetometer", size, is_sure=True, found=found)


def _tell_unit(sensor: str, size: float, *, is_sure: bool, found: Findings) -> None:
    """Tell the unit of an accelerometer or a magnetometer, by the size of gravity or of the field in it.

    Parameters
    ----------
    sensor : str
    size : float
        Size of the readings, in their unit.
    is_sure : bool
        Whether the size is known so well that it may be of an unknown unit.
    found : Findings
    """
    vector, units, same, other, also, codes = _UNITS[sensor]
    away, unit, usual = nearest_unit(size, units)
    is_known = away < same
    if not is_known and (away < other or not is_sure):
        for code in codes:
            found.ask(code, f"{vector} is {size:.4g} in the {sensor}'s unit, which may be {unit}")
    elif unit != SI[sensor] or not is_known:
        told = f"{unit}{also}" if is_known else "an unknown unit, or counts"
        is_repaired = is_known or sensor == "accelerometer"  # gravity has one size, the field has many
        factor = units[SI[sensor]] / (usual if is_known else size) if is_repaired else 1.0
        repair = f"× {factor:.6g}" if is_repaired else ""
        found.name(codes[0], sensor, f"the {sensor} reads {told}: {vector} is {size:.4g}", repair, factor)
