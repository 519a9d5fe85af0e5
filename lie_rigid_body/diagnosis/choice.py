"""The one rule by which repairs are chosen."""

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
UNCHANGED: Final = 1e-6
"""Change of the estimate, rad, below which a repair is none."""

PRICES: Final = {cause.code: cause.price for cause in CAUSES}
BY_CODE: Final = {cause.code: cause for cause in CAUSES}


Outputs = tuple[tuple[str, tuple[float, ...]], ...]
"""Repairs of the output: codes with their constants, in the order in which they are applied."""


def undo(track: Track, outputs: Outputs) -> Track:
    """A track with the causes of errors in the output undone."""
    for code, constants in outputs:
        track = BY_CODE[code].undo(track, np.array(constants))
    return track


@dataclass(frozen=True)
class Candidate:
    """Repairs, and the error that they leave.

    Attributes
    ----------
    repairs : tuple of Repair
        Repairs of the input, with `JOINT` last where it is applied.
    outputs : tuple of (str, tuple of float)
        Repairs of the output.
    error : float
        RMS of the total error over the runs of one kind of gyro, rad.
    kind : str
        That kind.
    partial : tuple of float
        Errors that one repair of two may take away alone, rad: of the vertical, and of the turns.
    """

    repairs: tuple[Repair, ...]
    outputs: Outputs
    error: float
    kind: str
    partial: tuple[float, ...] = ()

    __repr__ = short_repr

    @property
    def joint(self) -> bool:
        """Whether readings come one sample later."""
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
        price = sum(repair.price for repair in self.inputs) + sum(PRICES[code] for code, _ in self.outputs)
        return len(self.codes), price, sorted(ORDER.index(code) for code in self.codes)


@dataclass(frozen=True)
class Choice:
    """What is named, and what does as well with as many repairs."""

    named: Candidate
    others: tuple[Candidate, ...]

    __repr__ = short_repr

    def or_else(self, code: str) -> tuple[str, ...]:
        """Codes that stand in the place of one of the named ones where the others stay."""
        rest = set(self.named.codes) - {code}
        found = [set(other.codes) - rest for other in self.others if rest <= set(other.codes)]
        return tuple(sorted({c for codes in found for c in codes} - set(self.named.codes), key=ORDER.index))


def plain_error(found: Iterable[Candidate], *, joint: bool | None = None) -> Candidate:
    """The filter without a repair, for the kind of gyro that it expects; `JOINT` is none."""
    return min((c for c in found if not c.codes and joint in (None, c.joint)), key=lambda c: c.error)


def choose(found: Sequence[Candidate], floor: float) -> Choice | None:
    """The repairs that are named, if any mend the error.

    Parameters
    ----------
    found : sequence of Candidate
        At least those without a repair.
    floor : float
        The error below which all count as equal, rad.
    """
    before = plain_error(found).error
    if before <= floor:
        return None
    mending = [c for c in found if c.codes and (c.error <= MENDED * before or c.error <= min(floor, HALVED * before))]
    if not mending:
        return None
    best = min(c.error for c in mending)
    near = [c for c in mending if c.error <= (floor if best <= floor else NEAR * best)]
    named = min(near, key=lambda c: (c.rank, c.error))
    return Choice(named, tuple(c for c in near if len(c.codes) == len(named.codes) and c.codes != named.codes))
