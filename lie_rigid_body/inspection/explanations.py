"""Explanations of all vectors at once by few repairs, and the rule that chooses among them.

A common rotation of all sensors is not seen. With a gyro's sign s and turns P of the vectors, each C of 1 and these P
is as good a frame. The gyro's axes are s Cᵀ in it, those of a vector Cᵀ P.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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
    axes : mapping of str to ndarray, shape (3, 3)
        Axes of each sensor in the common frame.
    fittings : tuple of Fitting
        Those of the vectors.
    """

    ratio: float
    repairs: tuple[SensorRepair, ...]
    late: tuple[SensorRepair, ...]
    gyro: Gyro
    axes: Mapping[str, Array]
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
    size = np.log(factor)
    if abs(size) < MIN_LOG_FACTOR:
        return ()
    if abs(abs(size) + np.log(DEGREE)) < MIN_LOG_FACTOR:
        return (SensorRepair("gyro_units", "gyro", "× π/180" if size < 0.0 else "× 180/π"),)
    return (SensorRepair("time_step", "gyro"),)


def axes_of(names: Sequence[str], sign: int, frame: int, turns: Sequence[int]) -> dict[str, Array]:
    """Axes of all sensors, with one turn as the frame of all: the identity for those that are right.

    Parameters
    ----------
    names : sequence of str
        Sensors of the vectors.
    sign : int
        Sign of the gyro; in the sensors' own frame a gyro of the other sign is a left-handed frame.
    frame : int
    turns : sequence of int
        Those of the vectors.
    """
    back = TURNS[frame].T
    return {"gyro": sign * back, **{name: back @ TURNS[turn] for name, turn in zip(names, turns, strict=True)}}


def axes_repairs(axes: Mapping[str, Array]) -> tuple[SensorRepair, ...]:
    """Repairs of axes that are not right."""
    texts = {name: axes_text(matrix) for name, matrix in axes.items()}
    return tuple(SensorRepair(f"{name}_axes", name, text) for name, text in texts.items() if text != "x y z")


def _late_repairs(names: Sequence[str], fittings: Sequence[Fitting]) -> tuple[SensorRepair, ...]:
    """Delays that are repairs: two alike are one, of the gyro."""
    late = [(name, each.delay_s) for name, each in zip(names, fittings, strict=True) if each.is_late]
    if len(late) == 2 and abs(late[0][1] - late[1][1]) < SAME_DELAY_S:
        return (SensorRepair("gyro_late", "gyro"),)
    return tuple(SensorRepair(f"{name}_late", name) for name, _ in late)


def _fittings(found: Misfits, gyro: Gyro) -> list[Fitting]:
    """Turns of a vector under one gyro that are not excluded, without a delay and with the best one."""
    delays, misfits = found.by_delay(gyro)
    ratios = misfits / found.best()[0]
    short = np.flatnonzero(np.abs(delays) <= MIN_DELAY_S)
    fittings = []
    for turn, best in enumerate(ratios.argmin(axis=0)):
        plain = short[ratios[short, turn].argmin()]
        for place in [plain] if best in short else [plain, best]:
            fittings.append(Fitting(turn, float(delays[place]), float(ratios[place, turn]), place not in short))
    return [each for each in fittings if each.ratio <= EXCLUDED]


def _combinations(options: Sequence[Sequence[Fitting]], most: int) -> Iterator[tuple[int, tuple[Fitting, ...]]]:
    """Frames, each that of a sensor, and fittings of all vectors with at most so many repairs of axes."""
    for frame in sorted({0, *(fitting.turn for each in options for fitting in each)}):
        left = most - (frame != 0)
        near = [[fitting for fitting in each if fitting.turn == frame or left > 0] for each in options]
        for fittings in product(*near):
            if sum(fitting.turn != frame for fitting in fittings) <= left:
                yield frame, fittings


def explanations(found: Sequence[Misfits], gyros: Sequence[Gyro]) -> list[SensorExplanation]:
    """Explanations that are not excluded, of as few repairs as one needs that fits, those of the fewest first.

    More repairs of axes and factors are only looked for while fewer have none that fits.
    """
    names = [each.vector.sensor for each in found]
    options = {gyro: [_fittings(each, gyro) for each in found] for gyro in gyros}
    for most in range(len(found) + 3):
        every: dict[object, SensorExplanation] = {}
        for gyro, of_gyro in options.items():
            factor = factor_repair(gyro.factor)
            for frame, fittings in _combinations(of_gyro, most - len(factor)):
                axes = axes_of(names, gyro.sign, frame, [fitting.turn for fitting in fittings])
                ratio = max(fitting.ratio for fitting in fittings)
                repairs = (*factor, *axes_repairs(axes))
                new = SensorExplanation(ratio, repairs, _late_repairs(names, fittings), gyro, axes, fittings)
                known = every.get((new.repairs, new.late))
                if new.count <= most and (known is None or ratio < known.ratio):
                    every[new.repairs, new.late] = new
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
    best = next(each for each in every if each.ratio <= TOLD_APART)
    as_few = [each for each in every if each.count == best.count]
    if not any(each.repairs for each in as_few if each.ratio <= TOLD_APART):
        as_few = [each for each in as_few if each.ratio <= TOLD_APART]  # nothing is named of what is right
    fewest = list(dict.fromkeys(each.repairs for each in as_few))
    fewer = [each.repairs for each in every if each.count < best.count and each.repairs not in fewest]
    named_ones: Sequence[SensorRepair] = ()
    others: list[tuple[SensorRepair, ...]] = []
    if not fewer and len(fewest) <= MAX_ALTERNATIVES:
        named_ones = best.repairs
        others = [repairs for repairs in fewest if repairs != best.repairs]
        fewest = []
    elif not fewer:
        named_ones = [repair for repair in best.repairs if all(repair in repairs for repairs in fewest)]
    open_ones = dict.fromkeys(repair for repairs in (*fewest, *fewer) for repair in repairs)
    turns = zip(*[[fitting.turn for fitting in each.fittings] for each in as_few], strict=True)
    return Judgement(
        best,
        tuple(named_ones),
        tuple(others),
        tuple(repair for repair in open_ones if repair not in named_ones),
        tuple(len({*each}) == 1 and not fewer for each in turns),
        bool(fewer),
    )
