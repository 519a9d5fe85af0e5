"""Explanations of all vectors at once by few repairs, and the rule that chooses among them.

A common rotation of all sensors is not seen. With a gyro's sign s and turns P of the vectors, each C of 1 and these P
is as good a frame. The gyro's axes are s Cᵀ in it, those of a vector Cᵀ P.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from lie_rigid_body.evaluation.attitudes import named
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    DEGREE,
    EXCLUDED,
    MAX_ALTERNATIVES,
    MIN_DELAY_S,
    MIN_LOG_FACTOR,
    SAME_DELAY_S,
    TOLD_APART,
    TURNS,
    Gyro,
)
from lie_rigid_body.inspection.search import Misfits


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


class Fitting(NamedTuple):
    """One vector under one gyro.

    Attributes
    ----------
    turn : int
        Index in `TURNS`.
    delay_s : float
    ratio : float
        Misfit over the least one of this vector.
    is_late : bool
        Whether the delay is a repair.
    """

    turn: int
    delay_s: float
    ratio: float
    is_late: bool


@dataclass(frozen=True)
class SensorExplanation:
    """A hypothesis about all sensors.

    Attributes
    ----------
    ratio : float
        Largest ratio of its vectors.
    repairs : tuple of SensorRepair
        Without delays, which are fitted.
    late : tuple of SensorRepair
        Delays that the fit needs.
    gyro : Gyro
    frame : int
        Turn C of the common frame.
    fittings : tuple of Fitting
        Of each vector.
    """

    ratio: float
    repairs: tuple[SensorRepair, ...]
    late: tuple[SensorRepair, ...]
    gyro: Gyro
    frame: int
    fittings: tuple[Fitting, ...]

    @property
    def count(self) -> int:
        """Number of repairs."""
        return len(self.repairs) + len(self.late)

    @property
    def keeps_gyro(self) -> bool:
        """Whether the readings of the gyro stay as they are."""
        return all(repair.sensor != "gyro" for repair in self.repairs)


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
        Of each vector: whether its turn is the same in all explanations.
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
    size = np.log(factor)
    if abs(size) < MIN_LOG_FACTOR:
        return ()
    if abs(abs(size) + np.log(DEGREE)) < MIN_LOG_FACTOR:
        return (SensorRepair("gyro_units", "gyro", "× π/180" if size < 0.0 else "× 180/π"),)
    return (SensorRepair("time_step", "gyro"),)


def axes_repairs(names: Sequence[str], sign: int, frame: int, turns: Sequence[int]) -> tuple[SensorRepair, ...]:
    """Repairs of axes, with one turn as the frame of all.

    Parameters
    ----------
    names : sequence of str
        Sensors of the vectors.
    sign : int
        Sign of the gyro; in the sensors' own frame a gyro of the other sign is a left-handed frame.
    frame : int
    turns : sequence of int
        Of each vector.
    """
    back = TURNS[frame].T
    matrices = {"gyro": sign * back, **{name: back @ TURNS[turn] for name, turn in zip(names, turns, strict=True)}}
    return tuple(
        SensorRepair(f"{name}_axes", name, axes_text(matrix))
        for name, matrix in matrices.items()
        if not np.array_equal(matrix, np.eye(3))
    )


def _late_repairs(names: Sequence[str], fittings: Sequence[Fitting]) -> tuple[SensorRepair, ...]:
    """Delays that are repairs: two alike are one, of the gyro."""
    late = [(name, each.delay_s) for name, each in zip(names, fittings, strict=True) if each.is_late]
    if len(late) == 2 and abs(late[0][1] - late[1][1]) < SAME_DELAY_S:
        return (SensorRepair("gyro_late", "gyro"),)
    return tuple(SensorRepair(f"{name}_late", name) for name, _ in late)


def _fittings(found: Misfits, gyro: Gyro) -> list[Fitting]:
    """Turns of a vector under one gyro that are not excluded, without a delay and with the best one."""
    delays, misfits = found.by_delay(gyro)
    if not len(delays):
        return []
    short = np.flatnonzero(np.abs(delays) <= MIN_DELAY_S)
    least = found.least
    fittings = []
    for turn, best in enumerate(misfits.argmin(axis=0)):
        plain = short[misfits[short, turn].argmin()]
        places = [(plain, False)] if best in short else [(plain, False), (best, True)]
        for place, is_late in places:
            ratio = float(misfits[place, turn]) / least
            if ratio <= EXCLUDED:
                fittings.append(Fitting(turn, float(delays[place]), ratio, is_late))
    return fittings


def _combinations(options: Sequence[Sequence[Fitting]], most: int) -> Iterator[tuple[int, tuple[Fitting, ...]]]:
    """Frames, each that of a sensor, and fittings of all vectors with at most so many repairs of axes."""
    for frame in sorted({0, *(fitting.turn for each in options for fitting in each)}):
        left = most - (frame != 0)
        near = [[fitting for fitting in each if fitting.turn == frame or left > 0] for each in options]
        for fittings in product(*near):
            turned = sum(fitting.turn != frame for fitting in fittings)
            if turned <= left and (frame == 0 or turned < len(fittings)):
                yield frame, fittings


def explanations(found: Sequence[Misfits], gyros: Sequence[Gyro]) -> list[SensorExplanation]:
    """Explanations that are not excluded, of as few repairs as one needs that fits, those of the fewest first.

    More repairs of axes and factors are only looked for while fewer have none that fits.
    """
    names = [each.vector.sensor for each in found]
    options = {gyro: [_fittings(each, gyro) for each in found] for gyro in gyros}
    for most in range(len(found) + 3):
        every: dict[tuple[tuple[SensorRepair, ...], tuple[SensorRepair, ...]], SensorExplanation] = {}
        for gyro in gyros:
            factor = factor_repair(gyro.factor)
            for frame, fittings in _combinations(options[gyro], most - len(factor)):
                axes = axes_repairs(names, gyro.sign, frame, [fitting.turn for fitting in fittings])
                late = _late_repairs(names, fittings)
                ratio = max(fitting.ratio for fitting in fittings)
                new = SensorExplanation(ratio, (*factor, *axes), late, gyro, frame, fittings)
                key = new.repairs, new.late
                if new.count <= most and (key not in every or ratio < every[key].ratio):
                    every[key] = new
        if any(each.ratio <= TOLD_APART for each in every.values()):
            return sorted(every.values(), key=lambda each: (each.count, not each.keeps_gyro, each.ratio))
    return []


def judged(every: Sequence[SensorExplanation]) -> Judgement:
    """Apply the rule to the explanations that are not excluded.

    Parameters
    ----------
    every : sequence of SensorExplanation
        As `explanations` returns them, one at least.
    """
    fit = [each for each in every if each.ratio <= TOLD_APART]
    best = fit[0]
    same = [each for each in fit if each.count == best.count]
    fewest = list(dict.fromkeys(each.repairs for each in same))
    fewer = [each for each in every if each.count < best.count and each.repairs not in fewest]
    if fewest != [()]:
        fewest = list(dict.fromkeys([*fewest, *(each.repairs for each in every if each.count == best.count)]))
    shared = [repair for repair in best.repairs if all(repair in repairs for repairs in fewest)]
    is_few = len(fewest) <= MAX_ALTERNATIVES
    among = [each for each in every if each.count == best.count and each.repairs in fewest]
    counts = [len({each.fittings[i].turn for each in among}) for i in range(len(best.fittings))]
    named_ones = () if fewer else best.repairs if is_few else tuple(shared)
    open_ones = [*fewest, *(each.repairs for each in fewer)] if fewer else [] if is_few else fewest
    return Judgement(
        best,
        tuple(named_ones),
        tuple(repairs for repairs in fewest if repairs != best.repairs) if is_few and not fewer else (),
        tuple(dict.fromkeys(repair for repairs in open_ones for repair in repairs if repair not in named_ones)),
        tuple(count == 1 for count in counts),
        bool(fewer),
    )
