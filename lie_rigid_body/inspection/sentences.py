"""Sentences about a comparison: mistakes, what is undecided, notes, and the changes that undo the mistakes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import components, numerals
from lie_rigid_body.inspection.comparison import Compared, SensorComparison
from lie_rigid_body.inspection.constants import constants_of, other_delays
from lie_rigid_body.inspection.explanations import SensorRepair, axes_text
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    ACCELEROMETER_UNITS,
    DEGREE,
    DIM_DELAY_S,
    EXCLUDED,
    FIELD_MARGIN,
    FIELDS_T,
    GRAVITY,
    MAGNETOMETER_UNITS,
    MAX_SHAPE_ERROR,
    MAX_UNIT_LOG_ERROR,
    MAX_UNIT_MISFIT,
    MIN_DELAY_S,
    MIN_GAIN,
    MIN_HARD_IRON,
    MIN_LOG_FACTOR,
    OTHER_UNIT,
    SAME_UNIT,
    SIGMAS,
    TURNS,
    Gyro,
)
from lie_rigid_body.inspection.stamps import Stream

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

    @property
    def is_none(self) -> bool:
        """Whether nothing is changed."""
        return not self.delay_s and not self.offset.any() and np.array_equal(self.matrix, np.eye(3))

    def applied(self, stream: Stream) -> Stream:
        """Readings at the times when they were true."""
        t_ns = stream.t_ns - round(self.delay_s * 1e9)
        return replace(stream, t_ns=t_ns, readings=(stream.readings - self.offset) @ self.matrix.T)


Changes = dict[str, Change]
"""Changes by their sensors."""


def tell(comparison: SensorComparison, found: Findings, changes: Changes) -> None:
    """Tell all that a comparison shows."""
    _tell_axes(comparison, found, changes)
    _tell_other_turns(comparison, found)
    _tell_factor(comparison, found, changes)
    _tell_delays(comparison, found, changes)
    for each in comparison.vectors:
        if each.sensor == "magnetometer":
            _tell_hard_iron(each, found)
        else:
            _tell_constant_and_unit(comparison, each, found, changes)
    _tell_rate_bias(comparison, found)
    if len(comparison.vectors) == 2 and all(each.is_told for each in comparison.vectors):
        _tell_dip(comparison, found)


def _tell_dip(comparison: SensorComparison, found: Findings) -> None:
    """Tell the angle between the field and the horizontal, positive if it points down."""
    means = []
    for each in comparison.vectors:
        windows = each.placed.blocks(comparison.worlds.of(comparison.gyro)).windows(each.placed.misfits.lengths_s[-1])
        turn = each.placed.turn
        offset = TURNS[turn] @ each.constants.offset / each.placed.misfits.vector.size
        vectors = windows.vectors(turn, offset)
        means.append(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
    count = min(map(len, means))
    dip = -np.degrees(np.arcsin(np.mean(np.sum(means[0][:count] * means[1][:count], axis=1))))
    text = f"the field points {dip:.1f}° below the horizontal, if both signs are right: does this fit the place?"
    found.note("dip", text, dip)
    size = comparison.vectors[-1].constants.size
    found.estimate("magnetic_field", size * np.array([0.0, np.cos(np.radians(dip)), -np.sin(np.radians(dip))]))


def _tell_axes(comparison: SensorComparison, found: Findings, changes: Changes) -> None:
    verdict = comparison.verdict
    for repair in verdict.named:
        if repair.code == "time_step":  # its size is fitted
            continue
        others = () if all(repair in each for each in verdict.or_else) else verdict.or_else
        also = [each for repairs in others for each in repairs if each not in verdict.named]
        text = "".join(f"; or as well {each.text}" for each in also if each.code == repair.code)
        codes = tuple(dict.fromkeys(each.code for each in also if each.code != repair.code))
        meaning = _meaning(repair) + text
        found.name(repair.code, repair.sensor, meaning, repair.text, or_else=codes, **comparison.misfits)
        changes[repair.sensor].matrix = _matrix(comparison, repair) @ changes[repair.sensor].matrix
    for repair in verdict.undecided:
        why = "fewer repairs nearly do" if verdict.fewer else "too many explanations do as well"
        found.ask(repair.code, f"{_meaning(repair)}, perhaps: {why}")


def _meaning(repair: SensorRepair) -> str:
    if repair.text == "-x -y -z":
        return _LEFT_HANDED
    if repair.text == "× 180/π":
        return _OVER_DEGREES
    return _MEANINGS[repair.code]


def _matrix(comparison: SensorComparison, repair: SensorRepair) -> Array:
    """Matrix of a repair of axes or of a unit of the gyro, shape (3, 3)."""
    if repair.code == "gyro_units":
        return np.eye(3) * _unit(comparison)
    best = comparison.verdict.best
    turns = {"gyro": best.gyro.sign * TURNS[0], **{each.sensor: TURNS[each.placed.turn] for each in comparison.vectors}}
    return np.asarray(TURNS[best.frame].T @ turns[repair.sensor])


def _unit(comparison: SensorComparison) -> float:
    """Factor of the gyro that is a unit, and named; else 1."""
    if not any(repair.code == "gyro_units" for repair in comparison.verdict.named):
        return 1.0
    return DEGREE if comparison.gyro.factor < 1.0 else 1.0 / DEGREE


def _tell_other_turns(comparison: SensorComparison, found: Findings) -> None:
    """List the turns that fit as well under the same gyro, of vectors of which no axes are named."""
    for each in comparison.vectors:
        misfits = each.placed.misfits
        least = misfits.by_delay(comparison.verdict.best.gyro)[1].min(axis=0)
        fit = np.flatnonzero(least <= EXCLUDED * misfits.least)
        others = [axes_text(TURNS[turn]) for turn in fit if turn != each.placed.turn]
        code = f"{each.sensor}_axes"
        if others and not found.has(code, each.sensor):
            found.ask(code, f"the {each.sensor}'s axes may as well be {', '.join(others)}")


def _tell_factor(comparison: SensorComparison, found: Findings, changes: Changes) -> None:
    verdict = comparison.verdict
    unit = _unit(comparison)
    factor = comparison.gyro.factor / unit
    sigma = comparison.log_factor_sigma
    codes = {repair.code for each in (verdict.named, *verdict.or_else) for repair in each}
    told = not verdict.fewer and (unit != 1.0 or "gyro_units" not in codes)
    if told and abs(np.log(factor)) > max(MIN_LOG_FACTOR, SIGMAS * sigma) and _factor_gain(comparison, unit) > MIN_GAIN:
        text = f"{_MEANINGS['time_step']}: multiply it by {factor:.4g} ± {factor * sigma:.1g}"
        found.name("time_step", "gyro", text, f"× {factor:.4g}", **comparison.misfits)
        changes["gyro"].matrix *= factor
    elif SIGMAS * sigma > MAX_UNIT_LOG_ERROR or "time_step" in codes:
        found.ask("time_step", f"the gyro's factor of {factor:.4g} is only known to {sigma:.0%}")


def _factor_gain(comparison: SensorComparison, unit: float) -> float:
    """Ratio of the misfit without another factor than that of a unit to that with it."""
    world = comparison.worlds.of(Gyro(comparison.gyro.sign, unit))
    return max(constants_of(each.placed, world).misfit / each.constants.misfit for each in comparison.vectors)


def _tell_delays(comparison: SensorComparison, found: Findings, changes: Changes) -> None:
    for each in comparison.vectors:
        _tell_recurring(comparison, each, found)
    late = [
        each
        for each in comparison.vectors
        if each.delay.is_late and each.is_told and f"{each.sensor}_late" not in found.undecided
    ]
    alike = len(late) == 2 and late[0].delay.is_like(late[1].delay)
    if alike:
        mean = float(np.mean([each.delay.delay_s for each in late]))
        _name_late("gyro", -mean, (), comparison, found, changes)
    for each in comparison.vectors:
        delay = each.delay
        if each in late and each.sensor == "magnetometer":
            found.estimate("magnetometer_clock_offset", delay.delay_s, delay.sigma_s)
        others = [other.delay for other in comparison.vectors if other is not each]
        if each in late and not alike:
            unseen = len(late) == 1 and all(abs(o.delay_s - delay.delay_s) < o.unseen_s for o in others)
            or_else = ("gyro_late",) if unseen else ()
            _name_late(each.sensor, delay.delay_s, or_else, comparison, found, changes)
        elif each not in late and (abs(delay.delay_s) > MIN_DELAY_S or delay.unseen_s > DIM_DELAY_S):
            found.ask(f"{each.sensor}_late", f"a delay of the {each.sensor} of {delay.unseen_s:.2g} s is not seen")
        elif each not in late:
            text = f"the {each.sensor} is {delay.delay_s * 1e3:.3g} ms late against the gyro"
            found.note(f"{each.sensor}_late", text, delay.delay_s)


def _tell_recurring(comparison: SensorComparison, each: Compared, found: Findings) -> None:
    """List a delay that is another one as well, as the motion recurs."""
    if abs(each.delay.delay_s) <= MIN_DELAY_S:
        return
    world = comparison.worlds.of(comparison.gyro)
    others = other_delays(each.placed, comparison.verdict.best.gyro, world, each.delay)
    if others:
        text = ", ".join(f"{other:.3f} s" for other in (each.delay.delay_s, *others))
        found.ask(f"{each.sensor}_late", f"the motion recurs, so that {text} do as well")


def _name_late(
    sensor: str,
    delay_s: float,
    or_else: tuple[str, ...],
    comparison: SensorComparison,
    found: Findings,
    changes: Changes,
) -> None:
    text = f"the {sensor} is {delay_s * 1e3:.0f} ms late against the others"
    found.name(f"{sensor}_late", sensor, text, f"{-delay_s:+.4f} s", or_else=or_else, **comparison.misfits)
    changes[sensor].delay_s = delay_s


def _tell_hard_iron(each: Compared, found: Findings) -> None:
    constants = each.constants
    share = constants.offset_share
    found.note("field", f"the field has a size of {constants.size:.4g} in the readings' unit", constants.size)
    shape = constants.shape
    if each.is_told:
        found.estimate("magnetometer_hard_iron", constants.offset, constants.offset_sigma)
    if each.is_told and constants.misfit > MIN_GAIN * shape.misfit and np.all(shape.matrix_sigma < MAX_SHAPE_ERROR):
        soft_iron = np.linalg.inv(shape.matrix)
        found.note("soft_iron", f"soft iron, or unequal axes, of ({numerals(soft_iron.ravel())})", soft_iron)
        found.estimate("magnetometer_soft_iron", soft_iron, shape.matrix_sigma)
    if share > max(MIN_HARD_IRON, SIGMAS * constants.offset_share_sigma) and constants.offset_gain > MIN_GAIN:
        if each.is_told and shape.offset > MIN_HARD_IRON * constants.size / each.placed.misfits.vector.size:
            text = f"hard iron of ({numerals(constants.offset)}), {share:.2f} of the field"
            found.note("hard_iron", text, constants.offset)
        else:
            found.ask("hard_iron", f"an offset of {share:.2f} of the field, or soft iron, or other axes, are as good")
    if constants.seen < MIN_GAIN:
        found.ask("hard_iron", f"hard iron along ({components(constants.blind, 2)}) of the sensor is not seen")


def _tell_constant_and_unit(comparison: SensorComparison, each: Compared, found: Findings, changes: Changes) -> None:
    """Tell a constant that was taken off the accelerometer, and the unit in which its size is that of gravity."""
    constants = each.constants
    change = changes[each.sensor]
    if comparison.taken_off:
        given = numerals(-constants.offset)
        text = f"a constant of ({given}) in the sensor's axes was taken off: its mean, or its reading at rest"
        found.name("gravity_removed", each.sensor, text, f"+ ({given})", **comparison.misfits)
        change.offset = constants.offset
    size = constants.size
    unit, gravity = min(ACCELEROMETER_UNITS.items(), key=lambda item: abs(np.log(size / item[1])))
    away = abs(np.log(size / gravity))
    is_clear = constants.misfit <= MAX_UNIT_MISFIT and constants.seen >= MIN_GAIN
    is_sure = is_clear and SIGMAS * comparison.log_factor_sigma <= MAX_UNIT_LOG_ERROR
    if away >= SAME_UNIT:
        unit = "an unknown unit"
        gravity = size
    if SAME_UNIT <= away < OTHER_UNIT or (away >= OTHER_UNIT and not is_sure):
        for code in ("accelerometer_units", "gravity_removed"):
            found.ask(code, f"{size:.4g} of the accelerometer's readings is constant in the world")
    elif unit != "m/s²":
        text = f"the accelerometer reads {unit}: gravity is {size:.4g}"
        found.name("accelerometer_units", each.sensor, text, f"× {GRAVITY / gravity:.6g}")
        change.matrix *= GRAVITY / gravity


def _tell_rate_bias(comparison: SensorComparison, found: Findings) -> None:
    """Tell the bias of the gyro's readings that the vector with the least misfit shows, unless rest has told it."""
    best = min((each.constants for each in comparison.vectors), key=lambda constants: constants.misfit)
    bias = -best.rate_bias / comparison.gyro.multiplier
    if "gyro_bias" not in found.sensors:
        found.estimate("gyro_bias", bias, best.rate_bias_sigma / comparison.gyro.factor)
    shown = found.sensors["gyro_bias"].value
    found.note("gyro_bias", f"the gyro has a bias of ({numerals(np.degrees(shown))}) °/s", shown)


def tell_field_unit(size: float, found: Findings, changes: Changes) -> None:
    """Tell the unit of the magnetometer by the size of its readings.

    Parameters
    ----------
    size : float
        Median size of the readings, less their offset where that is told, in their unit.
    found : Findings
    changes : Changes
    """
    name, unit = min(
        MAGNETOMETER_UNITS.items(), key=lambda item: abs(np.log(size * item[1] / np.sqrt(np.prod(FIELDS_T))))
    )
    outside = max(FIELDS_T[0] / (size * unit), size * unit / FIELDS_T[1])
    if 1.0 < outside < FIELD_MARGIN:
        found.ask("magnetometer_units", f"the field is {size:.3g} in its unit, which may be {name}")
    elif outside >= FIELD_MARGIN:
        found.name("magnetometer_units", "magnetometer", f"the magnetometer reads counts: the field is {size:.4g}")
    elif name != "T":
        found.name(
            "magnetometer_units",
            "magnetometer",
            f"the magnetometer reads {name}: the field is {size:.4g}",
            f"× {unit:g}",
        )
        changes["magnetometer"].matrix *= unit
