"""Explanations of all vectors at once by few repairs, and the rule that chooses among them.

A common rotation of all sensors is not seen. With a gyro's sign s and turns P of the vectors, each C of 1 and these P
is as good a frame. The gyro's axes are s Cᵀ in it, those of a vector Cᵀ P.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, named
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
    """

    code: str
    sensor: str
    text: str = ""


class SensorExplanation(NamedTuple):
    """A hypothesis about all sensors.

    Attributes
    ----------
    repairs : tuple of SensorRepair
        Without delays, which are fitted.
    late : tuple of str
        Sensors with delays that the fit needs.
    fittings : tuple of Fitting
        Those of the vectors.
    """

    repairs: tuple[SensorRepair, ...]
    late: tuple[str, ...]
    fittings: tuple[Fitting, ...]

    @property
    def gyro(self) -> float:
        """Multiplier of the gyro."""
        return self.fittings[0].gyro

    @property
    def ratio(self) -> float:
        """Largest ratio of its vectors."""
        return max(each.ratio for each in self.fittings)

    @property
    def repair_count(self) -> int:
        """Number of repairs."""
        return len(self.repairs) + len(self.late)


class Judgement(NamedTuple):
    """Choice of the rule.

    Attributes
    ----------
    best : SensorExplanation
        Of the fewest repairs the first: without a change of the gyro, if there is one.
    named : tuple of SensorRepair
        Repairs of the best explanation that are named.
    others : tuple of tuple of SensorRepair
        Repairs of all explanations that do as well, or nearly so with fewer.
    is_open : bool
        Whether the log does not decide between these.
    turns_told : tuple of bool
        Whether the log tells the turn of each vector, and so its delay and offset: it is the same in all explanations,
        and none of fewer repairs does.
    fewer : bool
        Whether an explanation of fewer repairs is not excluded.
    """

    best: SensorExplanation
    named: tuple[SensorRepair, ...]
    others: tuple[tuple[SensorRepair, ...], ...]
    is_open: bool
    turns_told: tuple[bool, ...]
    fewer: bool

    @property
    def alternatives(self) -> dict[SensorRepair, None]:
        """Repairs of these explanations that are not named."""
        return dict.fromkeys(repair for each in self.others for repair in each if repair not in self.named)


def axes_text(matrix: Array) -> str:
    """Axes as a repair reads them: ``y x -z``."""
    return named(matrix).replace(",", "")


UNDONE: Final = {**GYRO_UNITS, **{axes_text(matrix): matrix for matrix in SIGNED_PERMUTATIONS}}
"""Factors and matrices that repairs are, by their texts."""


def factor_repair(factor: float) -> tuple[SensorRepair, ...]:
    """The repair that a factor of the gyro is: a unit, another factor, or none."""
    away, text, _ = nearest_unit(factor, GYRO_UNITS)
    if away >= MIN_LOG_FACTOR:
        return (SensorRepair("time_step", "gyro"),)
    return (SensorRepair("gyro_units", "gyro", text),) if text else ()


def axes_repairs(gyro: float, frame: int, turns: Mapping[str, int]) -> Iterator[SensorRepair]:
    """Repairs of the axes of all sensors that are not right, with one turn as the frame of all.

    Parameters
    ----------
    gyro : float
        In the sensors' own frame a gyro of the other sign is a left-handed frame.
    frame : int
    turns : mapping of str to int
        Those of all sensors; the gyro's is 0.
    """
    for sensor, turn in turns.items():
        text = _in_frame(frame, turn, np.sign(gyro) if sensor == "gyro" else 1.0)
        if text != "x y z":
            yield SensorRepair(f"{sensor}_axes", sensor, text)


@cache
def _in_frame(frame: int, turn: int, sign: float) -> str:
    return axes_text(sign * TURNS[frame].T @ TURNS[turn])


def _late(fittings: Iterable[Fitting]) -> tuple[str, ...]:
    """Sensors whose delays are repairs: two alike are one, of the gyro."""
    late = {each.misfits.sensor: each.delay_s for each in fittings if abs(each.delay_s) > MIN_DELAY_S}
    return ("gyro",) if len(late) == 2 and np.ptp([*late.values()]) < SAME_DELAY_S else tuple(late)


def _fittings(found: Misfits, gyro: float) -> Iterable[Fitting]:
    """Turns of a vector under one gyro that are not excluded, without a delay and with the best one."""
    delays, misfits = found.by_delay(gyro)
    ratios = misfits / found.best()[0]
    undelayed = np.where(np.abs(delays)[:, np.newaxis] > MIN_DELAY_S, np.inf, ratios)
    fittings = (
        Fitting(found, gyro, turn, delays[place], ratios[place, turn])
        for few in (undelayed, ratios)
        for turn, place in enumerate(few.argmin(axis=0))
    )
    return dict.fromkeys(each for each in fittings if each.ratio <= EXCLUDED)


def explanations(found: Iterable[Misfits], gyros: Iterable[float]) -> list[SensorExplanation]:
    """Explanations that are not excluded, of as few repairs as one needs that fits.

    Those of the fewest are first, among these those that leave the gyro, among these a known unit before any factor.
    """
    every: dict[object, SensorExplanation] = {}
    most = np.inf
    for gyro in gyros:
        factor = factor_repair(abs(gyro))
        if len(factor) > most:
            continue
        for fittings in product(*(_fittings(each, gyro) for each in found)):
            turns = {"gyro": 0, **{each.misfits.sensor: each.turn for each in fittings}}
            for frame in {*turns.values()}:
                new = SensorExplanation((*factor, *axes_repairs(gyro, frame, turns)), _late(fittings), fittings)
                every[new[:2]] = min(every.get(new[:2], new), new, key=lambda each: each.ratio)
                if new.ratio <= TOLD_APART:
                    most = min(most, new.repair_count)
    few = [each for each in every.values() if each.repair_count <= most < np.inf]
    return sorted(
        few,
        key=lambda each: (
            each.repair_count,
            *(any(what in repair for repair in each.repairs) for what in ("gyro", "time_step")),
            each.ratio,
        ),
    )


def judged(every: Sequence[SensorExplanation]) -> Judgement:
    """Apply the rule to the explanations that are not excluded.

    Parameters
    ----------
    every : sequence of SensorExplanation
        As `explanations` returns them, one at least.
    """
    best = next(each for each in every if each.ratio <= TOLD_APART)
    limit = EXCLUDED if best.repairs else TOLD_APART  # another delay alone excludes no repair
    as_few = [each for each in every if each.repair_count == best.repair_count and each.ratio <= limit]
    fewest = dict.fromkeys(each.repairs for each in as_few)
    fitting = {each.repairs for each in as_few if each.ratio <= TOLD_APART}
    fewer = [each.repairs for each in every if each.repair_count < best.repair_count and each.repairs not in fitting]
    is_open = len(fewest) > MAX_ALTERNATIVES or bool(fewer)
    others = (*fewest, *fewer)
    turns = zip(*[[fitting.turn for fitting in each.fittings] for each in as_few], strict=True)
    return Judgement(
        best,
        tuple(repair for repair in best.repairs if not is_open or all(repair in each for each in others)),
        others,
        is_open,
        tuple(len({*each}) == 1 and not fewer for each in turns),
        bool(fewer),
    )
