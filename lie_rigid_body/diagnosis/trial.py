"""Trials of repairs, and the one rule by which of all trials those are chosen that name the mistakes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.repairs import JOINT, ORDER, Repair
from lie_rigid_body.evaluation.causes import CAUSES, Track
from lie_rigid_body.wording import short_repr

FLOOR: Final = 0.1
"""Share of the turn between two readings below which errors count as equal, and nothing is looked for."""
MENDED: Final = 0.1
"""Share of the error that a repair may leave."""
HALVED: Final = 0.5
"""Share of the error that a repair may leave which brings it below the floor."""
NEAR: Final = 2.0
"""Factor within which errors above the floor count as equal."""

BY_CODE: Final = {cause.code: cause for cause in CAUSES}

Outputs = tuple[tuple[str, tuple[float, ...]], ...]
"""Repairs of the output: codes with their constants, in the order in which they are applied."""


def undo(track: Track, outputs: Outputs) -> Track:
    """A track with the causes of errors in the output undone."""
    for code, constants in outputs:
        track = BY_CODE[code].undo(track, np.array(constants))
    return track


@dataclass(frozen=True)
class Trial:
    """Runs with one kind of gyro and with repairs, and the error that they leave.

    Attributes
    ----------
    repairs : tuple of Repair
        Repairs of the input, with `JOINT` last where it is applied.
    outputs : tuple of (str, tuple of float)
        Repairs of the output.
    kind : str
        The kind of gyro.
    error : float
        RMS of the total error over the last two thirds of all runs, rad.
    parts : tuple of float
        RMS of the error of the vertical, and of that of the turns, rad, where it is known. One repair of two may take
        away one of these alone.
    """

    repairs: tuple[Repair, ...]
    outputs: Outputs
    kind: str
    error: float
    parts: tuple[float, ...] = ()

    __repr__ = short_repr

    @property
    def joint(self) -> bool:
        """Whether accelerometer and magnetometer come one sample later."""
        return JOINT in self.repairs

    @property
    def inputs(self) -> tuple[Repair, ...]:
        """The repairs of the input that are of mistakes."""
        return tuple(repair for repair in self.repairs if repair != JOINT)

    @property
    def codes(self) -> tuple[str, ...]:
        """The mistakes."""
        return (*(repair.code for repair in self.inputs), *(code for code, _ in self.outputs))

    @property
    def rank(self) -> tuple[int, int, list[int]]:
        """Number of repairs, price, and places in the table: the least is named."""
        price = sum(repair.price for repair in self.inputs) + sum(BY_CODE[code].price for code, _ in self.outputs)
        return len(self.codes), price, sorted(ORDER.index(code) for code in self.codes)

    @property
    def steps(self) -> list[tuple[tuple[Repair, ...], Outputs]]:
        """The repairs one after the other: the first, the first two, and so on, each with `JOINT` as it is here."""
        joint = (JOINT,) * self.joint
        inputs = [((*self.inputs[:count], *joint), ()) for count in range(1, len(self.inputs) + 1)]
        return inputs + [(self.repairs, self.outputs[:count]) for count in range(1, len(self.outputs) + 1)]


@dataclass(frozen=True)
class Choice:
    """The trial that names the mistakes, and those that do as well with as many repairs."""

    named: Trial
    others: tuple[Trial, ...]

    __repr__ = short_repr

    def or_else(self, code: str) -> tuple[str, ...]:
        """Codes that stand in the place of one of the named ones where the others stay."""
        rest = set(self.named.codes) - {code}
        found = [set(other.codes) - rest for other in self.others if rest <= set(other.codes)]
        return tuple(sorted(set().union(*found) - set(self.named.codes), key=ORDER.index))


def plain(trials: Iterable[Trial], *, joint: bool | None = None) -> Trial:
    """The filter without a repair, with the kind of gyro that it expects; `JOINT` is none."""
    return min((t for t in trials if not t.codes and joint in (None, t.joint)), key=lambda t: t.error)


def choose(trials: Sequence[Trial], floor: float) -> Choice | None:
    """The repairs that are named, if any mend the error.

    Parameters
    ----------
    trials : sequence of Trial
        At least those without a repair.
    floor : float
        The error below which all count as equal, rad.
    """
    before = plain(trials).error
    if before <= floor:
        return None
    limit = max(MENDED * before, min(floor, HALVED * before))
    mending = [t for t in trials if t.codes and t.error <= limit]
    if not mending:
        return None
    best = min(t.error for t in mending)
    as_good = [t for t in mending if t.error <= (floor if best <= floor else NEAR * best)]
    named = min(as_good, key=lambda t: (t.rank, t.error))
    return Choice(named, tuple(t for t in as_good if len(t.codes) == len(named.codes) and t.codes != named.codes))
