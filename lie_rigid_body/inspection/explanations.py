"""Explanations of all vectors at once by few repairs, and the rule that chooses among them.

A common rotation of all sensors is not seen. With a gyro's sign s and turns P of the vectors, each C of 1 and these P
is as good a frame. The gyro's axes are s Cᵀ in it, those of a vector Cᵀ P.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from lie_rigid_body.evaluation.attitudes import named
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    EXCLUDED,
    GYRO_UNITS,
    MAX_ALTERNATIVES,
    MIN_DELAY_S,
    MIN_LOG_FACTOR,
    SAME_DELAY_S,
    TOLD_APART,
    TURNS,
    Gyro,
    nearest_unit,
)
from lie_rigid_body.inspection.search import Fitting, Misfits


class SensorRepair(NamedTuple):
    """A repair of one sensor.

    Attributes
    ----------
    code : str
        The mistake that it undoes.
    sensor : str
    text : str
        The repair in a few characters, such as ``y x -z``; empty where a constant is fitted.
    unit : float
        Factor of a unit.
    """

    code: str
    sensor: str
    text: str = ""
    unit: float = 1.0


@dataclass(frozen=True)
class SensorExplanation:
    """A hypothesis about all sensors.

    Attributes
    ----------
    repairs : tuple of SensorRepair
        Without delays, which are fitted.
    late : tuple of str
        Sensors with delays that the fit needs.
    gyro : Gyro
    axes : mapping of str to ndarray, shape (3, 3)
        Axes of each sensor in the common frame.
    fittings : tuple of Fitting
        Those of the vectors.
    """

    repairs: tuple[SensorRepair, ...]
    late: tuple[str, ...]
    gyro: Gyro
    axes: Mapping[str, Array]
    fittings: tuple[Fitting, ...]

    @property
    def ratio(self) -> float:
        """Largest ratio of its vectors."""
        return max(each.ratio for each in self.fittings)

    @property
    def count(self) -> int:
        """Number of repairs."""
        return len(self.repairs) + len(self.late)

    def changes(self, what: str) -> bool:
        """Whether a repair is of a sensor, or has a code."""
        return any(what in each[:2] for each in self.repairs)


@dataclass(frozen=True)
class Judgement:
    """Choice of the rule.

    Attributes
    ----------
    best : SensorExplanation
        Of the fewest repairs the first: without a change of the gyro, if there is one.
    named : tuple of SensorRepair
        Repairs of the best explanation that are named.
    or_else : tuple of tuple of SensorRepair
        Repairs of other explanations that do as well.
    undecided : tuple of SensorRepair
        Repairs between which the log does not decide.
    turns_told : tuple of bool
        Whether the log tells the turn of each vector, and so its delay and offset: it is the same in all explanations,
        and none of fewer repairs does.
    fewer : bool
        Whether an explanation of fewer repairs is not excluded.
    """

    best: SensorExplanation
    named: tuple[SensorRepair, ...]
    or_else: tuple[tuple[SensorRepair, ...], ...]
    undecided: tuple[SensorRepair, ...]
    turns_told: tuple[bool, ...]
    fewer: bool


def axes_text(matrix: Array) -> str:
    """Axes as a repair reads them: ``y x -z``."""
    return named(matrix).replace(",", "")


def factor_repair(factor: float) -> tuple[SensorRepair, ...]:
    """The repair that a factor of the gyro is: a unit, another factor, or none."""
    text, unit, away = nearest_unit(factor, GYRO_UNITS)
    if away >= MIN_LOG_FACTOR:
        return (SensorRepair("time_step", "gyro"),)
    return (SensorRepair("gyro_units", "gyro", text, unit),) if text else ()


def axes_of(sign: int, frame: int, turns: Mapping[str, int]) -> dict[str, Array]:
    """Axes of all sensors, with one turn as the frame of all: the identity for those that are right.

    Parameters
    ----------
    sign : int
        Sign of the gyro; in the sensors' own frame a gyro of the other sign is a left-handed frame.
    frame : int
    turns : mapping of str to int
        Those of the vectors, by their sensors.
    """
    back = TURNS[frame].T
    return {"gyro": sign * back, **{sensor: back @ TURNS[turn] for sensor, turn in turns.items()}}


def axes_repairs(axes: Mapping[str, Array]) -> tuple[SensorRepair, ...]:
    """Repairs of axes that are not right."""
    texts = {name: axes_text(matrix) for name, matrix in axes.items()}
    return tuple(SensorRepair(f"{name}_axes", name, text) for name, text in texts.items() if text != "x y z")


def _late(fittings: Sequence[Fitting]) -> tuple[str, ...]:
    """Sensors whose delays are repairs: two alike are one, of the gyro."""
    late = {each.sensor: each.delay_s for each in fittings if each.is_late}
    return ("gyro",) if len(late) == 2 and np.ptp([*late.values()]) < SAME_DELAY_S else tuple(late)


def _fittings(found: Misfits, gyro: Gyro) -> list[Fitting]:
    """Turns of a vector under one gyro that are not excluded, without a delay and with the best one."""
    delays, misfits = found.by_delay(gyro)
    ratios = misfits / found.best()[0]
    short = np.flatnonzero(np.abs(delays) <= MIN_DELAY_S)
    fittings = []
    for turn, best in enumerate(ratios.argmin(axis=0)):
        plain = short[ratios[short, turn].argmin()]
        for place in {plain, best}:
            numbers = float(delays[place]), float(ratios[place, turn])
            fittings.append(Fitting(found, gyro, turn, *numbers, is_late=place not in short))
    return [each for each in fittings if each.ratio <= EXCLUDED]


def explanations(found: Sequence[Misfits], gyros: Sequence[Gyro]) -> list[SensorExplanation]:
    """Explanations that are not excluded, of as few repairs as one needs that fits.

    Those of the fewest are first, among these those that leave the gyro, among these a known unit before any factor.
    """
    every: dict[object, SensorExplanation] = {}
    most = np.inf
    for gyro in gyros:
        factor = factor_repair(gyro.factor)
        for fittings in product(*(_fittings(each, gyro) for each in found)):
            turns = {each.sensor: each.turn for each in fittings}
            for frame in sorted({0, *turns.values()}):
                turned = sum(turn != frame for turn in turns.values()) + (frame != 0 or gyro.sign < 0)
                if len(factor) + turned > most:
                    continue
                axes = axes_of(gyro.sign, frame, turns)
                new = SensorExplanation((*factor, *axes_repairs(axes)), _late(fittings), gyro, axes, fittings)
                known = every.setdefault((new.repairs, new.late), new)
                every[new.repairs, new.late] = min(known, new, key=lambda each: each.ratio)
                if new.ratio <= TOLD_APART:
                    most = min(most, new.count)
    few = [each for each in every.values() if each.count <= most < np.inf]
    return sorted(few, key=lambda each: (each.count, *map(each.changes, ("gyro", "time_step")), each.ratio))


def judged(every: Sequence[SensorExplanation]) -> Judgement:
    """Apply the rule to the explanations that are not excluded.

    Parameters
    ----------
    every : sequence of SensorExplanation
        As `explanations` returns them, one at least.
    """
    fit = [each for each in every if each.ratio <= TOLD_APART]
    best = fit[0]
    limit = EXCLUDED if best.repairs else TOLD_APART  # another delay alone excludes no repair
    as_few = [each for each in every if each.count == best.count and each.ratio <= limit]
    fewest = list(dict.fromkeys([best.repairs, *(each.repairs for each in as_few)]))
    fitting = {each.repairs for each in fit if each.count == best.count}
    fewer = [each.repairs for each in every if each.count < best.count and each.repairs not in fitting]
    is_open = len(fewest) > MAX_ALTERNATIVES or bool(fewer)
    every_one = {repair: None for repairs in (*fewest, *fewer) for repair in repairs}
    shared = [repair for repair in best.repairs if all(repair in repairs for repairs in (*fewest, *fewer))]
    named_ones = tuple(shared) if is_open else best.repairs
    turns = zip(*[[fitting.turn for fitting in each.fittings] for each in as_few], strict=True)
    return Judgement(
        best,
        named_ones,
        () if is_open else tuple(fewest[1:]),
        tuple(repair for repair in every_one if repair not in named_ones) if is_open else (),
        tuple(len({*each}) == 1 and not fewer for each in turns),
        bool(fewer),
    )
